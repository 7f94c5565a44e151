//! Perturbations that start at the eye: the image point moves, the point of a lens stays, and the path is traced again through its Dirac chains up to
//! a vertex that is connected to the rest, or that lands on the light. Lens and multi-chain perturbation are both this.

use ergodic_metropolis::{Density, RandomSource};
use ergodic_pathspace::{End, Path, PathSpace, Scene};
use ergodic_scattering::{Component, Repertoire};

use crate::chains::{connect, dirac_factor, follow};
use crate::jump::JumpRange;
use crate::retrace::{conversion, retrace};
use crate::{Rejection, Splice, wavelength};

/// How far things move.
pub(crate) struct EyeSide {
    /// Of the image point, in pixels.
    pub(crate) image: JumpRange,
    /// Of the direction in which a path leaves a rough vertex between two Dirac chains, in radians. `None` if the path may
    /// have no such vertex.
    pub(crate) turn: Option<JumpRange>,
}

/// The first rough vertex seen from the eye, if it can be connected on; 0 when the Dirac chain ends on a light.
#[inline]
pub(crate) fn start<R: Repertoire>(x: &Path<R>) -> Option<usize> {
    let first_rough = (1..x.length()).rev().find(|&i| x.vertices[i].component == Component::Rough);
    match first_rough {
        None => x.vertices[0].can_be_met().then_some(0),
        Some(i) => x.vertices[i - 1].is_connectable().then_some(i),
    }
}

/// Finishes a candidate that was traced from the eye down to vertex `end`: that is connected to the vertex before it, which is kept, or
/// must emit if there is none.
#[inline]
pub(crate) fn join<R: Repertoire>(scene: &Scene<R>, y: &mut Path<R>, end: usize) -> Result<(), Rejection> {
    let k = y.length();
    if end == 0 {
        y.derive_scattering(scene, 0, k);
        return if y.scattering[0].max_element() <= 0.0 { Err(Rejection::NoEmitter) } else { Ok(()) };
    }
    if !y.vertices[end].interaction.has_rough() {
        return Err(Rejection::NotConnectable);
    }
    connect(scene, y, end - 1)?;
    y.derive_scattering(scene, end + 1, k);
    Ok(())
}

impl EyeSide {
    /// Replaces the vertices `start .. k` of `x`; vertex `start` is the first that is not left through a Dirac chain.
    pub(crate) fn propose<R: Repertoire>(
        &self,
        space: &PathSpace<R>,
        x: &Path<R>,
        start: usize,
        y: &mut Path<R>,
        rng: &mut impl RandomSource,
    ) -> Result<Splice, Rejection> {
        let scene = &space.scene;
        let camera = scene.camera();
        let k = x.length();
        let image_point = x.raster.ok_or(Rejection::OffFilm)? + self.image.displace(rng);
        if !camera.in_domain(image_point) {
            return Err(Rejection::OffFilm);
        }
        let sight = camera.sight(x.vertices[k].position, image_point);
        let mut w = sight.direction;
        let plan = Splice { prefix: start, suffix: 1 };
        y.begin(x, start, k - start, 1);
        y.wavelength = wavelength::perturb(scene, x, plan, rng);
        let film = scene.start_on_film(&x.vertices[k], &sight);
        for i in (start..k).rev() {
            let sight_start = film.as_ref().filter(|_| i + 1 == k);
            retrace(scene, x, y, (i + 1, i), sight_start, w, rng)?;
            if i + 1 < k && x.vertices[i + 1].component == Component::Rough {
                let turn = self.turn.as_ref().ok_or(Rejection::WrongComponent)?;
                if !turn.allows_turn(-x.edges[i].direction, -y.edges[i].direction) {
                    return Err(Rejection::OutOfRange);
                }
            }
            if i == start {
                break;
            }
            let to_eye = y.edges[i].direction;
            let component = x.vertices[i].component;
            if component == Component::Rough {
                if !y.vertices[i].interaction.has_rough() {
                    return Err(Rejection::WrongComponent);
                }
                let turn = self.turn.as_ref().ok_or(Rejection::WrongComponent)?;
                w = turn.turn(-x.edges[i - 1].direction, rng);
            } else {
                w = follow(&mut y.vertices[i], to_eye, component)?;
            }
        }
        join(scene, y, start)?;
        Ok(plan)
    }

    /// T: the density of the image point per image area, of each turned direction per solid angle, all carried to the
    /// area measure of the new vertices. Dirac components are kept, not chosen, so no selection probability enters.
    pub(crate) fn density<R: Repertoire>(
        &self,
        space: &PathSpace<R>,
        from: &Path<R>,
        to: &Path<R>,
        start: usize,
    ) -> Density {
        let k = from.length();
        if to.length() != k || (start + 1..k).any(|i| from.vertices[i].component != to.vertices[i].component) {
            return Density::ZERO;
        }
        let (Some(raster_from), Some(raster_to)) = (from.raster, to.raster) else {
            return Density::ZERO;
        };
        let mut density = Density::ONE;
        density.multiply(self.image.pdf_area(raster_to - raster_from));
        // Raster area per solid angle, or per area of an orthographic film: the responsivity is that over the image's area, and of
        // a lens over its aperture (see Camera).
        let camera = space.scene.camera();
        density.multiply(camera.raster_per_measure_at(to.scattering[k].x, -to.edges[k - 1].direction));
        let plan = Splice { prefix: start, suffix: 1 };
        density.multiply(wavelength::pdf_of_perturbation(&space.scene, from, to, plan));
        for i in (start..k).rev() {
            density.multiply(conversion(&space.scene, from, to, i, End::Eye));
            if i > start {
                let vertex = &to.vertices[i];
                let w_to = -to.edges[i - 1].direction;
                if vertex.component == Component::Rough {
                    match &self.turn {
                        Some(turn) => density.multiply(turn.pdf_solid_angle(-from.edges[i - 1].direction, w_to)),
                        None => return Density::ZERO,
                    }
                } else {
                    density.multiply(dirac_factor(vertex, w_to));
                }
            }
        }
        density
    }
}
