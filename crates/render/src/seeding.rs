//! Start-up of the chains (Veach 11.3.1): independent bidirectional samples estimate b, and some of them, chosen by their
//! weight, become the chains' first paths. Both from the same samples, so that the whole estimator is unbiased.

use ergodic_metropolis::RandomSource;
use ergodic_pathspace::stability::{Place, is_usable_number};
use ergodic_pathspace::{BidirectionalSampler, Lengths, Path, Roulette, Scene};
use ergodic_scattering::{Repertoire, luminance};
use rand_pcg::Pcg64Dxsm;
use rayon::prelude::*;

use crate::Seeding;
use crate::counts::{Counts, counted};
use crate::observer::{Observer, Stage};
use crate::streams::{Purpose, stream};

/// Samples between two looks at the error of b, as chunks times samples in a chunk.
const CHUNKS: u64 = 64;
const CHUNK: u64 = 256;

/// The samples that chains start from.
#[derive(Clone, Debug)]
pub struct Seeds {
    /// Luminance of every sample, in order.
    weights: Vec<f64>,
    /// Estimate of b, the mean luminance over the image of all paths of the chains' lengths.
    pub b: f64,
    /// Standard error of b over b.
    pub relative_error: f64,
    /// What was traced and left out; a sample that was left out counts as 0.
    pub counts: Counts,
    seed: u64,
    lengths: Lengths,
    roulette: Roulette,
}

impl Seeds {
    /// Samples until the relative standard error of b is small enough, or the samples allowed are used up.
    pub fn draw<R: Repertoire>(
        scene: &Scene<R>,
        lengths: Lengths,
        roulette: Roulette,
        settings: &Seeding,
        seed: u64,
        observer: &dyn Observer,
    ) -> Self {
        let sampler = || BidirectionalSampler::new(lengths, roulette);
        let weigh = |sampler: &mut BidirectionalSampler<R>, rng: &mut Pcg64Dxsm| {
            let mut sum = 0.0;
            sampler.sample(scene, rng, |_, connection| sum += luminance(connection.contribution()));
            sum
        };
        Self::draw_by(sampler, weigh, (lengths, roulette), settings, seed, observer)
    }

    /// The same with samples of any kind: `weigh` takes one with a sampler that `sampler` makes, and gives its luminance.
    pub(crate) fn draw_by<S>(
        sampler: impl Fn() -> S + Sync,
        weigh: impl Fn(&mut S, &mut Pcg64Dxsm) -> f64 + Sync,
        (lengths, roulette): (Lengths, Roulette),
        settings: &Seeding,
        seed: u64,
        observer: &dyn Observer,
    ) -> Self {
        let mut seeds = Self {
            weights: Vec::new(),
            b: 0.0,
            relative_error: 1.0,
            counts: Counts::default(),
            seed,
            lengths,
            roulette,
        };
        let (mut sum, mut sum_of_squares) = (0.0, 0.0);
        if lengths.min_edges > lengths.max_edges {
            // No path is asked for, so b is exactly 0.
            seeds.relative_error = 0.0;
            return seeds;
        }
        // What is no number counts as 0.
        let weigh = |sampler: &mut S, index: u64| {
            let weight = weigh(sampler, &mut stream(seed, Purpose::Seeding, index));
            if is_usable_number(Place::Seed, weight) { weight } else { 0.0 }
        };
        loop {
            let first = seeds.weights.len() as u64;
            let chunks: Vec<(Vec<f64>, Counts)> = (0..CHUNKS)
                .into_par_iter()
                .map(|chunk| {
                    let mut sampler = sampler();
                    let start = first + chunk * CHUNK;
                    counted(|| (start..start + CHUNK).map(|index| weigh(&mut sampler, index)).collect())
                })
                .collect();
            for (weights, counts) in chunks {
                seeds.counts += counts;
                for weight in weights {
                    sum += weight;
                    sum_of_squares += weight * weight;
                    seeds.weights.push(weight);
                }
            }
            let n = seeds.weights.len() as f64;
            seeds.b = sum / n;
            let variance = (sum_of_squares / n - seeds.b * seeds.b).max(0.0) / (n - 1.0);
            seeds.relative_error = if seeds.b > 0.0 { variance.sqrt() / seeds.b } else { f64::INFINITY };
            let by_error = (settings.relative_error / seeds.relative_error).powi(2);
            let by_count = n / settings.max_samples as f64;
            observer.progress(Stage::Seeding, by_error.max(by_count).min(1.0));
            if seeds.relative_error <= settings.relative_error || by_count >= 1.0 || observer.should_stop() {
                return seeds;
            }
        }
    }

    /// Number of samples.
    pub fn samples(&self) -> u64 {
        self.weights.len() as u64
    }

    /// The samples that `count` chains start from, by index: in proportion to their weight, by systematic resampling.
    pub(crate) fn chosen(&self, count: usize) -> Vec<usize> {
        let total: f64 = self.weights.iter().sum();
        if total <= 0.0 {
            return Vec::new();
        }
        let offset = stream(self.seed, Purpose::Starts, u64::MAX).uniform();
        let mut index = 0;
        let mut end = self.weights[0];
        let choose = |i: usize| {
            let position = (i as f64 + offset) / count as f64 * total;
            while end <= position && index + 1 < self.weights.len() {
                index += 1;
                end += self.weights[index];
            }
            // Rounding of the running sum may end on a sample of weight 0.
            while self.weights[index] <= 0.0 && index > 0 {
                index -= 1;
            }
            index
        };
        (0..count).map(choose).collect()
    }

    /// The first paths of `count` chains: samples in proportion to their weight, by systematic resampling.
    pub fn starts<R: Repertoire>(&self, scene: &Scene<R>, count: usize) -> Vec<Path<R>> {
        let mut sampler = BidirectionalSampler::new(self.lengths, self.roulette);
        let mut starts = Vec::with_capacity(count);
        for (i, index) in self.chosen(count).into_iter().enumerate() {
            let mut choice = stream(self.seed, Purpose::Starts, i as u64).uniform() * self.weights[index];
            let mut path = Path::with_capacity(self.lengths.max_edges);
            let mut chosen = false;
            sampler.sample(scene, &mut stream(self.seed, Purpose::Seeding, index as u64), |sampler, connection| {
                let weight = luminance(connection.contribution());
                if weight > 0.0 && (choice >= 0.0 || !chosen) {
                    choice -= weight;
                    sampler.assemble(scene, connection.s, connection.t, &mut path);
                    chosen = true;
                }
            });
            starts.push(path);
        }
        starts
    }
}
