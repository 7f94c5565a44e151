//! Multi-chain perturbation (Veach 11.4.3.3): a lens perturbation that goes on through further Dirac chains.
//!
//! For paths with two or more specular chains before the eye, `(L|D) D S+ D S+ E` written from the light: the image point
//! moves, and at every rough vertex that is followed by another Dirac chain the direction is turned by a small angle, until
//! two connectable neighbours come in a row; or the last chain lands on the light itself.

use ergodic_metropolis::{Density, RandomSource};
use ergodic_pathspace::{Effects, Path, PathSpace};
use ergodic_scattering::{Component, Repertoire};
use serde::{Deserialize, Serialize};

use crate::eye_side::EyeSide;
use crate::jump::JumpRange;
use crate::{PathMutation, Registered, Rejection, Splice, image_jumps, validate_image_jump};

/// Multi-chain perturbation.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MultiChain {
    /// Smallest move of the image point, in pixels (r₁).
    pub min_pixels: f64,
    /// Largest move of the image point, as the share of the image's area of a disk of that radius.
    pub image_share: f64,
    /// Smallest turn of a direction between two chains, in radians (θ₁).
    pub min_angle: f64,
    /// Largest turn, in radians (θ₂).
    pub max_angle: f64,
}

impl Default for MultiChain {
    fn default() -> Self {
        Self { min_pixels: 0.1, image_share: 0.05, min_angle: 1e-4, max_angle: 0.1 }
    }
}

impl MultiChain {
    fn eye_side<R: Repertoire>(&self, space: &PathSpace<R>) -> EyeSide {
        EyeSide {
            image: image_jumps(space, self.min_pixels, self.image_share),
            turn: Some(JumpRange::new(self.min_angle, self.max_angle)),
        }
    }

    /// Where the traced part ends: the first rough vertex with a connectable neighbour beyond it, or 0.
    fn start<R: Repertoire>(x: &Path<R>) -> Option<usize> {
        let k = x.length();
        let is_dirac = |i: usize| i > 0 && i < k && x.vertices[i].component != Component::Rough;
        if k < 2 || !is_dirac(k - 1) {
            return None;
        }
        let mut rough_between_chains = 0;
        for i in (1..k).rev() {
            if is_dirac(i) {
                continue;
            }
            if !is_dirac(i - 1) {
                return (rough_between_chains > 0).then_some(i);
            }
            rough_between_chains += 1;
        }
        (rough_between_chains > 0 && x.vertices[0].can_be_met()).then_some(0)
    }
}

impl Registered for MultiChain {
    fn never_applies(effects: Effects) -> Option<&'static str> {
        (!effects.has_specular()).then_some("no path has a specular vertex")
    }

    fn validate(&self) -> Result<(), String> {
        validate_image_jump(self.min_pixels, self.image_share)?;
        if !(self.min_angle > 0.0 && self.min_angle < self.max_angle && self.max_angle <= 1.5) {
            return Err(format!(
                "min_angle is {} and max_angle {}; they must satisfy 0 < min_angle < max_angle <= 1.5 (radians)",
                self.min_angle, self.max_angle
            ));
        }
        Ok(())
    }
}

impl PathMutation for MultiChain {
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
        let start = Self::start(x).ok_or(Rejection::WrongComponent)?;
        self.eye_side(space).propose(space, x, start, y, rng)
    }

    fn density<R: Repertoire>(&self, space: &PathSpace<R>, from: &Path<R>, to: &Path<R>, plan: Splice) -> Density {
        if Self::start(from) == Some(plan.prefix) {
            self.eye_side(space).density(space, from, to, plan.prefix)
        } else {
            Density::ZERO
        }
    }
}
