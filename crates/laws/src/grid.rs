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
    // Below one sample in a thousand runs, the lack is the quadrature's error and no failure is allowed.
    let lack = (1.0 - mass) * n;
    let quadrature = 1e-4 * n;
    expected.push(lack.max(0.0));
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
    if failed == 0 && lack < quadrature {
        expected[cells] = 0.0;
    }
    Ok(GridChiSquare { chi_square: chi_square(&observed, &expected, 5.0)?, mass, failed })
}
