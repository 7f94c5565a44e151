//! Timing in turns, random inputs, and scenes.

use cpu_time::ThreadTime;
use ergodic_assess::accuracy::{Interval, resampled};
use ergodic_assess::{RELATIVE_EPSILON, Reference};
use ergodic_metropolis::RandomSource;
use ergodic_pathspace::Scene;
use ergodic_render::{Purpose, Settings, stream};
use glam::DVec3;

/// Processor time of this thread that work takes, in seconds, with what it comes to.
pub fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = ThreadTime::now();
    let done = work();
    (done, start.elapsed().as_secs_f64())
}

/// Times of two kinds of work that take turns, and turn about in who begins.
pub fn in_turns(rounds: usize, mut one: impl FnMut(), mut other: impl FnMut()) -> [Vec<f64>; 2] {
    // The first round warms the caches.
    one();
    other();
    let mut times = [Vec::new(), Vec::new()];
    for round in 0..rounds {
        if round % 2 == 0 {
            times[0].push(timed(&mut one).1);
            times[1].push(timed(&mut other).1);
        } else {
            times[1].push(timed(&mut other).1);
            times[0].push(timed(&mut one).1);
        }
    }
    times
}

/// The standard deviation of values, from their squared deviations from the mean of all.
pub fn spread(values: &[f64]) -> Option<Interval> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: Vec<f64> = values.iter().map(|value| (value - mean).powi(2)).collect();
    let variance = |indices: &[usize]| indices.iter().map(|i| squares[*i]).sum::<f64>() / (n - 1.0);
    resampled(values.len(), |indices| Some(variance(indices).sqrt()))
}

/// Inputs, the same in every run.
#[derive(Debug)]
pub struct Inputs(rand_pcg::Pcg64Dxsm);

impl Inputs {
    pub fn new(index: u64) -> Self {
        Self(stream(0x9ec1, Purpose::Pilot, index))
    }

    /// In [0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0.uniform()
    }

    /// Between two ends.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// A direction, uniform over the sphere.
    pub fn direction(&mut self) -> DVec3 {
        let (z, phi) = (self.between(-1.0, 1.0), self.between(0.0, std::f64::consts::TAU));
        let radius = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(radius * phi.cos(), radius * phi.sin(), z)
    }

    /// A point of a cube around the origin.
    pub fn point(&mut self, half: f64) -> DVec3 {
        DVec3::new(self.between(-half, half), self.between(-half, half), self.between(-half, half))
    }
}

/// A scene with its reference.
#[derive(Debug)]
pub struct Work {
    pub scene: Scene,
    pub reference: Reference,
    /// Settings of the reference's size, on one thread.
    pub settings: Settings,
}

impl Work {
    /// Loads one of our scenes that has no sky.
    pub fn new(name: &str) -> Result<Self, String> {
        let reference = Reference::read(&crate::root().join("reference").join(format!("{name}.exr")));
        let reference = reference.map_err(|e| e.to_string())?;
        let size = (reference.mean.width, reference.mean.height);
        let settings = Settings { size, threads: 1, ..Settings::default() };
        let asset =
            ergodic_assets::load(&crate::scenes_folder().join(name).join("scene.glb")).map_err(|e| e.to_string())?;
        let (camera, _) = asset.camera("", f64::from(size.0) / f64::from(size.1)).map_err(|e| e.to_string())?;
        let scene = Scene::new(asset.description, &settings.view(camera)).map_err(|e| e.to_string())?;
        Ok(Self { scene, reference, settings })
    }

    /// The relMSE that the reference's own error makes.
    pub fn noise(&self) -> f64 {
        let pixels = self.reference.mean.pixels.iter().flatten().zip(self.reference.variance.pixels.iter().flatten());
        let relative = pixels.map(|(mean, variance)| variance / (mean * mean + RELATIVE_EPSILON));
        relative.sum::<f64>() / (3 * self.reference.mean.pixels.len()) as f64
    }
}

/// Does work in a pool of one thread, so that its processor time is that of the thread.
pub fn on_one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, String> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|e| e.to_string())?;
    Ok(pool.install(work))
}
