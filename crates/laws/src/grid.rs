//! A sampler of two coordinates against its density, on a grid of cells.

use crate::{ChiSquare, ChiSquareError, chi_square};

/// Rectangular cells over two coordinates, given by their edges in ascending order.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Edges of the first coordinate.
    pub u: Vec<f64>,
    /// Edges of the second coordinate.
    pub v: Vec<f64>,
}

/// The outcome of a sampler's test on a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridChiSquare {
    /// The test over all cells, "no sample" among them.
    pub chi_square: ChiSquare,
    /// Integral of the density over the grid.
    pub mass: f64,
    /// How often the sampler gave nothing.
    pub failed: u64,
}

impl Grid {
    /// `columns` x `rows` equal cells over `u_range` x `v_range`.
    pub fn uniform(u_range: (f64, f64), columns: usize, v_range: (f64, f64), rows: usize) -> Self {
        let edges = |(low, high): (f64, f64), n: usize| {
            (0..=n).map(|i| if i == n { high } else { low + (high - low) * i as f64 / n as f64 }).collect()
        };
        Self { u: edges(u_range, columns), v: edges(v_range, rows) }
    }

    /// The number of cells.
    pub fn cells(&self) -> usize {
        self.u.len().saturating_sub(1) * self.v.len().saturating_sub(1)
    }

    /// The cell that holds `(u, v)`; the last edges belong to the last cells. `None` outside or for NaN.
    pub fn cell(&self, u: f64, v: f64) -> Option<usize> {
        let find = |edges: &[f64], value: f64| {
            let (first, last) = (*edges.first()?, *edges.last()?);
            if !(first..=last).contains(&value) {
                return None;
            }
            Some(edges.partition_point(|e| *e <= value).clamp(1, edges.len() - 1) - 1)
        };
        Some(find(&self.u, u)? * (self.v.len() - 1) + find(&self.v, v)?)
    }

    /// The integral of `density` over each cell, to `tolerance` each.
    pub fn integrate(&self, density: &impl Fn(f64, f64) -> f64, tolerance: f64) -> Vec<f64> {
        let mut integrals = Vec::with_capacity(self.cells());
        for u in self.u.windows(2) {
            for v in self.v.windows(2) {
                integrals.push(integrate(density, (u[0], u[1]), (v[0], v[1]), tolerance));
            }
        }
        integrals
    }
}

/// Subdivisions that are always made, so that a feature narrower than a cell is not stepped over.
const LEAST_DEPTH: u32 = 2;
/// Subdivisions after which a jump in the density is taken as resolved.
const MOST_DEPTH: u32 = 10;

/// Adaptive integral of `density` over a rectangle: Gauss-Legendre 3 x 3 against its four quarters.
///
/// The tolerance is absolute, plus 1e-4 of the integral, on each piece that is looked at.
pub fn integrate(density: &impl Fn(f64, f64) -> f64, u: (f64, f64), v: (f64, f64), tolerance: f64) -> f64 {
    refine(density, u, v, tolerance, gauss(density, u, v), 0)
}

fn refine(
    density: &impl Fn(f64, f64) -> f64,
    u: (f64, f64),
    v: (f64, f64),
    tolerance: f64,
    coarse: f64,
    depth: u32,
) -> f64 {
    let (mu, mv) = (0.5 * (u.0 + u.1), 0.5 * (v.0 + v.1));
    let quarters = [((u.0, mu), (v.0, mv)), ((u.0, mu), (mv, v.1)), ((mu, u.1), (v.0, mv)), ((mu, u.1), (mv, v.1))];
    let parts = quarters.map(|(u, v)| gauss(density, u, v));
    let fine: f64 = parts.iter().sum();
    let settled = (fine - coarse).abs() <= tolerance + 1e-4 * fine.abs();
    // What is not finite does not become so by looking closer.
    if depth >= MOST_DEPTH || (settled && depth >= LEAST_DEPTH) || !fine.is_finite() {
        return fine;
    }
    quarters.iter().zip(parts).map(|(&(u, v), part)| refine(density, u, v, tolerance, part, depth + 1)).sum()
}

/// Gauss-Legendre with 3 x 3 nodes.
fn gauss(density: &impl Fn(f64, f64) -> f64, u: (f64, f64), v: (f64, f64)) -> f64 {
    const NODES: [(f64, f64); 3] =
        [(-0.774_596_669_241_483_4, 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.774_596_669_241_483_4, 5.0 / 18.0)];
    let at = |(low, high): (f64, f64), node: f64| 0.5 * (low + high) + 0.5 * (high - low) * node;
    let mut sum = 0.0;
    for (nu, wu) in NODES {
        for (nv, wv) in NODES {
            sum += wu * wv * density(at(u, nu), at(v, nv));
        }
    }
    sum * (u.1 - u.0) * (v.1 - v.0)
}

/// Tests `samples` draws of `sample` against `density`, which is per unit of u and v.
///
/// A sampler that gives nothing fills a cell of its own, which expects what the density lacks to 1. A sample outside the
/// grid counts as one where the density is 0.
///
/// # Errors
///
/// See [`ChiSquareError`]. A density that integrates to more than 1 (by more than the quadrature's error) is
/// [`ChiSquareError::Totals`].
pub fn grid_chi_square(
    grid: &Grid,
    samples: u64,
    mut sample: impl FnMut() -> Option<(f64, f64)>,
    density: impl Fn(f64, f64) -> f64,
) -> Result<GridChiSquare, ChiSquareError> {
    let cells = grid.cells();
    let n = samples as f64;
    // An error of a hundredth of a sample in a cell cannot be seen among the n.
    let mut expected = grid.integrate(&density, 0.01 / n);
    let mass: f64 = expected.iter().sum();
    expected.iter_mut().for_each(|e| *e *= n);
    if mass > 1.0 + 1e-3 {
        return Err(ChiSquareError::Totals { observed: samples, expected: mass * n });
    }
    // Two more cells: no sample, and a sample outside the grid.
    let lack = (1.0 - mass).max(0.0);
    expected.push(lack * n);
    expected.push(0.0);

    let mut observed = vec![0u64; cells + 2];
    for _ in 0..samples {
        let cell = match sample() {
            None => cells,
            Some((u, v)) => grid.cell(u, v).unwrap_or(cells + 1),
        };
        observed[cell] += 1;
    }
    let failed = observed[cells];
    // For a sampler that never fails, what the quadrature lacks to 1 is its own error.
    if failed == 0 && lack < 1e-4 {
        expected[cells] = 0.0;
    }
    Ok(GridChiSquare { chi_square: chi_square(&observed, &expected, 5.0)?, mass, failed })
}

#[cfg(test)]
mod tests {
    use ergodic_metropolis::RandomSource;

    use super::*;

    #[test]
    fn integrals_of_known_densities() {
        let smooth = integrate(&|u, v| (u * 3.0).exp() * v * v, (0.0, 1.0), (0.0, 2.0), 1e-9);
        assert!((smooth / ((3.0f64.exp() - 1.0) / 3.0 * 8.0 / 3.0) - 1.0).abs() < 1e-5);
        let inside = |u: f64, v: f64| if u * u + v * v < 1.0 { 1.0 } else { 0.0 };
        let disc: f64 = Grid::uniform((-1.0, 1.0), 20, (-1.0, 1.0), 21).integrate(&inside, 1e-6).iter().sum();
        assert!((disc / std::f64::consts::PI - 1.0).abs() < 1e-4);
    }

    #[test]
    fn every_point_has_one_cell() {
        let grid = Grid::uniform((0.0, 1.0), 3, (-1.0, 1.0), 2);
        assert_eq!(grid.cells(), 6);
        assert_eq!(grid.cell(0.0, -1.0), Some(0));
        assert_eq!(grid.cell(1.0, 1.0), Some(5));
        assert_eq!(grid.cell(0.5, 0.0), Some(3));
        assert_eq!(grid.cell(1.1, 0.0), None);
        assert_eq!(grid.cell(f64::NAN, 0.0), None);
    }

    /// The density 4 u v by inversion; a tenth of the draws give nothing.
    fn test_with(density: impl Fn(f64, f64) -> f64) -> Result<GridChiSquare, ChiSquareError> {
        let mut rng = crate::generator(5);
        let sample = || {
            let (u, v, keep) = (rng.uniform().sqrt(), rng.uniform().sqrt(), rng.uniform() < 0.9);
            keep.then_some((u, v))
        };
        grid_chi_square(&Grid::uniform((0.0, 1.0), 16, (0.0, 1.0), 15), 200_000, sample, density)
    }

    #[test]
    fn a_right_density_passes() {
        let result = test_with(|u, v| 3.6 * u * v).unwrap();
        assert!(result.chi_square.p_value > 1e-3, "{result:?}");
        assert!((result.mass - 0.9).abs() < 1e-6);
    }

    #[test]
    fn wrong_densities_fail() {
        // Exponent 1.1 for 1 in u; failures left out of the density's mass; no density where there are samples.
        let steep = test_with(|u, v| 0.9 * 2.1 * u.powf(1.1) * 2.0 * v).unwrap();
        assert!(steep.chi_square.p_value < 1e-6, "{steep:?}");
        let complete = test_with(|u, v| 4.0 * u * v);
        assert!(matches!(complete, Err(ChiSquareError::Impossible { .. })), "{complete:?}");
        let hole = test_with(|u, v| if u < 0.5 { 0.0 } else { 3.6 * u * v });
        assert!(matches!(hole, Err(ChiSquareError::Impossible { .. })), "{hole:?}");
    }
}
