//! Bidirectional path tracing with light image (Veach 10).

use ergodic_metropolis::RandomSource;
use ergodic_pathspace::{BidirectionalSampler, Lengths, Roulette, Scene};
use ergodic_scattering::Rgb;
use glam::DVec2;

use crate::sampling::Estimator;

/// Bidirectional path tracing.
#[derive(Clone, Debug)]
pub struct BidirectionalPathTracer {
    sampler: BidirectionalSampler,
}

impl BidirectionalPathTracer {
    /// Bidirectional path tracing of paths of the given lengths.
    pub fn new(lengths: Lengths, roulette: Roulette) -> Self {
        Self { sampler: BidirectionalSampler::new(lengths, roulette) }
    }
}

impl Estimator for BidirectionalPathTracer {
    fn sample(&mut self, scene: &Scene, rng: &mut impl RandomSource, mut splat: impl FnMut(DVec2, Rgb)) {
        self.sampler.sample(scene, rng, |_, connection| splat(connection.raster, connection.contribution()));
    }
}
