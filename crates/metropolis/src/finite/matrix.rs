//! A checked stochastic matrix, and walking by it.

use serde::{Deserialize, Serialize};

use super::FiniteError;
use crate::{Mutation, RandomSource, Target, acceptance};

/// Probabilities P_ij of going from state i to state j in one step. Every row sums to 1.
///
/// ```
/// use ergodic_metropolis::finite::TransitionMatrix;
///
/// let weather = TransitionMatrix::from_rows(vec![vec![0.9, 0.1], vec![0.5, 0.5]])?;
/// let stationary = weather.stationary_distribution()?;
/// assert!((stationary[0] - 5.0 / 6.0).abs() < 1e-15);
///
/// let error = TransitionMatrix::from_rows(vec![vec![0.9, 0.1], vec![0.5, 0.4]]).unwrap_err();
/// assert_eq!(
///     error.to_string(),
///     "row 1 sums to 0.9; divide its entries by that, or put what is missing on column 1 (to stay)"
/// );
/// # Ok::<(), ergodic_metropolis::finite::FiniteError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Vec<f64>>", into = "Vec<Vec<f64>>")]
pub struct TransitionMatrix {
    states: usize,
    entries: Vec<f64>,
}

/// Rows may miss 1 by this much: what decimals and sums of a few hundred entries lose to rounding.
const ROW_TOLERANCE: f64 = 1e-12;

impl TransitionMatrix {
    /// The matrix with these rows.
    ///
    /// # Errors
    ///
    /// No rows, rows of the wrong length, entries that are no probabilities, rows that do not sum to 1 (to 1e-12).
    pub fn from_rows(rows: Vec<Vec<f64>>) -> Result<Self, FiniteError> {
        let states = rows.len();
        if states == 0 {
            return Err(FiniteError::Empty);
        }
        for (row, entries) in rows.iter().enumerate() {
            if entries.len() != states {
                return Err(FiniteError::NotSquare { row, length: entries.len(), states });
            }
            for (column, &value) in entries.iter().enumerate() {
                if !(0.0..=1.0 + ROW_TOLERANCE).contains(&value) {
                    return Err(FiniteError::Entry { row, column, value });
                }
            }
            let sum: f64 = entries.iter().sum();
            if (sum - 1.0).abs() > ROW_TOLERANCE {
                return Err(FiniteError::RowSum { row, sum });
            }
        }
        Ok(Self { states, entries: rows.concat() })
    }

    /// The Metropolis-Hastings chain that proposes by `proposal` and has its stationary distribution proportional to
    /// `target`.
    ///
    /// # Errors
    ///
    /// A target of the wrong length, with entries that are no weights, or without any weight.
    pub fn from_metropolis_hastings(proposal: &Self, target: &[f64]) -> Result<Self, FiniteError> {
        if target.len() != proposal.states {
            return Err(FiniteError::Length { length: target.len(), states: proposal.states });
        }
        let target = super::FiniteTarget::new(target.to_vec())?;
        let states: Vec<usize> = (0..proposal.states).collect();
        let kernel = super::FiniteProposal::new(proposal.clone());
        Self::enumerate(&target, &kernel, &(), &states, |_, _| vec![()])
    }

    /// Writes down the chain that `mutation` makes under `target` on the state space `states`, with the acceptance rule of
    /// [`Chain`](crate::Chain).
    ///
    /// `plans` lists every plan by which the second state may be proposed from the first (plans that cannot happen may be
    /// among them; their density is 0). What is not accepted, nor proposed at all, stays.
    ///
    /// # Errors
    ///
    /// A target or density that is not a number, or densities that sum to more than 1: then they are not the densities of a
    /// proposal over `states`, and the row is named.
    pub fn enumerate<T, M>(
        target: &T,
        mutation: &M,
        space: &M::Space,
        states: &[M::State],
        plans: impl Fn(&M::State, &M::State) -> Vec<M::Plan>,
    ) -> Result<Self, FiniteError>
    where
        T: Target<State = M::State>,
        M: Mutation,
    {
        let values: Vec<T::Value> = states.iter().map(|x| target.evaluate(x)).collect();
        let mut rows = Vec::with_capacity(states.len());
        for (i, x) in states.iter().enumerate() {
            let mut row = vec![0.0; states.len()];
            let (mut proposed, mut moved) = (0.0, 0.0);
            for (j, y) in states.iter().enumerate() {
                for plan in plans(x, y) {
                    let ln_density = mutation.ln_density(space, x, y, plan);
                    if ln_density == f64::NEG_INFINITY {
                        continue;
                    }
                    let a = acceptance::<T, M>(mutation, space, (x, &values[i]), (y, &values[j]), plan)
                        .map_err(|_| FiniteError::Faulty { from: i, to: j })?;
                    let density = libm::exp(ln_density);
                    proposed += density;
                    if i != j {
                        row[j] += density * a;
                        moved += density * a;
                    }
                }
            }
            if proposed > 1.0 + ROW_TOLERANCE {
                return Err(FiniteError::RowSum { row: i, sum: proposed });
            }
            row[i] = (1.0 - moved).max(0.0);
            rows.push(row);
        }
        Self::from_rows(rows)
    }

    /// The number of states.
    pub fn states(&self) -> usize {
        self.states
    }

    /// The probabilities of going from `state` to each state.
    ///
    /// # Panics
    ///
    /// If there is no such state.
    pub fn row(&self, state: usize) -> &[f64] {
        &self.entries[state * self.states..(state + 1) * self.states]
    }

    /// The sum of each row: 1 to rounding.
    pub fn row_sums(&self) -> Vec<f64> {
        (0..self.states).map(|state| self.row(state).iter().sum()).collect()
    }

    /// The state after `state`.
    ///
    /// # Panics
    ///
    /// If there is no such state.
    pub fn step(&self, state: usize, rng: &mut impl RandomSource) -> usize {
        let mut remaining = rng.uniform();
        let mut last = state;
        for (next, &probability) in self.row(state).iter().enumerate() {
            if probability > 0.0 {
                last = next;
                remaining -= probability;
                if remaining < 0.0 {
                    break;
                }
            }
        }
        last
    }

    /// The distribution after `steps` steps from the distribution `start`.
    ///
    /// # Errors
    ///
    /// A start of the wrong length.
    pub fn distribution_after(&self, start: &[f64], steps: usize) -> Result<Vec<f64>, FiniteError> {
        self.check_length(start)?;
        let mut now = start.to_vec();
        for _ in 0..steps {
            now = self.after_one(&now);
        }
        Ok(now)
    }

    /// The row vector `distribution` times the matrix.
    fn after_one(&self, distribution: &[f64]) -> Vec<f64> {
        let mut next = vec![0.0; self.states];
        for (state, weight) in distribution.iter().enumerate() {
            for (sum, probability) in next.iter_mut().zip(self.row(state)) {
                *sum += weight * probability;
            }
        }
        next
    }

    /// How much one step changes `distribution`, as the largest difference of an entry: 0 if it is stationary.
    ///
    /// # Errors
    ///
    /// A distribution of the wrong length.
    pub fn stationarity_residual(&self, distribution: &[f64]) -> Result<f64, FiniteError> {
        let after = self.distribution_after(distribution, 1)?;
        Ok(after.iter().zip(distribution).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max))
    }

    /// The largest |π_i P_ij - π_j P_ji| for π = `distribution`, with the states i < j that have it: 0 if the chain is
    /// reversible with respect to it.
    ///
    /// # Errors
    ///
    /// A distribution of the wrong length.
    pub fn detailed_balance_residual(&self, distribution: &[f64]) -> Result<(f64, usize, usize), FiniteError> {
        self.check_length(distribution)?;
        let mut worst = (0.0, 0, 0);
        for i in 0..self.states {
            for j in i + 1..self.states {
                let residual = (distribution[i] * self.row(i)[j] - distribution[j] * self.row(j)[i]).abs();
                if residual > worst.0 {
                    worst = (residual, i, j);
                }
            }
        }
        Ok(worst)
    }

    pub(super) fn check_length(&self, values: &[f64]) -> Result<(), FiniteError> {
        if values.len() == self.states {
            Ok(())
        } else {
            Err(FiniteError::Length { length: values.len(), states: self.states })
        }
    }
}

impl TryFrom<Vec<Vec<f64>>> for TransitionMatrix {
    type Error = FiniteError;

    fn try_from(rows: Vec<Vec<f64>>) -> Result<Self, FiniteError> {
        Self::from_rows(rows)
    }
}

impl From<TransitionMatrix> for Vec<Vec<f64>> {
    fn from(matrix: TransitionMatrix) -> Self {
        (0..matrix.states).map(|state| matrix.row(state).to_vec()).collect()
    }
}
