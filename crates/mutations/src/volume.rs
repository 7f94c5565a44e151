//! Scattering-point perturbation: moves one point in a medium a little, to all sides, and connects it to both its neighbours anew.
//! Pauly, Kollig and Keller (2000) move points along their edges only; here the move has three dimensions, so that it has a density
//! of its own and needs no other mutation to leave a line.

use ergodic_geometry::sin_cos_turns;
use ergodic_metropolis::{Density, RandomSource};
use ergodic_pathspace::{Effect, Effects, Path, PathSpace};
use ergodic_scattering::Repertoire;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

use crate::chains::connect;
use crate::jump::JumpRange;
use crate::{PathMutation, Registered, Rejection, Splice};

/// Scattering-point perturbation.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Volume {
    /// Smallest move, in mean free paths.
    pub min_free_paths: f64,
    /// Largest move, in mean free paths.
    pub max_free_paths: f64,
}

impl Default for Volume {
    fn default() -> Self {
        Self { min_free_paths: 0.001, max_free_paths: 0.5 }
    }
}

impl Volume {
    /// Indices of the points that can be moved: in a medium, between neighbours that can be connected.
    fn places<R: Repertoire>(x: &Path<R>) -> impl Iterator<Item = usize> {
        let k = x.length();
        let connectable = move |i: usize| i == 0 || i == k || x.vertices[i].is_connectable();
        (1..k).filter(move |&i| x.vertices[i].is_in_medium() && connectable(i - 1) && connectable(i + 1))
    }

    /// How far a point moves. It depends on its medium alone, which a move does not change.
    fn range<R: Repertoire>(&self, space: &PathSpace<R>, x: &Path<R>, i: usize) -> JumpRange {
        let free_path = space.scene.mean_free_path(&x.vertices[i]);
        JumpRange::new(self.min_free_paths * free_path, self.max_free_paths * free_path)
    }
}

impl Registered for Volume {
    fn never_applies(effects: Effects) -> Option<&'static str> {
        (!effects.has(Effect::Scattering)).then_some("no medium scatters")
    }

    fn validate(&self) -> Result<(), String> {
        let (min, max) = (self.min_free_paths, self.max_free_paths);
        if !(min > 0.0 && min < max && max.is_finite()) {
            return Err(format!(
                "min_free_paths is {min} and max_free_paths {max}; they must satisfy 0 < min_free_paths < max_free_paths"
            ));
        }
        Ok(())
    }
}

impl PathMutation for Volume {
    fn suitability<R: Repertoire>(&self, space: &PathSpace<R>, x: &Path<R>) -> f64 {
        if space.scene.scatters() && Self::places(x).next().is_some() { 1.0 } else { 0.0 }
    }

    fn propose<R: Repertoire>(
        &self,
        space: &PathSpace<R>,
        x: &Path<R>,
        y: &mut Path<R>,
        rng: &mut impl RandomSource,
    ) -> Result<Splice, Rejection> {
        let scene = &space.scene;
        let k = x.length();
        let chosen = rng.below(Self::places(x).count().max(1));
        let i = Self::places(x).nth(chosen).ok_or(Rejection::WrongComponent)?;
        let (cos, (sin_phi, cos_phi)) = (2.0 * rng.uniform() - 1.0, sin_cos_turns(rng.uniform()));
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let size = self.range(space, x, i).size(rng.uniform());
        let moved = x.vertices[i].position + DVec3::new(sin * cos_phi, sin * sin_phi, cos) * size;
        y.begin(x, i, 1, k - i);
        y.vertices[i] = scene.moved_in_medium(&x.vertices[i], moved);
        y.derive_edges(scene, i - 1, i + 1);
        let (before, after) = (y.edges[i - 1].direction, y.edges[i].direction);
        let [light_side, point, eye_side] = &y.vertices[i - 1..=i + 1] else { return Err(Rejection::WrongComponent) };
        if !scene.shares_medium(point, light_side, -before) || !scene.shares_medium(point, eye_side, after) {
            return Err(Rejection::Occluded);
        }
        if !scene.connects(light_side, point, &y.edges[i - 1]) {
            return Err(Rejection::Occluded);
        }
        y.derive_scattering(scene, i - 1, i - 1);
        connect(scene, y, i)?;
        Ok(Splice { prefix: i, suffix: k - i })
    }

    /// 1 / (n 4π r³ ln(r₂/r₁)) per volume, with n the number of points that could have been chosen.
    fn density<R: Repertoire>(&self, space: &PathSpace<R>, from: &Path<R>, to: &Path<R>, plan: Splice) -> Density {
        let i = plan.prefix;
        if to.length() != from.length()
            || to.wavelength != from.wavelength
            || !Self::places(from).any(|place| place == i)
            || !to.vertices[i].is_in_medium()
            || to.vertices[i].medium() != from.vertices[i].medium()
        {
            return Density::ZERO;
        }
        let move_ = to.vertices[i].position - from.vertices[i].position;
        let mut density = Density::ONE;
        // The density of the size, over the area of the sphere of that radius.
        let size = move_.length();
        density.multiply(self.range(space, from, i).pdf_size(size) / (4.0 * PI * size * size));
        density.multiply(1.0 / Self::places(from).count() as f64);
        density
    }
}
