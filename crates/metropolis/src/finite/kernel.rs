//! A finite state space as seen by [`Chain`](crate::Chain): a matrix that proposes, weights as the target.

use std::convert::Infallible;

use serde::{Deserialize, Serialize};

use super::{FiniteError, TransitionMatrix};
use crate::{Mutation, RandomSource, Target};

/// Proposes the next state by the rows of a matrix.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct FiniteProposal {
    matrix: TransitionMatrix,
}

impl FiniteProposal {
    /// The kernel that proposes by `matrix`.
    pub fn new(matrix: TransitionMatrix) -> Self {
        Self { matrix }
    }
}

impl Mutation for FiniteProposal {
    type Space = ();
    type State = usize;
    type Plan = ();
    type Failure = Infallible;

    fn propose(&self, (): &(), x: &usize, y: &mut usize, rng: &mut impl RandomSource) -> Result<(), Infallible> {
        *y = self.matrix.step(*x, rng);
        Ok(())
    }

    fn ln_density(&self, (): &(), from: &usize, to: &usize, (): ()) -> f64 {
        libm::log(self.matrix.row(*from)[*to])
    }
}

/// Weights of the states, not normalised.
#[derive(Clone, Debug, PartialEq)]
pub struct FiniteTarget {
    weights: Vec<f64>,
}

impl FiniteTarget {
    /// The target proportional to `weights`.
    ///
    /// # Errors
    ///
    /// Weights that are negative or not finite, or none above 0.
    pub fn new(weights: Vec<f64>) -> Result<Self, FiniteError> {
        if let Some(state) = weights.iter().position(|w| !w.is_finite() || *w < 0.0) {
            return Err(FiniteError::Weight { state, value: weights[state] });
        }
        if weights.iter().all(|w| *w == 0.0) {
            return Err(FiniteError::NoWeight);
        }
        Ok(Self { weights })
    }
}

impl Target for FiniteTarget {
    type State = usize;
    type Value = f64;

    fn evaluate(&self, x: &usize) -> f64 {
        self.weights[*x]
    }

    fn ln_density(value: &f64) -> f64 {
        libm::log(*value)
    }
}
