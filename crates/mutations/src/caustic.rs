//! Caustic perturbation (Veach 11.4.3.2): turns the direction in which light leaves the last connectable vertex before a
//! Dirac chain, traces it to the vertex that the eye sees, and connects that to the eye. Light from infinitely far away keeps its
//! direction and is shifted sideways instead.
//!
//! For suffixes `(L|D) S* D E`, written from the light.

use ergodic_geometry::Frame;
use ergodic_metropolis::{Density, RandomSource};
use ergodic_pathspace::{End, Path, PathSpace};
use ergodic_scattering::{Component, Repertoire};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::chains::{connect, dirac_factor, follow};
use crate::jump::JumpRange;
use crate::retrace::{conversion, length, perturb_length, retrace};
use crate::{PathMutation, Registered, Rejection, Splice, validate_image_jump, wavelength};

/// Caustic perturbation.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Caustic {
    /// Smallest move, as the pixels that it amounts to on the image (r₁).
    pub min_pixels: f64,
    /// Largest move, as the share of the image's area of a disk of that radius.
    pub image_share: f64,
}

impl Default for Caustic {
    fn default() -> Self {
        Self { min_pixels: 0.1, image_share: 0.05 }
    }
}

/// The largest angle a direction is turned by, in radians, however short the edge to the eye is.
const MAX_ANGLE: f64 = 1.5;

impl Caustic {
    /// The vertex whose outgoing direction is turned.
    fn start<R: Repertoire>(x: &Path<R>) -> Option<usize> {
        let k = x.length();
        if k < 2 || x.vertices[k - 1].component != Component::Rough {
            return None;
        }
        Some((1..k - 1).rev().find(|&i| x.vertices[i].component == Component::Rough).unwrap_or(0))
    }

    /// The range of angles, which depends on the path: pixels carried through |x_{k-1} - x_k| over the summed length of
    /// the edges that move. From infinitely far away it is a range of lengths: the pixels' size at x_{k-1}.
    #[inline(always)]
    fn range<R: Repertoire>(&self, space: &PathSpace<R>, x: &Path<R>, start: usize) -> JumpRange {
        let k = x.length();
        let size_of_pixel = space.scene.camera().length_per_pixel(x.edges[k - 1].length);
        let jumps = crate::image_jumps(space, self.min_pixels, self.image_share);
        if x.vertices[start].is_distant() {
            return jumps.scaled(size_of_pixel, f64::INFINITY);
        }
        let moved: f64 = x.edges[start..k - 1].iter().map(|edge| edge.length).sum();
        jumps.scaled(size_of_pixel / moved, MAX_ANGLE)
    }

    /// Density with which vertex `start + 1` of `to` is found from `from`: per solid angle of the turned direction, per area of a plane
    /// perpendicular to light that was shifted. 0 outside the range.
    fn pdf_of_move<R: Repertoire>(range: &JumpRange, from: &Path<R>, to: &Path<R>, start: usize) -> f64 {
        let direction = from.edges[start].direction;
        if from.vertices[start].is_distant() {
            let moved = to.vertices[1].position - from.vertices[1].position;
            range.pdf_area(DVec2::new(moved.reject_from_normalized(direction).length(), 0.0))
        } else {
            range.pdf_solid_angle(direction, to.edges[start].direction)
        }
    }
}

impl Registered for Caustic {
    fn validate(&self) -> Result<(), String> {
        validate_image_jump(self.min_pixels, self.image_share)
    }
}

impl PathMutation for Caustic {
    fn suitability<R: Repertoire>(&self, _space: &PathSpace<R>, x: &Path<R>) -> f64 {
        if Self::start(x).is_some() { 1.0 } else { 0.0 }
    }

    fn propose<R: Repertoire>(
        &self,
        space: &PathSpace<R>,
        x: &Path<R>,
        y: &mut Path<R>,
        rng: &mut impl RandomSource,
    ) -> Result<Splice, Rejection> {
        let scene = &space.scene;
        let start = Self::start(x).ok_or(Rejection::WrongComponent)?;
        let k = x.length();
        let range = self.range(space, x, start);
        let direction = x.edges[start].direction;
        let plan = Splice { prefix: start + 1, suffix: 1 };
        y.begin(x, start + 1, k - 1 - start, 1);
        y.wavelength = wavelength::perturb(scene, x, plan, rng);
        let in_range = if x.vertices[start].is_distant() {
            let (frame, shift) = (Frame::from_normal(direction), range.displace(rng));
            let through = x.vertices[1].position + frame.t * shift.x + frame.b * shift.y;
            let (wavelength, met) = (y.wavelength, &mut y.vertices[1]);
            let found = if x.vertices[1].is_in_medium() {
                scene.place_from_afar(direction, through, perturb_length(length(scene, x, 0), rng), met, rng)
            } else {
                scene.trace_parallel(direction, through, wavelength, met, rng)
            };
            if !found {
                return Err(Rejection::Escaped);
            }
            y.derive_edges(scene, 0, 1);
            Self::pdf_of_move(&range, x, y, start) > 0.0
        } else {
            retrace(scene, x, y, (start, start + 1), None, range.turn(direction, rng), rng)?;
            range.allows_turn(direction, y.edges[start].direction)
        };
        if !in_range {
            return Err(Rejection::OutOfRange);
        }
        for i in start + 1..k - 1 {
            let w = follow(&mut y.vertices[i], -y.edges[i - 1].direction, x.vertices[i].component)?;
            retrace(scene, x, y, (i, i + 1), None, w, rng)?;
        }
        if !y.vertices[k - 1].interaction.has_rough() {
            return Err(Rejection::NotConnectable);
        }
        connect(scene, y, k - 1)?;
        if start + 2 <= k {
            y.derive_scattering(scene, start, k - 2);
        }
        Ok(plan)
    }

    fn density<R: Repertoire>(&self, space: &PathSpace<R>, from: &Path<R>, to: &Path<R>, plan: Splice) -> Density {
        let k = from.length();
        let Some(start) = Self::start(from).filter(|start| start + 1 == plan.prefix) else {
            return Density::ZERO;
        };
        if to.length() != k || (start + 1..k).any(|i| from.vertices[i].component != to.vertices[i].component) {
            return Density::ZERO;
        }
        let mut density = Density::ONE;
        let range = self.range(space, from, start);
        density.multiply(Self::pdf_of_move(&range, from, to, start));
        density.multiply(wavelength::pdf_of_perturbation(&space.scene, from, to, plan));
        for i in start + 1..k {
            density.multiply(conversion(&space.scene, from, to, i - 1, End::Light));
            if i + 1 < k {
                density.multiply(dirac_factor(&to.vertices[i], to.edges[i].direction));
            }
        }
        density
    }
}
