//! Lens subpath mutation (Veach 11.4.4): deletes the lens subpath, from the eye through Dirac vertices to the first rough one, and joins
//! the rest of the path to another that is sampled anew, anywhere on the image and of any number of Dirac vertices.
//!
//! For suffixes `(L|D) D S* E`, written from the light, and for whole paths `L S* E` whose chain ends on the light, as for the lens
//! perturbation. The rest of the path is what both paths have in common, so the same vertices are deleted on the way back.
//!
//! At a surface with Dirac components and rough ones too, the BSDF's own choice says whether the subpath goes on or ends there; the
//! probability of ending is part of the density.
//!
//! # Strata
//!
//! Veach gives every pixel as many of these subpaths, by a tally, and uses each of them for several chains. Here the image point is uniform
//! and each subpath is made for one mutation, for these reasons.
//!
//! With a given subpath z the move to it has no way back: it is accepted by R(z) / R(x), and nothing leaves z. Only the mean over
//! all z, drawn with their density and without regard to where the chain is, keeps the target, and so do several steps only if their z are
//! independent of each other: the mean of a product of kernels is the product of their means then, and else it is not. A tally over the steps
//! of one chain makes them dependent. To visit strata in turn does so too, and a stratum of one's own for every chain reaches only a part of
//! the image.
//! What is left free is how the subpaths of *different* chains go together, because an estimate is a sum over chains, each with the right law of
//! its own. Veach's tally is nearly that, as he runs thousands of chains in rotation and no chain sees many entries of it.
//! But chains here run each for itself, so that any number of threads gives the same picture, and have no common subpath to use again.

use ergodic_metropolis::{Density, RandomSource};
use ergodic_pathspace::{Path, PathSpace, Vertex, density};
use ergodic_scattering::{Component, Repertoire};
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::chains::{follow, trace, trace_sight};
use crate::{PathMutation, Registered, Rejection, Splice, eye_side, wavelength};

/// Lens subpath mutation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct LensSubpath {}

/// What a lens subpath does at a vertex, of which light goes on to `w_eye`: the probabilities of the Dirac components, and of ending.
struct Choice {
    reflection: f64,
    transmission: f64,
    end: f64,
}

impl Choice {
    #[inline]
    fn at<R: Repertoire>(vertex: &Vertex<R>, w_eye: DVec3) -> Self {
        let [reflection, transmission] = vertex.interaction.dirac_probabilities(w_eye);
        let end = if reflection + transmission <= 0.0 {
            // Also on the environment, and on lights that scatter nothing.
            1.0
        } else if vertex.interaction.has_rough() {
            (1.0 - reflection - transmission).max(0.0)
        } else {
            0.0
        };
        Self { reflection, transmission, end }
    }

    /// The component that goes on, or that of an end.
    #[inline]
    fn draw(&self, rng: &mut impl RandomSource) -> Component {
        if self.end == 1.0 {
            return Component::Rough;
        }
        let u = rng.uniform();
        if u < self.reflection {
            Component::DiracReflection
        } else if u < self.reflection + self.transmission || self.end == 0.0 {
            Component::DiracTransmission
        } else {
            Component::Rough
        }
    }
}

impl LensSubpath {
    /// Where the lens subpath of a path ends, if it can be deleted and sampled again.
    #[inline]
    fn end<R: Repertoire>(x: &Path<R>) -> Option<usize> {
        // A light that is a mirror too, and nothing else, ends no subpath.
        eye_side::start(x).filter(|&end| end > 0 || Self::end_probability(x, 0) > 0.0)
    }

    #[inline]
    fn end_probability<R: Repertoire>(x: &Path<R>, end: usize) -> f64 {
        Choice::at(&x.vertices[end], x.edges[end].direction).end
    }

    /// What is kept: a pinhole too, and the direction of an orthographic camera.
    #[inline]
    fn plan<R: Repertoire>(space: &PathSpace<R>, end: usize) -> Splice {
        Splice { prefix: end, suffix: usize::from(!space.scene.camera().has_aperture()) }
    }
}

impl Registered for LensSubpath {
    const WEIGHT: f64 = 0.0;

    fn validate(&self) -> Result<(), String> {
        Ok(())
    }
}

impl PathMutation for LensSubpath {
    fn suitability<R: Repertoire>(&self, _space: &PathSpace<R>, x: &Path<R>) -> f64 {
        if Self::end(x).is_some() { 1.0 } else { 0.0 }
    }

    fn propose<R: Repertoire>(
        &self,
        space: &PathSpace<R>,
        x: &Path<R>,
        y: &mut Path<R>,
        rng: &mut impl RandomSource,
    ) -> Result<Splice, Rejection> {
        let scene = &space.scene;
        let camera = scene.camera();
        let end = Self::end(x).ok_or(Rejection::WrongComponent)?;
        let plan = Self::plan(space, end);
        y.begin(x, end, 2 - plan.suffix, plan.suffix);
        y.wavelength = wavelength::draw(scene, x, plan, rng);
        if plan.suffix == 0 {
            y.vertices[end + 1] = scene.sample_eye(rng);
        }
        let raster = camera.sample_raster([rng.uniform(), rng.uniform()]);
        let sight = camera.sight(y.vertices[end + 1].position, raster);
        trace_sight(scene, y, &sight, rng)?;
        // The newest vertex is always vertex `end`, and the others move on.
        loop {
            let w_eye = y.edges[end].direction;
            let component = Choice::at(&y.vertices[end], w_eye).draw(rng);
            if component == Component::Rough {
                break;
            }
            if y.length() == space.lengths.max_edges {
                return Err(Rejection::NoLength);
            }
            let w = follow(&mut y.vertices[end], w_eye, component)?;
            y.open_before(end);
            trace(scene, y, end + 1, end, w, rng)?;
        }
        if y.length() < space.lengths.min_edges {
            return Err(Rejection::NoLength);
        }
        y.vertices[end].component = Component::Rough;
        eye_side::join(scene, y, end)?;
        Ok(plan)
    }

    /// The density of the walk from the eye, times the probability that it ends where it does.
    fn density<R: Repertoire>(&self, space: &PathSpace<R>, from: &Path<R>, to: &Path<R>, plan: Splice) -> Density {
        let scene = &space.scene;
        let end = plan.prefix;
        if Self::end(from) != Some(end) || Self::end(to) != Some(end) || plan != Self::plan(space, end) {
            return Density::ZERO;
        }
        let mut density = Density::ONE;
        density.multiply(wavelength::pdf_of_draw(scene, from, to, plan));
        density.multiply(Self::end_probability(to, end));
        for i in end..to.vertices.len() - plan.suffix {
            density.multiply(density::pdf_area_from_eye(scene, to, i));
        }
        density
    }
}
