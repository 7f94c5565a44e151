//! Caustic perturbation (Veach 11.4.3.2): turns the direction in which light leaves the last connectable vertex before a
//! Dirac chain, traces it to the vertex that the eye sees, and connects that to the eye.
//!
//! For suffixes `(L|D) S* D E`, written from the light.

use ergodic_metropolis::{Density, Mutation, RandomSource};
use ergodic_pathspace::{Kind, Path, PathSpace};
use ergodic_scattering::Component;
use serde::{Deserialize, Serialize};

use crate::chains::{connect, dirac_factor, follow, trace};
use crate::jump::JumpRange;
use crate::{PathMutation, Rejection, Splice, validate_image_jump};

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
    fn start(x: &Path) -> Option<usize> {
        let k = x.length();
        if k < 2 || x.vertices[k - 1].component != Component::Rough {
            return None;
        }
        let start = (1..k - 1).rev().find(|&i| x.vertices[i].component == Component::Rough).unwrap_or(0);
        // A distant light sends all its light in one direction, which cannot be turned. That of the environment could be, but it has
        // no position to be turned about.
        (!matches!(x.vertices[start].kind, Kind::DistantLight(_) | Kind::Environment)).then_some(start)
    }

    /// The range of angles, which depends on the path: pixels carried through |x_{k-1} - x_k| over the summed length of
    /// the edges that move.
    fn range(&self, space: &PathSpace, x: &Path, start: usize) -> JumpRange {
        let k = x.length();
        let camera = space.scene.camera();
        let seen = x.edges[k - 1].length;
        let moved: f64 = x.edges[start..k - 1].iter().map(|edge| edge.length).sum();
        let radians_per_pixel = camera.radians_per_pixel() * seen / moved;
        crate::image_jumps(space, self.min_pixels, self.image_share).scaled(radians_per_pixel, MAX_ANGLE)
    }
}

impl PathMutation for Caustic {
    fn validate(&self) -> Result<(), String> {
        validate_image_jump(self.min_pixels, self.image_share)
    }
}

impl Mutation for Caustic {
    type Space = PathSpace;
    type State = Path;
    type Plan = Splice;
    type Failure = Rejection;

    fn suitability(&self, _space: &PathSpace, x: &Path) -> f64 {
        if Self::start(x).is_some() { 1.0 } else { 0.0 }
    }

    fn propose(
        &self,
        space: &PathSpace,
        x: &Path,
        y: &mut Path,
        rng: &mut impl RandomSource,
    ) -> Result<Splice, Rejection> {
        let scene = &*space.scene;
        let start = Self::start(x).ok_or(Rejection::WrongComponent)?;
        let k = x.length();
        let range = self.range(space, x, start);
        let mut w = range.turn(x.edges[start].direction, rng);
        y.begin(x, start + 1, k - 1 - start, 1);
        for i in start + 1..k {
            trace(scene, y, i - 1, i, w)?;
            if i == start + 1 && !range.allows_turn(x.edges[start].direction, y.edges[start].direction) {
                return Err(Rejection::OutOfRange);
            }
            if i + 1 < k {
                let from_light = -y.edges[i - 1].direction;
                w = follow(&mut y.vertices[i], from_light, x.vertices[i].component)?;
            }
        }
        if !y.vertices[k - 1].interaction.has_rough() {
            return Err(Rejection::NotConnectable);
        }
        connect(scene, y, k - 1)?;
        if start + 2 <= k {
            y.derive_scattering(scene, start, k - 2);
        }
        Ok(Splice { prefix: start + 1, suffix: 1 })
    }

    fn ln_density(&self, space: &PathSpace, from: &Path, to: &Path, plan: Splice) -> f64 {
        self.density(space, from, to, plan).ln()
    }

    fn density(&self, space: &PathSpace, from: &Path, to: &Path, plan: Splice) -> Density {
        let k = from.length();
        let Some(start) = Self::start(from).filter(|start| start + 1 == plan.prefix) else {
            return Density::ZERO;
        };
        if to.length() != k || (start + 1..k).any(|i| from.vertices[i].component != to.vertices[i].component) {
            return Density::ZERO;
        }
        let mut density = Density::ONE;
        let range = self.range(space, from, start);
        density.multiply(range.pdf_solid_angle(from.edges[start].direction, to.edges[start].direction));
        for i in start + 1..k {
            density.multiply(to.edges[i - 1].to_eye_side);
            if i + 1 < k {
                density.multiply(dirac_factor(&to.vertices[i], to.edges[i].direction));
            }
        }
        density
    }
}
