//! Multiplexed sampling (Hachisuka, Kaplanyan and Dachsbacher 2014): one path by one strategy, both chosen by coordinates.
//!
//! A path of k edges can be made by k + 1 strategies. Bidirectional path tracing makes all of them from one pair of walks; here a
//! coordinate chooses one, so that a sample is one path and the chain learns by which strategy a region is best sampled. The
//! estimate is that of the strategy, weighted by the power heuristic, over the probability of the choice. The length is a coordinate
//! too, where Hachisuka et al. give each chain a length for good; only large steps change it.

use std::sync::Arc;

use ergodic_metropolis::RandomSource;
use ergodic_pathspace::{BidirectionalSampler, Connection, Lengths, PathClass, Roulette, Scene};
use ergodic_scattering::{Everything, Repertoire, Rgb, luminance};
use glam::DVec2;

use super::coordinates::CHOICES;
use crate::observer::{Observer, Unobserved};
use crate::sampling::Estimator;
use crate::streams::{Purpose, stream};

/// Samples that the shares of the lengths come from, and how many of them there are between two looks at the clock, one round at least.
const PILOT: u64 = 4096;
const ROUND: u64 = 64;

/// The part of the time for seeding that they may take.
pub(crate) const PILOT_PART_OF_SEEDING: f64 = 0.125;

/// A length has at least this share of what it would have if all were alike, so that none that carries light is lost.
const FLOOR: f64 = 0.1;

/// Multiplexed sampling.
#[derive(Clone, Debug)]
pub struct Multiplexed<R: Repertoire = Everything> {
    lengths: Lengths,
    /// Probability of each length, from the shortest on.
    shares: Arc<[f64]>,
    sampler: BidirectionalSampler<R>,
    class: PathClass,
}

impl<R: Repertoire> Multiplexed<R> {
    /// Multiplexed sampling of paths of the given lengths, chosen by about as often as they carry light in `scene`. The picture's
    /// expectation does not depend on these shares.
    pub fn new(scene: &Scene<R>, lengths: Lengths, seed: u64) -> Self {
        Self::until(scene, lengths, seed, &Unobserved)
    }

    /// The same with shares that are less well known if `observer` wants to stop.
    pub(crate) fn until(scene: &Scene<R>, lengths: Lengths, seed: u64, observer: &dyn Observer) -> Self {
        let count = (lengths.max_edges + 1).saturating_sub(lengths.min_edges);
        let mut sampler = BidirectionalSampler::new(lengths, Roulette::OFF);
        let mut sums = vec![0.0; count];
        for index in 0..if count > 1 { PILOT } else { 0 } {
            if index > 0 && index % ROUND == 0 && observer.should_stop() {
                break;
            }
            sampler.sample(scene, &mut stream(seed, Purpose::Pilot, index), |_, connection| {
                let light = luminance(connection.contribution());
                if light.is_finite() {
                    sums[connection.s + connection.t - 1 - lengths.min_edges] += light;
                }
            });
        }
        let mean = sums.iter().sum::<f64>() / count.max(1) as f64;
        let weights = sums.iter().map(|sum| if mean > 0.0 { sum / mean + FLOOR } else { 1.0 });
        let total: f64 = weights.clone().sum();
        Self { lengths, shares: weights.map(|weight| weight / total).collect(), sampler, class: PathClass::MANY }
    }

    /// The length that `u` in [0, 1) chooses, and its probability.
    fn length(&self, mut u: f64) -> (usize, f64) {
        let last = self.shares.len().saturating_sub(1);
        for (i, share) in self.shares.iter().enumerate() {
            if u < *share || i == last {
                return (self.lengths.min_edges + i, *share);
            }
            u -= share;
        }
        (self.lengths.min_edges, 1.0)
    }

    /// Chooses a length as a sample does, walks from both ends, and calls `sink` for each of the length's strategies by which the walks
    /// make a path that carries light: with the length, the probability of its choice, and s.
    pub(super) fn all_strategies(
        &mut self,
        scene: &Scene<R>,
        rng: &mut impl RandomSource,
        mut sink: impl FnMut((usize, f64), usize, &Connection),
    ) {
        rng.enter(CHOICES, 0);
        let (k, share) = self.length(rng.uniform());
        let sampler = &mut self.sampler;
        sampler.draw_wavelength(scene, rng);
        sampler.eye.walk(scene, k + 1, &Roulette::OFF, rng);
        sampler.light.walk(scene, k, &Roulette::OFF, rng);
        for s in 0..=k.min(sampler.light.len()) {
            let t = k + 1 - s;
            if t <= sampler.eye.len()
                && let Some(connection) = sampler.connect(scene, s, t)
            {
                sink((k, share), s, &connection);
            }
        }
    }
}

impl<R: Repertoire> Estimator for Multiplexed<R> {
    type Repertoire = R;

    fn sample(&mut self, scene: &Scene<R>, rng: &mut impl RandomSource, mut splat: impl FnMut(DVec2, Rgb)) {
        rng.enter(CHOICES, 0);
        let (k, share) = self.length(rng.uniform());
        rng.enter(CHOICES, 1);
        let s = rng.below(k + 1);
        let t = k + 1 - s;
        self.class = PathClass { length: k as u32, specular: 0 };
        let Self { sampler, class, .. } = self;
        sampler.draw_wavelength(scene, rng);
        sampler.eye.walk(scene, t, &Roulette::OFF, rng);
        if sampler.eye.len() < t {
            return;
        }
        if s > 0 {
            sampler.light.walk(scene, s, &Roulette::OFF, rng);
            if sampler.light.len() < s {
                return;
            }
        }
        let Some(connection) = sampler.connect(scene, s, t) else { return };
        *class = sampler.class(s, t);
        splat(connection.raster, connection.contribution() * ((k + 1) as f64 / share));
    }

    fn class(&self) -> PathClass {
        self.class
    }
}
