//! A sampler of directions against its density in solid angle.

use std::f64::consts::PI;

use crate::{ChiSquareError, Grid, GridChiSquare, grid_chi_square};

/// Cells in (cos θ, φ) about a pole: coordinates whose product measure is solid angle.
#[derive(Clone, Debug, PartialEq)]
pub struct SphereGrid {
    grid: Grid,
    frame: [[f64; 3]; 3],
}

impl SphereGrid {
    /// `rows` equal steps of cos θ times `columns` equal steps of φ, about +z.
    ///
    /// An even number of rows puts an edge on the horizon, where hemispherical densities end; an odd number of columns keeps
    /// symmetric mistakes from hiding in symmetric cells.
    pub fn new(rows: usize, columns: usize) -> Self {
        Self {
            grid: Grid::uniform((-1.0, 1.0), rows, (-PI, PI), columns),
            frame: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        }
    }

    /// The same cells about `pole`, a unit vector: for a lobe around it.
    #[must_use]
    pub fn around(mut self, pole: [f64; 3]) -> Self {
        // Frame of Duff et al. 2017.
        let [x, y, z] = pole;
        let sign = 1.0f64.copysign(z);
        let a = -1.0 / (sign + z);
        let b = x * y * a;
        self.frame = [[1.0 + sign * x * x * a, sign * b, -sign * x], [b, sign + y * y * a, -y], pole];
        self
    }

    /// Steps of cos θ that grow geometrically from the pole, the first `narrowest` wide in 1 - cos θ: for a lobe that one
    /// of the equal steps would swallow whole.
    #[must_use]
    pub fn concentrated(mut self, narrowest: f64) -> Self {
        let rows = self.grid.u.len() - 1;
        let ratio = (2.0 / narrowest).powf(1.0 / (rows.max(2) - 1) as f64);
        let mut edges = vec![1.0];
        edges.extend((0..rows - 1).map(|i| 1.0 - narrowest * ratio.powi(i as i32)));
        edges.push(-1.0);
        edges.reverse();
        self.grid.u = edges;
        self
    }

    fn coordinates(&self, direction: [f64; 3]) -> (f64, f64) {
        let along = |axis: [f64; 3]| axis.iter().zip(direction).map(|(a, d)| a * d).sum::<f64>();
        let [x, y, z] = self.frame.map(along);
        // Rounding may push a unit vector's component past 1; a vector that is not a unit vector stays outside.
        let cosine = if z.abs() <= 1.0 + 1e-9 { z.clamp(-1.0, 1.0) } else { z };
        (cosine, y.atan2(x))
    }

    fn direction(&self, cosine: f64, phi: f64) -> [f64; 3] {
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let local = [sine * phi.cos(), sine * phi.sin(), cosine];
        [0, 1, 2].map(|i| (0..3).map(|k| self.frame[k][i] * local[k]).sum())
    }
}

/// Tests `samples` draws of `sample`, unit vectors or nothing, against `pdf_solid_angle`.
///
/// # Errors
///
/// As [`grid_chi_square`].
pub fn sphere_chi_square(
    grid: &SphereGrid,
    samples: u64,
    mut sample: impl FnMut() -> Option<[f64; 3]>,
    pdf_solid_angle: impl Fn([f64; 3]) -> f64,
) -> Result<GridChiSquare, ChiSquareError> {
    grid_chi_square(
        &grid.grid,
        samples,
        || sample().map(|direction| grid.coordinates(direction)),
        |cosine, phi| pdf_solid_angle(grid.direction(cosine, phi)),
    )
}

#[cfg(test)]
mod tests {
    use ergodic_metropolis::RandomSource;

    use super::*;

    /// A cosine power lobe about +z, turned to `pole` by mirroring.
    fn lobe(exponent: f64, rng: &mut impl RandomSource) -> [f64; 3] {
        let cosine = (1.0 - rng.uniform()).powf(1.0 / (exponent + 1.0));
        let (sine, phi) = ((1.0 - cosine * cosine).sqrt(), 2.0 * PI * rng.uniform());
        [sine * phi.cos(), sine * phi.sin(), cosine]
    }

    fn pdf(exponent: f64, direction: [f64; 3]) -> f64 {
        (exponent + 1.0) / (2.0 * PI) * direction[2].max(0.0).powf(exponent)
    }

    #[test]
    fn a_lobe_passes_on_every_grid_and_a_wrong_exponent_on_none() {
        let grids = [
            SphereGrid::new(20, 21),
            SphereGrid::new(20, 21).around([0.6, 0.0, 0.8]),
            SphereGrid::new(20, 21).concentrated(1e-3),
        ];
        for (seed, grid) in grids.iter().enumerate() {
            for exponent in [1.0, 40.0] {
                let run = |claimed: f64| {
                    let mut rng = crate::generator(seed as u64);
                    sphere_chi_square(grid, 200_000, || Some(lobe(exponent, &mut rng)), |d| pdf(claimed, d)).unwrap()
                };
                let right = run(exponent);
                assert!(right.chi_square.p_value > 1e-3, "{right:?}");
                let wrong = run(exponent * 1.1);
                assert!(wrong.chi_square.p_value < 1e-6, "{wrong:?}");
            }
        }
    }

    #[test]
    fn directions_and_coordinates_are_inverse() {
        let mut rng = crate::generator(3);
        for pole in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.48, -0.64, 0.6], [0.48, -0.64, -0.6]] {
            let grid = SphereGrid::new(4, 4).around(pole);
            for _ in 0..100 {
                let (cosine, phi) = (2.0 * rng.uniform() - 1.0, PI * (2.0 * rng.uniform() - 1.0));
                let (c, p) = grid.coordinates(grid.direction(cosine, phi));
                assert!((c - cosine).abs() < 1e-12 && (p - phi).abs() < 1e-7, "{cosine} {phi}: {c} {p}");
            }
        }
    }
}
