//! What a thread's time goes to, for profiles: exclusive time by phase, read from the processor's time-stamp counter.
//!
//! Code says where a phase begins with one line, `let _phase = phase::enter(Phase::Density);`, and the phase ends with the scope.
//! Time in a phase entered within another counts for the inner one only. Without the feature `phases`, which only the profile
//! program switches on, all this is empty and costs nothing.

/// What time is spent on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// All that no other phase names: copies of paths, edges, choices, statistics.
    Bookkeeping,
    /// Search of the trees.
    Traversal,
    /// Tests of single triangles.
    Intersection,
    /// Vertices from hits, sampling and evaluation of BSDFs, the measurement contribution.
    Shading,
    /// Transition densities of mutations.
    Density,
    /// Splats.
    Film,
    /// Random numbers of chains.
    Random,
}

impl Phase {
    /// All phases, in the order of [`Phase`] itself.
    pub const ALL: [Self; 7] = [
        Self::Bookkeeping,
        Self::Traversal,
        Self::Intersection,
        Self::Shading,
        Self::Density,
        Self::Film,
        Self::Random,
    ];

    /// A name for tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bookkeeping => "bookkeeping",
            Self::Traversal => "traversal",
            Self::Intersection => "intersection",
            Self::Shading => "shading",
            Self::Density => "densities",
            Self::Film => "film",
            Self::Random => "random numbers",
        }
    }
}

#[cfg(feature = "phases")]
pub use clock::{Entered, Tally, enter, measure};

/// A phase under way; it ends when this is dropped.
#[cfg(not(feature = "phases"))]
#[derive(Debug)]
pub struct Entered;

/// Begins a phase, which lasts until the value returned is dropped.
#[cfg(not(feature = "phases"))]
#[inline(always)]
pub fn enter(_phase: Phase) -> Entered {
    Entered
}

/// The clock itself.
#[cfg(feature = "phases")]
mod clock {
    use std::cell::Cell;
    use std::sync::LazyLock;

    use quanta::Clock;

    use super::Phase;

    const COUNT: usize = Phase::ALL.len();

    /// Phases entered in a row to find what entering costs.
    const CALIBRATION: u64 = 2_000_000;

    static CLOCK: LazyLock<Clock> = LazyLock::new(Clock::new);

    /// The clock of a thread. Times are raw ticks.
    struct State {
        active: Cell<bool>,
        current: Cell<usize>,
        since: Cell<u64>,
        ticks: [Cell<u64>; COUNT],
        /// How often the second phase was entered from the first.
        entries: [[Cell<u64>; COUNT]; COUNT],
    }

    thread_local! {
        static STATE: State = const {
            State {
                active: Cell::new(false),
                current: Cell::new(0),
                since: Cell::new(0),
                ticks: [const { Cell::new(0) }; COUNT],
                entries: [const { [const { Cell::new(0) }; COUNT] }; COUNT],
            }
        };
    }

    impl State {
        #[inline(always)]
        fn switch(&self, phase: usize) -> usize {
            let now = CLOCK.raw();
            let before = self.current.replace(phase);
            let ticks = &self.ticks[before];
            ticks.set(ticks.get() + now.saturating_sub(self.since.replace(now)));
            before
        }
    }

    /// A phase under way; it ends when this is dropped.
    #[derive(Debug)]
    pub struct Entered {
        /// The phase around it; `None` if nothing is measured.
        around: Option<usize>,
    }

    /// Begins a phase, which lasts until the value returned is dropped.
    #[inline(always)]
    pub fn enter(phase: Phase) -> Entered {
        STATE.with(|state| {
            if !state.active.get() {
                return Entered { around: None };
            }
            let around = state.switch(phase as usize);
            let entries = &state.entries[around][phase as usize];
            entries.set(entries.get() + 1);
            Entered { around: Some(around) }
        })
    }

    impl Drop for Entered {
        #[inline(always)]
        fn drop(&mut self) {
            if let Some(around) = self.around {
                STATE.with(|state| state.switch(around));
            }
        }
    }

    /// What was measured. All times are in nanoseconds and in the order of [`Phase::ALL`].
    #[derive(Clone, Copy, Debug, Default)]
    pub struct Tally {
        /// Exclusive time by phase, with what the clock itself takes.
        pub raw: [f64; COUNT],
        /// What the clock itself took in each phase, as found by calibration: each entry costs something in the phase entered
        /// and something in the one around it.
        pub overhead: [f64; COUNT],
        /// How often each phase was entered.
        pub entries: [u64; COUNT],
    }

    /// Does `work` and says where this thread's time went. What is in no phase is [`Phase::Bookkeeping`].
    pub fn measure(work: impl FnOnce()) -> Tally {
        let nanoseconds = |ticks: u64| CLOCK.delta_as_nanos(0, ticks) as f64;
        let mut tally = Tally::default();
        let entries = STATE.with(|state| {
            let empty = run(state, || {
                for _ in 0..CALIBRATION {
                    drop(std::hint::black_box(enter(Phase::Film)));
                }
            });
            let per_entry = |phase: Phase| nanoseconds(empty.0[phase as usize]) / CALIBRATION as f64;
            let (inside, around) = (per_entry(Phase::Film), per_entry(Phase::Bookkeeping));
            let (ticks, entries) = run(state, work);
            tally.raw = ticks.map(nanoseconds);
            for (from, row) in entries.iter().enumerate() {
                for (to, &count) in row.iter().enumerate() {
                    tally.overhead[to] += inside * count as f64;
                    tally.overhead[from] += around * count as f64;
                }
            }
            entries
        });
        tally.entries = std::array::from_fn(|to| entries.iter().map(|row| row[to]).sum());
        tally
    }

    /// Ticks by phase and entries by phase around and phase entered.
    fn run(state: &State, work: impl FnOnce()) -> ([u64; COUNT], [[u64; COUNT]; COUNT]) {
        state.ticks.iter().chain(state.entries.iter().flatten()).for_each(|number| number.set(0));
        state.current.set(Phase::Bookkeeping as usize);
        state.since.set(CLOCK.raw());
        state.active.set(true);
        work();
        state.switch(Phase::Bookkeeping as usize);
        state.active.set(false);
        let read = |numbers: &[Cell<u64>; COUNT]| std::array::from_fn(|i| numbers[i].get());
        (read(&state.ticks), std::array::from_fn(|i| read(&state.entries[i])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_are_numbered_in_the_order_of_their_list() {
        for (i, phase) in Phase::ALL.into_iter().enumerate() {
            assert_eq!(phase as usize, i);
        }
    }
}
