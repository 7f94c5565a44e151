//! What replicas are compared with: a picture given, or one made for the purpose, and its own error.

use std::path::Path;

use ergodic_assess::{Image, RELATIVE_EPSILON, Reference, read_image};
use ergodic_pathspace::Scene;
use ergodic_render::{Budget, Method, Settings, render_replicas};

use super::with_ending;
use crate::error::CliError;
use crate::options::AccuracyOptions;
use crate::output;
use crate::progress::Progress;

/// Replicas of a reference that is made here, and the share of the time limit that it takes.
const REPLICAS: usize = 16;
const SHARE: f64 = 0.25;

/// What its own variance adds to the errors measured with a reference.
#[derive(Clone, Copy, Debug, Default)]
pub struct Noise {
    pub rel_mse: f64,
    pub trimmed_rel_mse: f64,
    pub mse: f64,
}

/// A reference.
#[derive(Clone, Debug)]
pub struct Known {
    pub image: Image,
    /// Where it comes from, in words.
    pub origin: String,
    /// None if it says nothing of its error.
    pub relative_error: Option<f64>,
    pub noise: Noise,
}

impl Known {
    /// Reads the reference that the options name, or makes one, or takes the one that an earlier run made.
    pub fn find(
        options: &AccuracyOptions,
        scene: &Scene,
        settings: &Settings,
        stem: &Path,
        limit: f64,
        progress: &Progress,
    ) -> Result<Self, CliError> {
        let (width, height) = settings.size;
        let known = match &options.reference {
            Some(path) => Self::read(path)?,
            None => Self::made(scene, settings, &with_ending(stem, ".reference.exr"), limit, progress)?,
        };
        if (known.image.width, known.image.height) != settings.size {
            return Err(CliError::Said(format!(
                "{} has {} x {} pixels, but the picture {width} x {height}; give --size {}x{}",
                known.origin, known.image.width, known.image.height, known.image.width, known.image.height
            )));
        }
        Ok(known)
    }

    fn read(path: &Path) -> Result<Self, CliError> {
        let origin = path.display().to_string();
        match Reference::read(path) {
            Ok(reference) => Ok(Self::with_variance(&reference, origin)),
            // Any other image will do, but it says nothing of its error.
            Err(_) => Ok(Self { image: read_image(path)?, origin, relative_error: None, noise: Noise::default() }),
        }
    }

    fn made(
        scene: &Scene,
        settings: &Settings,
        path: &Path,
        limit: f64,
        progress: &Progress,
    ) -> Result<Self, CliError> {
        if path.exists() {
            return Self::read(path);
        }
        let threads = settings.worker_threads();
        let seconds = limit * SHARE * threads.min(REPLICAS) as f64 / REPLICAS as f64;
        let settings = Settings {
            method: Method::Bidirectional,
            // Far from the seeds of the replicas.
            seed: settings.seed ^ 1 << 63,
            budget: Budget::Seconds(seconds),
            ..settings.clone()
        };
        let renderings = render_replicas(scene, &settings, REPLICAS, progress)?;
        let images: Vec<Image> = renderings.iter().map(|r| output::image(&r.picture)).collect();
        let Some(reference) = Reference::from_replicas(&images).filter(|_| !progress.interrupted()) else {
            progress.finish();
            return Err(CliError::Said("stopped while the reference was made; nothing was measured yet".into()));
        };
        reference.write(path, &[])?;
        Self::read(path)
    }

    fn with_variance(reference: &Reference, origin: String) -> Self {
        let mut relative = Vec::with_capacity(reference.mean.pixels.len());
        let mut mse = 0.0;
        for (mean, variance) in reference.mean.pixels.iter().zip(&reference.variance.pixels) {
            mse += variance.iter().sum::<f64>();
            let of_channel = |(m, v): (&f64, &f64)| v / (m * m + RELATIVE_EPSILON);
            relative.push(mean.iter().zip(variance).map(of_channel).sum::<f64>() / 3.0);
        }
        let n = relative.len() as f64;
        let rel_mse = relative.iter().sum::<f64>() / n;
        let noise = Noise { rel_mse, trimmed_rel_mse: rel_mse, mse: mse / (3.0 * n) };
        Self { image: reference.mean.clone(), origin, relative_error: Some(reference.total().1), noise }
    }

    /// How good it is, in a line.
    pub fn line(&self) -> String {
        match self.relative_error {
            Some(error) => format!(
                "reference {}: relative error of the mean {:.2e}, relMSE of its own {:.2e}, which is taken off",
                self.origin, error, self.noise.rel_mse
            ),
            None => format!(
                "reference {}: it does not say how large its own error is, so nothing is taken off",
                self.origin
            ),
        }
    }

    /// Tells one reference from another.
    pub fn mark(&self) -> String {
        let sum: f64 = self.image.pixels.iter().flatten().enumerate().map(|(i, v)| v * (1 + i % 97) as f64).sum();
        format!("{} {}x{} {:016x}", self.origin, self.image.width, self.image.height, sum.to_bits())
    }
}
