//! Perturbations that start at the eye: the image point moves, and the path is traced again through its Dirac chains up to
//! a vertex that is connected to the rest, or that lands on the light. Lens and multi-chain perturbation are both this.

use ergodic_metropolis::{LnProduct, RandomSource};
use ergodic_pathspace::{Edge, Path, PathSpace, raster};
use ergodic_scattering::Component;

use crate::chains::{connect, copy_path, dirac_factor, follow, trace};
use crate::jump::JumpRange;
use crate::{Rejection, Splice};

/// How far things move.
pub(crate) struct EyeSide {
    /// Of the image point, in pixels.
    pub(crate) image: JumpRange,
    /// Of the direction in which a path leaves a rough vertex between two Dirac chains, in radians. `None` if the path may
    /// have no such vertex.
    pub(crate) turn: Option<JumpRange>,
}

impl EyeSide {
    /// Replaces the vertices `start .. k` of `x`; vertex `start` is the first that is not left through a Dirac chain.
    pub(crate) fn propose(
        &self,
        space: &PathSpace,
        x: &Path,
        start: usize,
        y: &mut Path,
        rng: &mut impl RandomSource,
    ) -> Result<Splice, Rejection> {
        let scene = &*space.scene;
        let camera = scene.camera();
        let k = x.length();
        let image_point = raster(scene, x).ok_or(Rejection::OffFilm)? + self.image.displace(rng);
        let mut w = camera.direction(image_point);
        if camera.raster(w).is_none() {
            return Err(Rejection::OffFilm);
        }
        copy_path(x, y);
        for i in (start..k).rev() {
            y.vertices[i] = trace(scene, &y.vertices[i + 1], w)?;
            y.edges[i] = Edge::new(scene, &y.vertices[i], &y.vertices[i + 1]);
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
        if start == 0 {
            let light = &y.vertices[0];
            if scene.emitted(light, y.edges[0].direction).max_element() <= 0.0 {
                return Err(Rejection::NoEmitter);
            }
        } else {
            if !y.vertices[start].interaction.has_rough() {
                return Err(Rejection::NotConnectable);
            }
            connect(scene, y, start - 1)?;
        }
        Ok(Splice { prefix: start, suffix: 1 })
    }

    /// ln T: the density of the image point per image area, of each turned direction per solid angle, all carried to the
    /// area measure of the new vertices. Dirac components are kept, not chosen, so no selection probability enters.
    pub(crate) fn ln_density(&self, space: &PathSpace, from: &Path, to: &Path, start: usize) -> f64 {
        let scene = &*space.scene;
        let k = from.length();
        if to.length() != k || (start + 1..k).any(|i| from.vertices[i].component != to.vertices[i].component) {
            return f64::NEG_INFINITY;
        }
        let (Some(raster_from), Some(raster_to)) = (raster(scene, from), raster(scene, to)) else {
            return f64::NEG_INFINITY;
        };
        let mut density = LnProduct::one();
        density.multiply(self.image.pdf_area(raster_to - raster_from));
        density.multiply(scene.camera().raster_per_solid_angle(-to.edges[k - 1].direction));
        for i in (start..k).rev() {
            density.multiply(to.edges[i].to_light_side);
            if i > start {
                let vertex = &to.vertices[i];
                let w_to = -to.edges[i - 1].direction;
                if vertex.component == Component::Rough {
                    match &self.turn {
                        Some(turn) => density.multiply(turn.pdf_solid_angle(-from.edges[i - 1].direction, w_to)),
                        None => return f64::NEG_INFINITY,
                    }
                } else {
                    density.multiply(dirac_factor(vertex, w_to));
                }
            }
        }
        density.ln()
    }
}
