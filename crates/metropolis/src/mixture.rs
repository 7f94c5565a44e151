//! State-dependent choice among kernels. A mixture is itself a kernel, so that the probability of the choice is part of
//! the density and cannot be forgotten.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{Density, Mutation, RandomSource};

/// Members whose weights are kept while one is chosen.
const KNOWN: usize = 8;

/// Kernels with weights; the probability of a kernel from `x` is its weight times its suitability, normalised.
///
/// ```
/// use ergodic_metropolis::finite::{FiniteProposal, TransitionMatrix};
/// use ergodic_metropolis::{Mixture, Mutation};
///
/// let matrix = |rows: [[f64; 2]; 2]| TransitionMatrix::from_rows(rows.map(Vec::from).into()).map(FiniteProposal::new);
/// let kernels = Mixture::new(vec![(3.0, matrix([[0.5, 0.5], [0.5, 0.5]])?), (1.0, matrix([[0.0, 1.0], [1.0, 0.0]])?)])?;
/// assert_eq!(kernels.probability(1, &(), &0), 0.25);
/// // The density is the joint one of the choice and the move.
/// assert_eq!(kernels.ln_density(&(), &0, &1, (0, ())), (0.75 * 0.5f64).ln());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// In a file a mixture is the list of its members, checked as [`Mixture::new`] checks it.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(
    try_from = "Vec<(f64, M)>",
    into = "Vec<(f64, M)>",
    bound(serialize = "M: Serialize + Clone", deserialize = "M: Deserialize<'de>")
)]
pub struct Mixture<M> {
    members: Vec<(f64, M)>,
}

/// Why a set of weights makes no mixture.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MixtureError {
    /// No member has a positive weight.
    #[error("no mutation has a positive weight")]
    Empty,
    /// A weight is negative, infinite or not a number.
    #[error("the weight of mutation {index} is {weight}; weights are finite and not negative")]
    Weight {
        /// Which member.
        index: usize,
        /// Its weight.
        weight: f64,
    },
}

/// Why a mixture proposed nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotProposed<F> {
    /// No member is suitable for the state.
    NoneSuitable,
    /// Member `index` was chosen and failed.
    Failed {
        /// The member that was chosen.
        index: usize,
        /// Its reason.
        reason: F,
    },
}

impl<M> Mixture<M> {
    /// A mixture of `(weight, kernel)` members.
    ///
    /// # Errors
    ///
    /// A weight that is negative or not finite, or no positive weight at all.
    pub fn new(members: Vec<(f64, M)>) -> Result<Self, MixtureError> {
        for (index, (weight, _)) in members.iter().enumerate() {
            if !weight.is_finite() || *weight < 0.0 {
                return Err(MixtureError::Weight { index, weight: *weight });
            }
        }
        if !members.iter().any(|(weight, _)| *weight > 0.0) {
            return Err(MixtureError::Empty);
        }
        Ok(Self { members })
    }

    /// The members with the weights as given.
    pub fn members(&self) -> &[(f64, M)] {
        &self.members
    }
}

impl<M> TryFrom<Vec<(f64, M)>> for Mixture<M> {
    type Error = MixtureError;

    fn try_from(members: Vec<(f64, M)>) -> Result<Self, MixtureError> {
        Self::new(members)
    }
}

impl<M> From<Mixture<M>> for Vec<(f64, M)> {
    fn from(mixture: Mixture<M>) -> Self {
        mixture.members
    }
}

impl<M: Mutation> Mixture<M> {
    #[inline]
    fn weight(&self, index: usize, space: &M::Space, x: &M::State) -> f64 {
        let (weight, kernel) = &self.members[index];
        if *weight > 0.0 { weight * kernel.suitability(space, x) } else { 0.0 }
    }

    /// The probability that kernel `index` is chosen from `x`; 0 where nothing is suitable.
    #[inline]
    pub fn probability(&self, index: usize, space: &M::Space, x: &M::State) -> f64 {
        let (mut total, mut of_index) = (0.0, 0.0);
        for j in 0..self.members.len() {
            let weight = self.weight(j, space, x);
            total += weight;
            if j == index {
                of_index = weight;
            }
        }
        if total > 0.0 { of_index / total } else { 0.0 }
    }

    /// The kernel chosen from `x` by the number `u` in `[0, 1)`.
    #[inline]
    fn choose(&self, space: &M::Space, x: &M::State, u: f64) -> Option<usize> {
        // Weights are worked out once if there are as few as there usually are.
        let mut known = [0.0; KNOWN];
        let mut total = 0.0;
        for index in 0..self.members.len() {
            let weight = self.weight(index, space, x);
            total += weight;
            if let Some(slot) = known.get_mut(index) {
                *slot = weight;
            }
        }
        let mut remaining = u * total;
        let mut last = None;
        for index in 0..self.members.len() {
            let weight = known.get(index).copied().unwrap_or_else(|| self.weight(index, space, x));
            if weight > 0.0 {
                last = Some(index);
                remaining -= weight;
                if remaining < 0.0 {
                    break;
                }
            }
        }
        last
    }
}

impl<M: Mutation> Mutation for Mixture<M> {
    type Space = M::Space;
    type State = M::State;
    /// Which member, and its own plan.
    type Plan = (usize, M::Plan);
    type Failure = NotProposed<M::Failure>;

    fn propose(
        &self,
        space: &M::Space,
        x: &M::State,
        y: &mut M::State,
        rng: &mut impl RandomSource,
    ) -> Result<Self::Plan, Self::Failure> {
        let index = self.choose(space, x, rng.uniform()).ok_or(NotProposed::NoneSuitable)?;
        match self.members[index].1.propose(space, x, y, rng) {
            Ok(plan) => Ok((index, plan)),
            Err(reason) => Err(NotProposed::Failed { index, reason }),
        }
    }

    fn ln_density(&self, space: &M::Space, from: &M::State, to: &M::State, (index, plan): Self::Plan) -> f64 {
        let probability = self.probability(index, space, from);
        if probability > 0.0 {
            libm::log(probability) + self.members[index].1.ln_density(space, from, to, plan)
        } else {
            f64::NEG_INFINITY
        }
    }

    #[inline]
    fn density(&self, space: &M::Space, from: &M::State, to: &M::State, (index, plan): Self::Plan) -> Density {
        let probability = self.probability(index, space, from);
        if probability > 0.0 {
            let mut density = self.members[index].1.density(space, from, to, plan);
            density.multiply(probability);
            density
        } else {
            Density::ZERO
        }
    }
}
