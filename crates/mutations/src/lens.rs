//! Lens perturbation (Veach 11.4.3.1): moves the image point a little and traces the lens edge again, through the same
//! Dirac chain, to the first rough vertex, which is connected to its old neighbour.
//!
//! For suffixes `(L|D) D S* E`, written from the light, and for whole paths `L S* E` whose chain ends on the light.

use ergodic_metropolis::{Density, RandomSource};
use ergodic_pathspace::{Path, PathSpace};
use ergodic_scattering::Repertoire;
use serde::{Deserialize, Serialize};

use crate::eye_side::{self, EyeSide};
use crate::{PathMutation, Registered, Rejection, Splice, image_jumps, validate_image_jump};

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
    fn eye_side<R: Repertoire>(&self, space: &PathSpace<R>) -> EyeSide {
        EyeSide { image: image_jumps(space, self.min_pixels, self.image_share), turn: None }
    }
}

impl Registered for Lens {
    fn validate(&self) -> Result<(), String> {
        validate_image_jump(self.min_pixels, self.image_share)
    }
}

impl PathMutation for Lens {
    fn suitability<R: Repertoire>(&self, _space: &PathSpace<R>, x: &Path<R>) -> f64 {
        if eye_side::start(x).is_some() { 1.0 } else { 0.0 }
    }

    fn propose<R: Repertoire>(
        &self,
        space: &PathSpace<R>,
        x: &Path<R>,
        y: &mut Path<R>,
        rng: &mut impl RandomSource,
    ) -> Result<Splice, Rejection> {
        let start = eye_side::start(x).ok_or(Rejection::WrongComponent)?;
        self.eye_side(space).propose(space, x, start, y, rng)
    }

    fn density<R: Repertoire>(&self, space: &PathSpace<R>, from: &Path<R>, to: &Path<R>, plan: Splice) -> Density {
        if eye_side::start(from) == Some(plan.prefix) {
            self.eye_side(space).density(space, from, to, plan.prefix)
        } else {
            Density::ZERO
        }
    }
}
