//! What a piece of work traced and left out, read from the plain counters of its thread.

use std::ops::AddAssign;

use ergodic_pathspace::rays_traced;
use ergodic_pathspace::stability::{Stability, left_out};

/// Counts of a piece of work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rays traced, shadow rays included.
    pub rays: u64,
    /// Contributions that were not finite, or negative, and were left out.
    pub stability: Stability,
}

impl AddAssign for Counts {
    fn add_assign(&mut self, more: Self) {
        self.rays += more.rays;
        self.stability += more.stability;
    }
}

/// Does `work`, all of it on this thread; its result, and what it traced and left out.
pub(crate) fn counted<T>(work: impl FnOnce() -> T) -> (T, Counts) {
    let (rays, stability) = (rays_traced(), left_out());
    let result = work();
    (result, Counts { rays: rays_traced() - rays, stability: left_out() - stability })
}
