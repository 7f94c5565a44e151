//! Lens perturbation (Veach 11.4.3.1): moves the image point a little and traces the lens edge again, through the same
//! Dirac chain, to the first rough vertex, which is connected to its old neighbour.
//!
//! For suffixes `(L|D) D S* E`, written from the light, and for whole paths `L S* E` whose chain ends on the light.

use ergodic_metropolis::{Density, Mutation, RandomSource};
use ergodic_pathspace::{Path, PathSpace};
use serde::{Deserialize, Serialize};

use crate::eye_side::{self, EyeSide};
use crate::{PathMutation, Rejection, Splice, image_jumps, validate_image_jump};

/// Lens perturbation.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Lens {
    /// Smallest move of the image point, in pixels (r₁).
    pub min_pixels: f64,
    /// The largest move r₂ is such that a disk of this radius has this share of the image's area: π r₂² = share · area.
    pub image_share: f64,
}

impl Default for Lens {
    fn default() -> Self {
        Self { min_pixels: 0.1, image_share: 0.05 }
    }
}

impl Lens {
    fn eye_side(&self, space: &PathSpace) -> EyeSide {
        EyeSide { image: image_jumps(space, self.min_pixels, self.image_share), turn: None }
    }
}

impl PathMutation for Lens {
    fn validate(&self) -> Result<(), String> {
        validate_image_jump(self.min_pixels, self.image_share)
    }
}

impl Mutation for Lens {
    type Space = PathSpace;
    type State = Path;
    type Plan = Splice;
    type Failure = Rejection;

    fn suitability(&self, _space: &PathSpace, x: &Path) -> f64 {
        if eye_side::start(x).is_some() { 1.0 } else { 0.0 }
    }

    fn propose(
        &self,
        space: &PathSpace,
        x: &Path,
        y: &mut Path,
        rng: &mut impl RandomSource,
    ) -> Result<Splice, Rejection> {
        let start = eye_side::start(x).ok_or(Rejection::WrongComponent)?;
        self.eye_side(space).propose(space, x, start, y, rng)
    }

    fn ln_density(&self, space: &PathSpace, from: &Path, to: &Path, plan: Splice) -> f64 {
        self.density(space, from, to, plan).ln()
    }

    fn density(&self, space: &PathSpace, from: &Path, to: &Path, plan: Splice) -> Density {
        if eye_side::start(from) == Some(plan.prefix) {
            self.eye_side(space).density(space, from, to, plan.prefix)
        } else {
            Density::ZERO
        }
    }
}
