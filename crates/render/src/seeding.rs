//! Start-up of the chains (Veach 11.3.1): independent bidirectional samples estimate b, and some of them, chosen by their
//! weight, become the chains' first paths. Both from the same samples, so that the whole estimator is unbiased.
//!
//! A sample is a pair of walks with many connections. One of them, chosen by its luminance, stands for it while the order of the
//! samples is found (`starts`), and is the path that a chain begins with.

use std::ops::RangeInclusive;

use ergodic_metropolis::RandomSource;
use ergodic_pathspace::stability::{Place, is_usable_number};
use ergodic_pathspace::{BidirectionalSampler, BrightnessMap, Connection, Lengths, Path, PathClass, Roulette, Scene};
use ergodic_scattering::{Repertoire, luminance};
use glam::DVec2;
use rand_pcg::Pcg64Dxsm;
use rayon::prelude::*;

use crate::Seeding;
use crate::chains::LeastWork;
use crate::counts::{Counts, counted};
use crate::observer::{Observer, Stage};
use crate::settings::MOST_SEEDS;
use crate::starts::{self, GOLDEN, Seed, Strategy};
use crate::streams::{Purpose, stream};

/// Samples between two looks at the clock and at the error of b, as chunks times samples in a chunk: an eighth of those so far, so that
/// no budget of time is missed by much more, but neither so few that the looks cost something nor so many that they are rare.
pub(crate) const CHUNKS: u64 = 64;
const CHUNK: RangeInclusive<u64> = 4..=256;
const SHARE_OF_LOOK: u64 = 8;

/// Before there are so many samples, their error tells little.
const FEW: u64 = 16384;

/// So many samples are drawn even if the time for them is over: of fewer, single bright ones start too many of the chains.
const LEAST: u64 = 4096;

/// How long the chunks are when there are so many samples.
pub(crate) fn chunk_after(samples: u64) -> u64 {
    (samples / (CHUNKS * SHARE_OF_LOOK)).clamp(*CHUNK.start(), *CHUNK.end())
}

/// Seeds that are kept at most. When there would be more, they are thinned to half as many, which costs the starts little: they are
/// far fewer.
pub(crate) const KEPT: usize = 1 << 21;

/// When a seeding ends.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Relative standard error of b that is small enough.
    pub relative_error: f64,
    /// After so many samples the error is as good as it gets.
    pub max_samples: u64,
    /// What is done in any case.
    pub(crate) least: LeastWork,
}

impl From<&Seeding> for Effort {
    /// As soon as b is known well enough.
    fn from(settings: &Seeding) -> Self {
        let Seeding { relative_error, max_samples } = *settings;
        Self { relative_error, max_samples, least: LeastWork { samples: 0.0, not_before: None } }
    }
}

impl Effort {
    /// How much of the effort has been made, in [0, 1].
    fn done(&self, samples: u64, relative_error: f64) -> f64 {
        let of_error = (self.relative_error / relative_error).powi(2).min(samples as f64 / FEW as f64);
        let of_error = of_error.max(samples as f64 / self.max_samples as f64);
        let (samples, least) = (samples as f64, self.least.samples);
        let of_samples = if samples < least { samples / least } else { 1.0 };
        self.least.limit(of_error.min(of_samples))
    }
}

/// What is seen of one sample.
#[derive(Clone, Copy, Debug)]
pub struct Weighed {
    /// Its luminance.
    pub luminance: f64,
    /// What it counts as a start: the chains' target, summed over its paths.
    pub weight: f64,
    /// The class of its path, or of the one that stands for it.
    pub class: PathClass,
    /// Where that path meets the image.
    pub raster: DVec2,
    /// How that path was made, if the sample is walks with many connections.
    pub strategy: Strategy,
}

/// The samples that chains start from.
#[derive(Clone, Debug)]
pub struct Seeds {
    /// Those that carry light, in the order of [`starts::sort`].
    seeds: Vec<Seed>,
    /// Where the part of each ends in the running sum of weights.
    ends: Vec<f64>,
    samples: u64,
    /// Estimate of b, the mean luminance over the image of all paths of the chains' lengths.
    pub b: f64,
    /// Estimate of the integral of the chains' target: b, or with a map of brightness the mean of luminance over brightness.
    pub target: f64,
    /// Standard error of the target's integral over itself.
    pub relative_error: f64,
    /// What was traced and left out; a sample that was left out counts as 0.
    pub counts: Counts,
    seed: u64,
    lengths: Lengths,
    roulette: Roulette,
}

/// Chooses one of several things with probability in proportion to their weights, as they come.
pub(crate) struct Draw {
    /// Uniform in [0, 1) whatever was chosen so far.
    u: f64,
    /// Of the weights so far.
    pub(crate) sum: f64,
}

impl Draw {
    /// From nothing yet, by a number in [0, 1).
    pub(crate) fn new(u: f64) -> Self {
        Self { u, sum: 0.0 }
    }

    /// One more thing of a weight; whether it is the chosen one so far.
    pub(crate) fn offer(&mut self, weight: f64) -> bool {
        self.sum += weight;
        let share = if weight > 0.0 { weight / self.sum } else { 0.0 };
        let takes = self.u < share;
        // What is left of the number is as good as a new one.
        let left = if takes { self.u / share } else { (self.u - share) / (1.0 - share) };
        self.u = left.min(1.0 - f64::EPSILON);
        takes
    }
}

/// Chooses one of the connections of a sample, with probability in proportion to the chains' target.
struct Choice<'a> {
    brightness: Option<&'a BrightnessMap>,
    draw: Draw,
    luminance: f64,
    chosen: Option<Connection>,
}

impl<'a> Choice<'a> {
    /// For the sample of this number.
    fn new(brightness: Option<&'a BrightnessMap>, seed: u64, index: u64) -> Self {
        let draw = Draw::new(stream(seed, Purpose::Starts, index).uniform());
        Self { brightness, draw, luminance: 0.0, chosen: None }
    }

    /// One more connection; whether it is the chosen one so far.
    fn offer(&mut self, connection: &Connection) -> bool {
        let luminance = luminance(connection.contribution());
        self.luminance += luminance;
        let takes = self.draw.offer(BrightnessMap::relative(self.brightness, luminance, connection.raster));
        if takes {
            self.chosen = Some(*connection);
        }
        takes
    }
}

impl Seeds {
    /// Samples until the effort is made: by default, until the relative standard error of b is small enough, or the samples allowed
    /// are used up.
    pub fn draw<R: Repertoire>(
        scene: &Scene<R>,
        lengths: Lengths,
        roulette: Roulette,
        effort: impl Into<Effort>,
        seed: u64,
        observer: &dyn Observer,
    ) -> Self {
        Self::draw_for(scene, None, (lengths, roulette), effort, seed, observer)
    }

    /// The same for chains whose target is luminance over brightness.
    pub fn draw_for<R: Repertoire>(
        scene: &Scene<R>,
        brightness: Option<&BrightnessMap>,
        (lengths, roulette): (Lengths, Roulette),
        effort: impl Into<Effort>,
        seed: u64,
        observer: &dyn Observer,
    ) -> Self {
        let sampler = || BidirectionalSampler::new(lengths, roulette);
        let weigh = |sampler: &mut BidirectionalSampler<R>, index: u64, rng: &mut Pcg64Dxsm| {
            let mut choice = Choice::new(brightness, seed, index);
            let mut class = PathClass::MANY;
            sampler.sample(scene, rng, |sampler, connection| {
                if choice.offer(&connection) {
                    class = sampler.class(connection.s, connection.t);
                }
            });
            let (raster, strategy) = choice.chosen.map_or_else(Default::default, |connection| {
                let Connection { s, t, raster, .. } = connection;
                (raster, Strategy { s: s as u16, t: t as u16 })
            });
            Weighed { luminance: choice.luminance, weight: choice.draw.sum, class, raster, strategy }
        };
        let size = scene.camera().size();
        Self::draw_by(sampler, weigh, size, (lengths, roulette), effort, seed, observer)
    }

    /// The same with samples of any kind: `weigh` takes the sample of a number with a sampler that `sampler` makes; `size` is that of the
    /// image.
    pub(crate) fn draw_by<S>(
        sampler: impl Fn() -> S + Sync,
        weigh: impl Fn(&mut S, u64, &mut Pcg64Dxsm) -> Weighed + Sync,
        size: DVec2,
        (lengths, roulette): (Lengths, Roulette),
        effort: impl Into<Effort>,
        seed: u64,
        observer: &dyn Observer,
    ) -> Self {
        let mut seeds = Self {
            seeds: Vec::new(),
            ends: Vec::new(),
            samples: 0,
            b: 0.0,
            target: 0.0,
            relative_error: 1.0,
            counts: Counts::default(),
            seed,
            lengths,
            roulette,
        };
        let effort = effort.into();
        let (mut sum, mut sum_of_squares, mut luminance) = (0.0, 0.0, 0.0);
        if lengths.min_edges > lengths.max_edges {
            // No path is asked for, so b is exactly 0.
            seeds.relative_error = 0.0;
            return seeds;
        }
        // What is no number counts as 0.
        let weigh = |sampler: &mut S, index: u64| {
            let weighed = weigh(sampler, index, &mut stream(seed, Purpose::Seeding, index));
            let carries = is_usable_number(Place::Seed, weighed.weight) && weighed.weight > 0.0;
            carries.then(|| {
                let Weighed { luminance, weight, class, raster, strategy } = weighed;
                let place = starts::place(class, raster, size);
                (Seed { weight, place, index: index as u32, strategy }, luminance)
            })
        };
        loop {
            let first = seeds.samples;
            let length = chunk_after(first);
            let chunks: Vec<(Vec<(Seed, f64)>, Counts)> = (0..CHUNKS)
                .into_par_iter()
                .map(|chunk| {
                    let mut sampler = sampler();
                    let start = first + chunk * length;
                    counted(|| (start..start + length).filter_map(|index| weigh(&mut sampler, index)).collect())
                })
                .collect();
            for (chunk, counts) in chunks {
                seeds.counts += counts;
                for (seed, of_seed) in chunk {
                    luminance += of_seed;
                    sum += seed.weight;
                    sum_of_squares += seed.weight * seed.weight;
                    seeds.seeds.push(seed);
                }
            }
            seeds.samples += CHUNKS * length;
            seeds.thin();
            let n = seeds.samples as f64;
            (seeds.b, seeds.target) = (luminance / n, sum / n);
            let variance = (sum_of_squares / n - seeds.target * seeds.target).max(0.0) / (n - 1.0);
            seeds.relative_error = if seeds.target > 0.0 { variance.sqrt() / seeds.target } else { f64::INFINITY };
            let done = effort.done(seeds.samples, seeds.relative_error);
            observer.progress(Stage::Seeding, done);
            let enough = done >= 1.0 || seeds.samples >= MOST_SEEDS;
            // Without a seed there is nothing to go on with, so that a short budget waits for one a little longer.
            let least = if sum > 0.0 { LEAST } else { FEW };
            let stops = seeds.samples >= least && observer.should_stop();
            if enough || stops {
                starts::sort(&mut seeds.seeds);
                seeds.ends = starts::ends(&seeds.seeds);
                return seeds;
            }
        }
    }

    /// Keeps the list from growing for good.
    fn thin(&mut self) {
        if self.seeds.len() as u64 + CHUNKS * CHUNK.end() > KEPT as u64 {
            starts::sort(&mut self.seeds);
            // No two lists that are thinned end with the same number of samples.
            let offset = stream(self.seed, Purpose::Thinning, self.samples).uniform();
            starts::thin(&mut self.seeds, KEPT / 2, offset);
        }
    }

    /// Number of samples.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The samples that `count` chains start from: in proportion to their weight, by systematic resampling. Every generation of
    /// chains has starts of its own.
    pub(crate) fn chosen(&self, generation: u64, count: usize) -> Vec<Seed> {
        let first = stream(self.seed, Purpose::Starts, u64::MAX).uniform();
        // Uniform for every generation, and spread evenly over the generations.
        let offset = (first + generation as f64 * GOLDEN).fract();
        let starts = starts::resample(&self.ends, count, offset);
        // Chains of neighbouring numbers do not begin in the same place, nor one chain again and again: a part of the chains is to
        // stand for all.
        let order = starts::spread(starts.len(), generation);
        order.into_iter().map(|i| self.seeds[starts[i]]).collect()
    }

    /// The path that stands for a sample. Chains begin so often that only what it was made of is made again.
    pub(crate) fn path<R: Repertoire>(&self, scene: &Scene<R>, seed: &Seed) -> Path<R> {
        let mut sampler = BidirectionalSampler::new(self.lengths, self.roulette);
        let (s, t) = (usize::from(seed.strategy.s), usize::from(seed.strategy.t));
        sampler.walk_for(scene, (s, t), &mut stream(self.seed, Purpose::Seeding, u64::from(seed.index)));
        let mut path = Path::with_capacity(self.lengths.max_edges);
        sampler.assemble(scene, s, t, &mut path);
        path
    }

    /// The first paths of `count` chains: samples in proportion to their weight, by systematic resampling.
    pub fn starts<R: Repertoire>(&self, scene: &Scene<R>, count: usize) -> Vec<Path<R>> {
        self.chosen(0, count).iter().map(|seed| self.path(scene, seed)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_are_an_eighth_of_the_samples_apart() {
        let mut samples = 0;
        for _ in 0..1000 {
            let more = CHUNKS * chunk_after(samples);
            assert!(more == 256 || more * SHARE_OF_LOOK <= samples, "{more} after {samples}");
            assert!(more == 16384 || more * SHARE_OF_LOOK + 8 * 64 > samples, "{more} after {samples}");
            samples += more;
        }
        assert!(samples > 10_000_000, "{samples}: looks stay few");
    }
}
