//! Runs of rejections: how long a chain stays in one place.

use crate::Step;

/// Counts transitions and the longest time that the chain stood still.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Runs {
    steps: u64,
    accepted: u64,
    current: u64,
    longest: u64,
}

impl Runs {
    /// Before the first step.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes one step of the chain.
    #[inline]
    pub fn add<P, F>(&mut self, step: &Step<P, F>) {
        self.steps += 1;
        if matches!(step, Step::Tried { accepted: true, .. }) {
            self.accepted += 1;
            self.current = 0;
        } else {
            self.current += 1;
            self.longest = self.longest.max(self.current);
        }
    }

    /// Takes another chain's counts: the longest run is the longest of either.
    pub fn merge(&mut self, other: &Self) {
        self.steps += other.steps;
        self.accepted += other.accepted;
        self.longest = self.longest.max(other.longest);
    }

    /// Steps taken.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Steps on which the chain moved.
    pub fn accepted(&self) -> u64 {
        self.accepted
    }

    /// Rejections, of whatever kind, since the last move.
    pub fn current(&self) -> u64 {
        self.current
    }

    /// The largest number of rejections in a row.
    pub fn longest(&self) -> u64 {
        self.longest
    }
}
