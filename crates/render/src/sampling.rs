//! Estimators by independent samples, spread evenly over the image and over threads.

use std::time::Instant;

use ergodic_metropolis::RandomSource;
use ergodic_pathspace::Scene;
use ergodic_scattering::{Filter, Rgb};
use glam::DVec2;
use rand_pcg::Pcg64Dxsm;
use rayon::prelude::*;

use crate::counts::{Counts, counted};
use crate::observer::{Observer, Stage};
use crate::streams::{Purpose, stream};
use crate::{Budget, Film, batches};

/// Draws one sample of the picture. The first two numbers drawn choose the image point.
pub trait Estimator: Clone + Send {
    /// Takes one sample; every call of `splat` adds light to the estimate of the mean over the image.
    fn sample(&mut self, scene: &Scene, rng: &mut impl RandomSource, splat: impl FnMut(DVec2, Rgb));
}

/// Gives two chosen numbers first, then those of a stream.
struct ImagePointFirst<'a> {
    chosen: [f64; 2],
    given: usize,
    then: &'a mut Pcg64Dxsm,
}

impl RandomSource for ImagePointFirst<'_> {
    #[inline]
    fn uniform(&mut self) -> f64 {
        if let Some(&u) = self.chosen.get(self.given) {
            self.given += 1;
            u
        } else {
            self.then.uniform()
        }
    }
}

/// Some rows of the image, always sampled by the same stream.
struct Batch<E> {
    first_row: u32,
    estimator: E,
    rng: Pcg64Dxsm,
    film: Film,
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
    pub fn picture(&self, scene: &Scene) -> crate::Picture {
        self.film.develop(scene.camera().image_area_pixels() / (self.samples.max(1)) as f64)
    }
}

/// Takes one stratified sample in each pixel in every pass until the budget ends; at least one pass unless stopped.
pub fn sample_image<E: Estimator>(
    scene: &Scene,
    estimator: &E,
    (width, height): (u32, u32),
    filter: Filter,
    budget: Budget,
    (seed, purpose): (u64, Purpose),
    (stage, observer): (Stage, &dyn Observer),
) -> Sampled {
    let start = Instant::now();
    let count = batches(width, height).min(height as usize);
    let mut work: Vec<Batch<E>> = (0..count)
        .map(|index| Batch {
            first_row: index as u32,
            estimator: estimator.clone(),
            rng: stream(seed, purpose, index as u64),
            film: Film::new(width, height, filter),
            counts: Counts::default(),
        })
        .collect();
    let mut passes = 0;
    loop {
        work.par_iter_mut().for_each(|batch| {
            let ((), counts) = counted(|| batch.pass(scene, (width, height), count));
            batch.counts += counts;
        });
        passes += 1;
        let done = match budget {
            Budget::SamplesPerPixel(samples) => passes as f64 / samples.ceil(),
            Budget::Seconds(seconds) => start.elapsed().as_secs_f64() / seconds,
        };
        observer.progress(stage, done.min(1.0));
        if done >= 1.0 || observer.should_stop() {
            break;
        }
    }
    let mut film = Film::new(width, height, filter);
    let mut counts = Counts::default();
    for batch in &work {
        film.add(&batch.film);
        counts += batch.counts;
    }
    let samples = passes * u64::from(width) * u64::from(height);
    Sampled { film, passes, samples, counts }
}

impl<E: Estimator> Batch<E> {
    fn pass(&mut self, scene: &Scene, (width, height): (u32, u32), step: usize) {
        for y in (self.first_row..height).step_by(step) {
            for x in 0..width {
                let mut cell = |i: u32, n: u32| (f64::from(i) + self.rng.uniform()) / f64::from(n);
                let chosen = [cell(x, width), cell(y, height)];
                let mut rng = ImagePointFirst { chosen, given: 0, then: &mut self.rng };
                let film = &mut self.film;
                self.estimator.sample(scene, &mut rng, |raster, color| film.splat(raster, color));
            }
        }
    }
}
