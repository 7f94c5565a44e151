//! Pearson's chi-square test of counts against expectations.

use std::fmt;

use crate::chi_square_tail;

/// The outcome of a chi-square test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChiSquare {
    /// Sum of (observed - expected)² / expected over the pooled cells.
    pub statistic: f64,
    /// Pooled cells less one.
    pub dof: usize,
    /// Probability of a statistic at least as large if the expectations are right.
    pub p_value: f64,
}

/// Why counts and expectations cannot be compared, or are incompatible whatever the statistic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ChiSquareError {
    /// There are not as many counts as expectations.
    Lengths {
        /// Number of counts.
        observed: usize,
        /// Number of expectations.
        expected: usize,
    },
    /// An expectation is negative or not finite.
    Expectation {
        /// Which cell.
        cell: usize,
        /// The expectation.
        expected: f64,
    },
    /// Samples fell where the density says that none can.
    Impossible {
        /// Which cell.
        cell: usize,
        /// How many samples fell into it.
        observed: u64,
    },
    /// Counts and expectations differ in total by more than 1 %: the density has not the mass of the sampler.
    Totals {
        /// All samples.
        observed: u64,
        /// Sum of the expectations.
        expected: f64,
    },
    /// Fewer than two cells are left after pooling: there is nothing to test.
    TooFewCells,
}

impl fmt::Display for ChiSquareError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Lengths { observed, expected } => write!(f, "{observed} counts but {expected} expectations"),
            Self::Expectation { cell, expected } => write!(f, "cell {cell} expects {expected} samples"),
            Self::Impossible { cell, observed } => {
                write!(f, "{observed} samples in cell {cell}, where the density is 0")
            }
            Self::Totals { observed, expected } => {
                write!(f, "{observed} samples, but the expectations sum to {expected}")
            }
            Self::TooFewCells => write!(f, "fewer than two cells are left after pooling"),
        }
    }
}

impl std::error::Error for ChiSquareError {}

/// Pearson's chi-square of `observed` counts against `expected` ones.
///
/// Cells that expect fewer than `min_expected` (5 is usual) are pooled with others, smallest first, until the pool
/// expects as many. Every possible outcome must have its cell, so that the totals agree.
///
/// # Errors
///
/// See [`ChiSquareError`]; above all a sample in a cell that expects none, which no statistic can excuse.
pub fn chi_square(observed: &[u64], expected: &[f64], min_expected: f64) -> Result<ChiSquare, ChiSquareError> {
    if observed.len() != expected.len() {
        return Err(ChiSquareError::Lengths { observed: observed.len(), expected: expected.len() });
    }
    for (cell, (&count, &expectation)) in observed.iter().zip(expected).enumerate() {
        if !expectation.is_finite() || expectation < 0.0 {
            return Err(ChiSquareError::Expectation { cell, expected: expectation });
        }
        if expectation == 0.0 && count > 0 {
            return Err(ChiSquareError::Impossible { cell, observed: count });
        }
    }
    let (total, mass): (u64, f64) = (observed.iter().sum(), expected.iter().sum());
    if (total as f64 - mass).abs() > 0.01 * mass {
        return Err(ChiSquareError::Totals { observed: total, expected: mass });
    }

    let pooled = pool(observed, expected, min_expected);
    if pooled.len() < 2 {
        return Err(ChiSquareError::TooFewCells);
    }
    let statistic = pooled.iter().map(|(count, expectation)| (count - expectation).powi(2) / expectation).sum();
    let dof = pooled.len() - 1;
    Ok(ChiSquare { statistic, dof, p_value: chi_square_tail(statistic, dof as f64) })
}

/// Cells as (count, expectation), small ones joined until each expects at least `min_expected`.
fn pool(observed: &[u64], expected: &[f64], min_expected: f64) -> Vec<(f64, f64)> {
    let mut cells: Vec<(f64, f64)> =
        observed.iter().zip(expected).filter(|(_, e)| **e > 0.0).map(|(&o, &e)| (o as f64, e)).collect();
    cells.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut pooled = Vec::with_capacity(cells.len());
    let mut open = (0.0, 0.0);
    for (count, expectation) in cells {
        open = (open.0 + count, open.1 + expectation);
        if open.1 >= min_expected {
            pooled.push(std::mem::take(&mut open));
        }
    }
    if open.1 > 0.0 {
        // All cells together expect too few, or a last pool stayed open: it joins the largest.
        match pooled.last_mut() {
            Some(last) => *last = (last.0 + open.0, last.1 + open.1),
            None => pooled.push(open),
        }
    }
    pooled
}

#[cfg(test)]
mod tests {
    use ergodic_metropolis::RandomSource;

    use super::*;

    /// Counts of `n` draws from `probabilities`.
    fn counts(probabilities: &[f64], n: u64, seed: u64) -> Vec<u64> {
        let mut rng = crate::generator(seed);
        let mut counts = vec![0; probabilities.len()];
        for _ in 0..n {
            let mut u = rng.uniform();
            let cell = probabilities.iter().position(|p| {
                u -= p;
                u < 0.0
            });
            counts[cell.unwrap_or(probabilities.len() - 1)] += 1;
        }
        counts
    }

    #[test]
    fn statistic_by_hand() {
        let result = chi_square(&[10, 20, 30], &[15.0, 20.0, 25.0], 5.0).unwrap();
        assert!((result.statistic - (25.0 / 15.0 + 25.0 / 25.0)).abs() < 1e-12);
        assert_eq!(result.dof, 2);
        assert!((result.p_value - (-result.statistic / 2.0f64).exp()).abs() < 1e-12);
    }

    #[test]
    fn small_cells_are_pooled() {
        let result = chi_square(&[1, 2, 3, 50, 44], &[2.0, 2.0, 2.0, 47.0, 47.0], 5.0).unwrap();
        assert_eq!(result.dof, 2);
        assert!((result.statistic - (9.0 / 47.0 + 9.0 / 47.0)).abs() < 1e-12);
    }

    #[test]
    fn p_values_are_uniform_and_a_wrong_cell_is_found() {
        let right = [0.1, 0.2, 0.3, 0.4];
        let wrong = [0.105, 0.195, 0.3, 0.4];
        let n = 40_000;
        let expected = |p: &[f64], n: u64| p.iter().map(|p| p * n as f64).collect::<Vec<_>>();
        let mut p_values: Vec<f64> = (0..400)
            .map(|seed| chi_square(&counts(&right, n, seed), &expected(&right, n), 5.0).unwrap().p_value)
            .collect();
        assert!(crate::kolmogorov_smirnov_uniform(&mut p_values).p_value > 1e-3);
        let found = chi_square(&counts(&right, 25 * n, 7), &expected(&wrong, 25 * n), 5.0).unwrap();
        assert!(found.p_value < 1e-9, "{found:?}");
    }

    #[test]
    fn what_no_statistic_can_excuse() {
        let impossible = chi_square(&[10, 1], &[11.0, 0.0], 5.0);
        assert_eq!(impossible, Err(ChiSquareError::Impossible { cell: 1, observed: 1 }));
        assert!(matches!(chi_square(&[10], &[5.0, 5.0], 5.0), Err(ChiSquareError::Lengths { .. })));
        assert!(matches!(chi_square(&[10, 0], &[5.0, f64::NAN], 5.0), Err(ChiSquareError::Expectation { .. })));
        assert!(matches!(chi_square(&[10, 10], &[50.0, 50.0], 5.0), Err(ChiSquareError::Totals { .. })));
        assert_eq!(chi_square(&[2, 1], &[2.0, 1.0], 5.0), Err(ChiSquareError::TooFewCells));
    }
}
