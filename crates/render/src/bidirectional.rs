//! Bidirectional path tracing with light image (Veach 10).

use ergodic_metropolis::RandomSource;
use ergodic_pathspace::{BidirectionalSampler, Lengths, Roulette, Scene};
use ergodic_scattering::{Everything, Repertoire, Rgb};
use glam::DVec2;

use crate::sampling::Estimator;

/// Bidirectional path tracing.
#[derive(Clone, Debug)]
pub struct BidirectionalPathTracer<R: Repertoire = Everything> {
    sampler: BidirectionalSampler<R>,
}

impl<R: Repertoire> BidirectionalPathTracer<R> {
    /// Bidirectional path tracing of paths of the given lengths.
    pub fn new(lengths: Lengths, roulette: Roulette) -> Self {
        Self { sampler: BidirectionalSampler::new(lengths, roulette) }
    }
}

impl<R: Repertoire> Estimator for BidirectionalPathTracer<R> {
    type Repertoire = R;

    fn sample(&mut self, scene: &Scene<R>, rng: &mut impl RandomSource, mut splat: impl FnMut(DVec2, Rgb)) {
        // Connections to the walk from the eye all arrive where it starts: one splat for all of them.
        let mut by_eye: Option<(DVec2, Rgb)> = None;
        self.sampler.sample(scene, rng, |_, connection| {
            let color = connection.contribution();
            if connection.t == 1 {
                splat(connection.raster, color);
            } else {
                by_eye.get_or_insert((connection.raster, Rgb::ZERO)).1 += color;
            }
        });
        if let Some((raster, color)) = by_eye {
            splat(raster, color);
        }
    }
}
