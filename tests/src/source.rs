//! Exact weighted samples of paths.

use ergodic_metropolis::RandomSource;
use ergodic_pathspace::{BidirectionalSampler, Path, PathSpace, Roulette};
use ergodic_scattering::luminance;

/// Paths with weights: the expectation of weight times h(path) is the integral of C h.
#[derive(Debug)]
pub struct PathSource<'a> {
    space: &'a PathSpace,
    sampler: BidirectionalSampler,
}

impl<'a> PathSource<'a> {
    /// Samples the space's paths bidirectionally.
    pub fn new(space: &'a PathSpace) -> Self {
        let roulette = Roulette { start: 5, survival: 0.8 };
        Self { space, sampler: BidirectionalSampler::new(space.lengths, roulette) }
    }

    /// Writes one path and returns its weight; `None` for a sample that found no light.
    ///
    /// Of all connections of one pair of walks one is taken with probability proportional to its contribution, and
    /// weighted by the sum.
    pub fn draw(&mut self, path: &mut Path, rng: &mut impl RandomSource) -> Option<f64> {
        let mut found: Vec<(usize, usize, f64)> = Vec::new();
        self.sampler.sample(&self.space.scene, rng, |_, c| {
            let weight = luminance(c.contribution());
            if weight > 0.0 {
                found.push((c.s, c.t, weight));
            }
        });
        let total: f64 = found.iter().map(|(_, _, w)| w).sum();
        let mut remaining = rng.uniform() * total;
        let &(mut s, mut t, _) = found.last()?;
        for &(a, b, weight) in &found {
            if remaining < weight {
                (s, t) = (a, b);
                break;
            }
            remaining -= weight;
        }
        self.sampler.assemble(&self.space.scene, s, t, path);
        Some(total)
    }
}
