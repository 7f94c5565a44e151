//! Independent replicas of a render: the same settings, a seed of its own for each, and so a b of its own.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use ergodic_pathspace::Scene;
use rayon::prelude::*;

use crate::observer::{Observer, Stage};
use crate::{RenderError, Rendering, Settings, render};

/// Passes on the wish to stop; the progress of a single replica is not shown.
struct OneOfMany<'a>(&'a dyn Observer);

impl Observer for OneOfMany<'_> {
    fn progress(&self, _stage: Stage, _done: f64) {}

    fn should_stop(&self) -> bool {
        self.0.should_stop()
    }
}

/// Renders `count` replicas with the seeds `settings.seed`, `settings.seed + 1`, … . Each takes one thread, and
/// `settings.threads` run at a time, so that small pictures keep all cores busy. When stopped, only whole replicas come back.
///
/// # Errors
///
/// As [`render`].
pub fn render_replicas(
    scene: &Arc<Scene>,
    settings: &Settings,
    count: usize,
    observer: &dyn Observer,
) -> Result<Vec<Rendering>, RenderError> {
    settings.validate().map_err(RenderError::Settings)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(settings.threads)
        .build()
        .map_err(|e| RenderError::Threads { threads: settings.threads, reason: e.to_string() })?;
    let finished = AtomicUsize::new(0);
    let one = |index: usize| -> Result<Option<Rendering>, RenderError> {
        if observer.should_stop() {
            return Ok(None);
        }
        let settings = Settings { seed: settings.seed.wrapping_add(index as u64), threads: 1, ..settings.clone() };
        let rendering = render(scene, &settings, &OneOfMany(observer))?;
        let done = finished.fetch_add(1, Ordering::Relaxed) + 1;
        observer.progress(Stage::Rendering, done as f64 / count as f64);
        Ok((!observer.should_stop()).then_some(rendering))
    };
    let all: Result<Vec<Option<Rendering>>, RenderError> =
        pool.install(|| (0..count).into_par_iter().with_max_len(1).map(one).collect());
    Ok(all?.into_iter().flatten().collect())
}
