//! How a render tells of its progress and learns that it should stop.

use std::time::Instant;

/// What a render is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Estimating b and collecting starts for the chains.
    Seeding,
    /// Estimating the light that chains leave out.
    Direct,
    /// Taking samples or mutations.
    Rendering,
}

/// Watches a render.
pub trait Observer: Sync {
    /// `done`, in `[0, 1]`, of the stage.
    fn progress(&self, stage: Stage, done: f64);

    /// Whether to stop as soon as possible and keep what there is.
    fn should_stop(&self) -> bool;
}

/// Passes everything on, and also wants to stop at a time.
pub(crate) struct Until<'a> {
    pub(crate) observer: &'a dyn Observer,
    /// `None` for never.
    pub(crate) deadline: Option<Instant>,
}

impl Observer for Until<'_> {
    fn progress(&self, stage: Stage, done: f64) {
        self.observer.progress(stage, done);
    }

    fn should_stop(&self) -> bool {
        self.observer.should_stop() || self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }
}

/// Watches nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unobserved;

impl Observer for Unobserved {
    fn progress(&self, _stage: Stage, _done: f64) {}

    fn should_stop(&self) -> bool {
        false
    }
}
