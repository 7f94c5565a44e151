//! Mutations of a point of the unit cube, the space of primary samples (Kelemen et al. 2002).

use std::convert::Infallible;

use serde::{Deserialize, Serialize};

use crate::{Density, Mutation, RandomSource};

/// Draws every coordinate anew, uniformly: Kelemen's large step. It reaches everything, so a mixture that has it is ergodic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct LargeStep {}

/// Moves every coordinate by a size between `min` and `max` whose logarithm is uniform, to either side, and wraps around:
/// Kelemen's small step (Kelemen et al. 2002, section 5). The cube is a torus to it, so that no border is special.
///
/// ```
/// use ergodic_metropolis::unit_cube::SmallStep;
/// use ergodic_metropolis::{Mutation, Replay};
///
/// let step = SmallStep { min: 1.0 / 1024.0, max: 1.0 / 64.0 };
/// let (x, mut y) = (vec![0.999, 0.5], Vec::new());
/// // The first number of a coordinate gives the size, the second the side.
/// step.propose(&(), &x, &mut y, &mut Replay::new(vec![0.0, 0.9, 0.0, 0.1]))?;
/// assert!((y[0] - (0.999 + 1.0 / 64.0 - 1.0)).abs() < 1e-12 && (y[1] - (0.5 - 1.0 / 64.0)).abs() < 1e-12);
/// assert!((step.ln_density(&(), &x, &y, ()) - step.ln_density(&(), &y, &x, ())).abs() < 1e-9);
/// # Ok::<(), std::convert::Infallible>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct SmallStep {
    /// Smallest size, greater than 0.
    pub min: f64,
    /// Largest size, less than 1/2.
    pub max: f64,
}

/// Sizes recomputed from two points differ from those drawn by rounding; the range is this much wider when looked at from
/// outside.
const SLACK: f64 = 1e-9;

impl SmallStep {
    /// One coordinate moved.
    #[inline]
    pub fn moved(&self, from: f64, rng: &mut impl RandomSource) -> f64 {
        let size = self.max * libm::exp(-libm::log(self.max / self.min) * rng.uniform());
        let moved = if rng.uniform() < 0.5 { from - size } else { from + size };
        // Rounding may make 1 of what lies just below 0.
        moved.rem_euclid(1.0).min(1f64.next_down())
    }

    /// The density of one coordinate: 1 / (2 d ln(max/min)) at the distance d on the circle.
    #[inline]
    pub fn pdf(&self, from: f64, to: f64) -> f64 {
        let apart = (from - to).abs();
        let size = apart.min(1.0 - apart);
        let allowed = size >= self.min * (1.0 - SLACK) - f64::EPSILON && size <= self.max * (1.0 + SLACK);
        if allowed { 1.0 / (2.0 * size * libm::log(self.max / self.min)) } else { 0.0 }
    }
}

impl Mutation for LargeStep {
    type Space = ();
    type State = Vec<f64>;
    type Plan = ();
    type Failure = Infallible;

    fn propose(&self, _: &(), x: &Vec<f64>, y: &mut Vec<f64>, rng: &mut impl RandomSource) -> Result<(), Infallible> {
        y.clear();
        y.extend(x.iter().map(|_| rng.uniform()));
        Ok(())
    }

    fn ln_density(&self, _: &(), _: &Vec<f64>, _: &Vec<f64>, _: ()) -> f64 {
        0.0
    }
}

impl Mutation for SmallStep {
    type Space = ();
    type State = Vec<f64>;
    type Plan = ();
    type Failure = Infallible;

    fn propose(&self, _: &(), x: &Vec<f64>, y: &mut Vec<f64>, rng: &mut impl RandomSource) -> Result<(), Infallible> {
        y.clear();
        y.extend(x.iter().map(|x| self.moved(*x, rng)));
        Ok(())
    }

    fn ln_density(&self, _: &(), from: &Vec<f64>, to: &Vec<f64>, _: ()) -> f64 {
        let mut density = Density::ONE;
        from.iter().zip(to).for_each(|(from, to)| density.multiply(self.pdf(*from, *to)));
        density.ln()
    }
}
