//! Estimators by independent samples, spread evenly over the image and over threads.

use std::time::Instant;

use ergodic_metropolis::RandomSource;
use ergodic_pathspace::{End, PathClass, Scene};
use ergodic_scattering::{Filter, Repertoire, Rgb};
use glam::DVec2;
use rand_pcg::Pcg64Dxsm;
use rayon::prelude::*;

use crate::counts::{Counts, counted};
use crate::observer::{Observer, Stage};
use crate::streams::{Purpose, stream};
use crate::{BATCHES, Budget, Film, SplatBuffer};

/// Draws one sample of the picture. The first two numbers drawn choose the image point.
///
/// Samples that splat up to `max_edges + 1` times are foreseen in the memory that a render takes; more need more.
pub trait Estimator: Clone + Send {
    /// What the scenes have that it is compiled for.
    type Repertoire: Repertoire;

    /// Takes one sample; every call of `splat` adds light to the estimate of the mean over the image.
    fn sample(&mut self, scene: &Scene<Self::Repertoire>, rng: &mut impl RandomSource, splat: impl FnMut(DVec2, Rgb));

    /// The class of the last sample, if it was one path.
    fn class(&self) -> PathClass {
        PathClass::MANY
    }
}

/// Gives two chosen numbers first to the walk from the eye, which begins with the image point, and else those of a stream.
struct ImagePointFirst<'a> {
    chosen: [f64; 2],
    given: usize,
    /// The walk that numbers are for. What a sample asks for before it, as a wavelength, is not the image point.
    walk: usize,
    then: &'a mut Pcg64Dxsm,
}

impl RandomSource for ImagePointFirst<'_> {
    #[inline]
    fn uniform(&mut self) -> f64 {
        if self.walk == End::Eye as usize
            && let Some(&u) = self.chosen.get(self.given)
        {
            self.given += 1;
            u
        } else {
            self.then.uniform()
        }
    }

    #[inline]
    fn enter(&mut self, walk: usize, _index: usize) {
        self.walk = walk;
    }
}

/// Some rows of the image, always sampled by the same stream.
struct Batch<E> {
    first_row: u32,
    estimator: E,
    rng: Pcg64Dxsm,
    /// The pixel to sample next in this pass; below the image when the pass is done.
    next: (u32, u32),
    splats: SplatBuffer,
    counts: Counts,
}

/// What sampling came to.
#[derive(Clone, Debug)]
pub struct Sampled {
    /// All splats.
    pub film: Film,
    /// Samples taken in each pixel of the domain.
    pub passes: u64,
    /// Number of samples.
    pub samples: u64,
    /// What was traced and left out.
    pub counts: Counts,
}

impl Sampled {
    /// The picture: splats estimate the mean over the image, pixels hold density.
    pub fn picture<R: Repertoire>(&self, scene: &Scene<R>) -> crate::Picture {
        self.film.develop(scene.camera().image_area_pixels() / (self.samples.max(1)) as f64)
    }
}

/// Takes one stratified sample in each pixel in every pass until the budget ends; at least one pass. A budget of time ends with the
/// pass whose end is nearest.
pub fn sample_image<E: Estimator>(
    scene: &Scene<E::Repertoire>,
    estimator: &E,
    (width, height): (u32, u32),
    filter: Filter,
    budget: Budget,
    keys: (u64, Purpose),
    watch: (Stage, &dyn Observer),
) -> Sampled {
    let start = Instant::now();
    let done = |passes| match budget {
        Budget::SamplesPerPixel(samples) => passes as f64 / samples.ceil(),
        Budget::Seconds(seconds) => with_half_a_pass(start.elapsed().as_secs_f64(), passes) / seconds,
    };
    sample_until(scene, estimator, (width, height), filter, done, keys, watch)
}

/// The time after half a pass more than so many that have taken `elapsed`: when it is over, no other pass would end nearer to it.
fn with_half_a_pass(elapsed: f64, passes: u64) -> f64 {
    elapsed * (1.0 + 0.5 / passes as f64)
}

/// The same until `done` passes are enough: until it says 1 or more.
pub(crate) fn sample_until<E: Estimator>(
    scene: &Scene<E::Repertoire>,
    estimator: &E,
    (width, height): (u32, u32),
    filter: Filter,
    done: impl Fn(u64) -> f64,
    (seed, purpose): (u64, Purpose),
    (stage, observer): (Stage, &dyn Observer),
) -> Sampled {
    // Row i goes to batch i modulo their number.
    let count = BATCHES.min(height as usize);
    let mut film = Film::new(width, height, filter);
    let mut work: Vec<Batch<E>> = (0..count as u32)
        .map(|index| Batch {
            first_row: index,
            estimator: estimator.clone(),
            rng: stream(seed, purpose, u64::from(index)),
            next: (0, index),
            splats: SplatBuffer::new(),
            counts: Counts::default(),
        })
        .collect();
    let merge = |film: &mut Film, work: &mut [Batch<E>]| {
        film.merge(&mut work.iter_mut().map(|batch| &mut batch.splats).collect::<Vec<_>>());
    };
    let mut passes = 0;
    loop {
        // Every batch stops where its buffer is full, which depends on nothing but its own samples.
        while !all(&mut work, |batch| {
            let (done, counts) = counted(|| batch.advance(scene, (width, height), count));
            batch.counts += counts;
            done
        }) {
            merge(&mut film, &mut work);
        }
        work.iter_mut().for_each(|batch| batch.next = (0, batch.first_row));
        passes += 1;
        let done = done(passes);
        observer.progress(stage, done.min(1.0));
        if done >= 1.0 || observer.should_stop() {
            break;
        }
    }
    merge(&mut film, &mut work);
    let mut counts = Counts::default();
    work.iter().for_each(|batch| counts += batch.counts);
    let samples = passes * u64::from(width) * u64::from(height);
    Sampled { film, passes, samples, counts }
}

/// Works on all parts in parallel, none left out; whether all say that they are done.
pub(crate) fn all<T: Send>(work: &mut [T], done: impl Fn(&mut T) -> bool + Sync + Send) -> bool {
    work.par_iter_mut().map(done).reduce(|| true, |a, b| a && b)
}

impl<E: Estimator> Batch<E> {
    /// Samples until the pass is done or the buffer is full; whether the pass is done.
    fn advance(&mut self, scene: &Scene<E::Repertoire>, (width, height): (u32, u32), step: usize) -> bool {
        while self.next.1 < height {
            if self.splats.room() == 0 {
                return false;
            }
            let (x, y) = self.next;
            let mut cell = |i: u32, n: u32| (f64::from(i) + self.rng.uniform()) / f64::from(n);
            let chosen = [cell(x, width), cell(y, height)];
            let mut rng = ImagePointFirst { chosen, given: 0, walk: End::Eye as usize, then: &mut self.rng };
            let splats = &mut self.splats;
            self.estimator.sample(scene, &mut rng, |raster, color| splats.splat(raster, color));
            self.next = if x + 1 < width { (x + 1, y) } else { (0, y + step as u32) };
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_of_time_ends_with_the_pass_whose_end_is_nearest() {
        // Passes of a second.
        let passes = |budget: f64| (1..).find(|passes| with_half_a_pass(*passes as f64, *passes) >= budget).unwrap();
        for (budget, expected) in [(0.1, 1), (1.4, 1), (1.6, 2), (7.4, 7), (7.6, 8)] {
            assert_eq!(passes(budget), expected, "{budget}");
        }
    }
}
