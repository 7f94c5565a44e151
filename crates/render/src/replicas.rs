//! Independent replicas of a render: the same settings, a seed of its own for each, and so a b of its own.

use std::sync::atomic::{AtomicUsize, Ordering};

use ergodic_pathspace::Scene;

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
    scene: &Scene,
    settings: &Settings,
    count: usize,
    observer: &dyn Observer,
) -> Result<Vec<Rendering>, RenderError> {
    settings.validate().map_err(RenderError::Settings)?;
    let threads = settings.worker_threads();
    let next = AtomicUsize::new(0);
    let finished = AtomicUsize::new(0);
    let one = |index: usize| -> Result<Option<Rendering>, RenderError> {
        let settings = Settings { seed: settings.seed.wrapping_add(index as u64), threads: 1, ..settings.clone() };
        let rendering = render(scene, &settings, &OneOfMany(observer))?;
        let done = finished.fetch_add(1, Ordering::Relaxed) + 1;
        observer.progress(Stage::Rendering, done as f64 / count as f64);
        Ok((!observer.should_stop()).then_some(rendering))
    };
    // Threads of their own, not a pool: a pool's thread that waits for another pool begins further replicas meanwhile.
    let work = || {
        let mut done = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= count || observer.should_stop() {
                return done;
            }
            done.push((index, one(index)));
        }
    };
    let mut all: Vec<(usize, Result<Option<Rendering>, RenderError>)> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads.min(count)).map(|_| scope.spawn(work)).collect();
        workers.into_iter().flat_map(|w| w.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))).collect()
    });
    all.sort_by_key(|(index, _)| *index);
    let all: Result<Vec<Option<Rendering>>, RenderError> = all.into_iter().map(|(_, rendering)| rendering).collect();
    Ok(all?.into_iter().flatten().collect())
}
