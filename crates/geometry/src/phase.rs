//! What the program is at, for profiles: a mark that another thread can look at.
//!
//! Code says where a phase begins with one line, `let _phase = phase::enter(Phase::Density);`, and the phase ends with the scope.
//! A phase entered within another interrupts it. There is one mark for the whole program, so only one thread may work while
//! another looks. Without the feature `phases`, which only the profile program switches on, all this is empty and costs nothing.

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
pub use mark::{Entered, current, enter};

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

#[cfg(feature = "phases")]
mod mark {
    use std::sync::atomic::{AtomicU8, Ordering};

    use super::Phase;

    static CURRENT: AtomicU8 = AtomicU8::new(Phase::Bookkeeping as u8);

    /// A phase under way; it ends when this is dropped.
    #[derive(Debug)]
    pub struct Entered {
        around: u8,
    }

    /// Begins a phase, which lasts until the value returned is dropped.
    #[inline(always)]
    pub fn enter(phase: Phase) -> Entered {
        // A load and a store, for only one thread writes while anybody looks.
        let around = CURRENT.load(Ordering::Relaxed);
        CURRENT.store(phase as u8, Ordering::Relaxed);
        Entered { around }
    }

    impl Drop for Entered {
        #[inline(always)]
        fn drop(&mut self) {
            CURRENT.store(self.around, Ordering::Relaxed);
        }
    }

    /// The phase under way at this moment.
    pub fn current() -> Phase {
        Phase::ALL[usize::from(CURRENT.load(Ordering::Relaxed))]
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
