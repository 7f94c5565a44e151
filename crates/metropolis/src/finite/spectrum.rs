//! Eigenvalues of a reversible chain: how fast it forgets, and which observable it forgets last.

use super::{FiniteError, TransitionMatrix};

/// Eigenvalues of a reversible transition matrix, all real, largest first, with the right eigenvectors.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Eigenvalues in descending order. The first is 1.
    pub values: Vec<f64>,
    /// For each eigenvalue a function φ of the state with P φ = λ φ and variance 1 under the stationary distribution (for the
    /// first, φ = ±1). Along the chain φ has autocorrelation λ^t.
    pub functions: Vec<Vec<f64>>,
}

impl Spectrum {
    /// The largest modulus but the first: the distance to the stationary distribution shrinks by this factor a step.
    /// 0 for a single state.
    pub fn second_modulus(&self) -> f64 {
        self.values.iter().skip(1).map(|v| v.abs()).fold(0.0, f64::max)
    }

    /// Integrated autocorrelation time of the function of eigenvalue `index`: (1 + λ) / (1 - λ).
    pub fn autocorrelation_time(&self, index: usize) -> f64 {
        (1.0 + self.values[index]) / (1.0 - self.values[index])
    }
}

/// Detailed balance may fail by this much and still be rounding.
const REVERSIBLE: f64 = 1e-12;
/// Cyclic Jacobi converges quadratically; matrices of several hundred states take fewer than ten sweeps.
const SWEEPS: usize = 60;

impl TransitionMatrix {
    /// The spectrum of a reversible chain, by Jacobi rotations of diag(√π) P diag(1/√π), which is symmetric.
    ///
    /// # Errors
    ///
    /// A chain that is reducible, or that is not reversible with respect to its stationary distribution.
    pub fn reversible_spectrum(&self) -> Result<Spectrum, FiniteError> {
        let distribution = self.stationary_distribution()?;
        let (residual, row, column) = self.detailed_balance_residual(&distribution)?;
        if residual > REVERSIBLE {
            return Err(FiniteError::NotReversible { row, column, residual });
        }
        let root: Vec<f64> = distribution.iter().map(|p| p.sqrt()).collect();
        let n = self.states();
        let entry = |i: usize, j: usize| root[i] * self.row(i)[j] / root[j];
        // The mean of both sides makes the symmetry exact.
        let symmetric = (0..n).map(|i| (0..n).map(|j| 0.5 * (entry(i, j) + entry(j, i))).collect()).collect();
        let (values, vectors) = jacobi(symmetric);
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| values[b].total_cmp(&values[a]));
        Ok(Spectrum {
            values: order.iter().map(|&k| values[k]).collect(),
            functions: order.iter().map(|&k| (0..n).map(|i| vectors[k][i] / root[i]).collect()).collect(),
        })
    }
}

/// Eigenvalues of a symmetric matrix, and for each its eigenvector of length 1, by cyclic Jacobi rotations (Golub and
/// Van Loan, section 8.5).
fn jacobi(mut a: Vec<Vec<f64>>) -> (Vec<f64>, Vec<Vec<f64>>) {
    let n = a.len();
    // Row k of v becomes the eigenvector of a[k][k].
    let mut v: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    for _ in 0..SWEEPS {
        let off: f64 = (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| a[i][j] * a[i][j]).sum();
        if off < 1e-30 {
            break;
        }
        for p in 0..n {
            for q in p + 1..n {
                if a[p][q].abs() < 1e-300 {
                    continue;
                }
                let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                let t = theta.signum() / (theta.abs() + libm::hypot(theta, 1.0));
                let cosine = 1.0 / libm::hypot(t, 1.0);
                let sine = t * cosine;
                for row in &mut a {
                    (row[p], row[q]) = (cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]);
                }
                rotate_rows(&mut a, p, q, cosine, sine);
                rotate_rows(&mut v, p, q, cosine, sine);
            }
        }
    }
    ((0..n).map(|k| a[k][k]).collect(), v)
}

fn rotate_rows(rows: &mut [Vec<f64>], p: usize, q: usize, cosine: f64, sine: f64) {
    let (low, high) = rows.split_at_mut(q);
    for (x, y) in low[p].iter_mut().zip(&mut high[0]) {
        (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
    }
}
