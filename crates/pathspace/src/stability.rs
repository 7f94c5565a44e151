//! Contributions that no correct estimator makes, not finite or negative, counted by the place where they arose.
//!
//! They are left out of the estimate, which is an error however small, so they must never go unseen. The counters are plain
//! numbers of a thread: nothing that is rendered depends on them.

use std::cell::Cell;
use std::ops::{AddAssign, Sub};

use ergodic_scattering::Rgb;

/// Where a contribution was found to be no number, or negative.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Throughput of a walk from the eye.
    EyeWalk,
    /// Throughput of a walk from a light.
    LightWalk,
    /// A connection of two walks, or a walk that hit a light.
    Connection,
    /// A weight of multiple importance sampling.
    Weight,
    /// A light sample of the path tracer.
    NextEvent,
    /// The sum of a seeding sample.
    Seed,
    /// A splat.
    Film,
}

impl Place {
    /// All places, in the order in which tables show them.
    pub const ALL: [Self; 7] =
        [Self::EyeWalk, Self::LightWalk, Self::Connection, Self::Weight, Self::NextEvent, Self::Seed, Self::Film];

    /// A name for tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::EyeWalk => "eye_walk",
            Self::LightWalk => "light_walk",
            Self::Connection => "connection",
            Self::Weight => "weight",
            Self::NextEvent => "next_event",
            Self::Seed => "seed",
            Self::Film => "film",
        }
    }
}

/// How many contributions of one place were left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// NaN or infinite in a channel.
    pub non_finite: u64,
    /// Finite, and negative in a channel.
    pub negative: u64,
}

impl LeftOut {
    /// Both together.
    pub fn total(self) -> u64 {
        self.non_finite + self.negative
    }
}

/// What was left out, by place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stability([LeftOut; Place::ALL.len()]);

impl Stability {
    /// What was left out at one place.
    pub fn at(&self, place: Place) -> LeftOut {
        self.0[place as usize]
    }

    /// What was left out anywhere.
    pub fn total(&self) -> u64 {
        self.0.iter().map(|left_out| left_out.total()).sum()
    }
}

impl AddAssign for Stability {
    fn add_assign(&mut self, more: Self) {
        for (sum, more) in self.0.iter_mut().zip(more.0) {
            sum.non_finite += more.non_finite;
            sum.negative += more.negative;
        }
    }
}

impl Sub for Stability {
    type Output = Self;

    fn sub(mut self, before: Self) -> Self {
        for (count, before) in self.0.iter_mut().zip(before.0) {
            count.non_finite -= before.non_finite;
            count.negative -= before.negative;
        }
        self
    }
}

thread_local! {
    static LEFT_OUT: Cell<Stability> = const { Cell::new(Stability([LeftOut { non_finite: 0, negative: 0 }; Place::ALL.len()])) };
}

/// What this thread has left out so far.
pub fn left_out() -> Stability {
    LEFT_OUT.get()
}

/// Whether a contribution can be used: finite and not negative in every channel. One that cannot is counted.
#[inline]
pub fn is_usable(place: Place, value: Rgb) -> bool {
    let usable = value.cmpge(Rgb::ZERO).all() && value.max_element() < f64::INFINITY;
    if !usable {
        count(place, value.is_finite());
    }
    usable
}

/// The same of a single number.
#[inline]
pub fn is_usable_number(place: Place, value: f64) -> bool {
    let usable = (0.0..f64::INFINITY).contains(&value);
    if !usable {
        count(place, value.is_finite());
    }
    usable
}

#[cold]
fn count(place: Place, finite: bool) {
    let mut all = LEFT_OUT.get();
    let left_out = &mut all.0[place as usize];
    if finite {
        left_out.negative += 1;
    } else {
        left_out.non_finite += 1;
    }
    LEFT_OUT.set(all);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_counted_in_the_order_of_their_list() {
        for (i, place) in Place::ALL.into_iter().enumerate() {
            assert_eq!(place as usize, i);
        }
    }

    #[test]
    fn what_is_no_contribution_is_counted_and_zero_is_one() {
        let before = left_out();
        assert!(is_usable(Place::Film, Rgb::ZERO) && is_usable(Place::Film, Rgb::new(1e300, 0.0, 1e-320)));
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1e-300] {
            for channel in 0..3 {
                let mut value = Rgb::ONE;
                value[channel] = bad;
                assert!(!is_usable(Place::Film, value), "{value}");
            }
            assert!(!is_usable_number(Place::Weight, bad));
        }
        let found = left_out() - before;
        assert_eq!(found.at(Place::Film), LeftOut { non_finite: 9, negative: 3 });
        assert_eq!(found.at(Place::Weight), LeftOut { non_finite: 3, negative: 1 });
        assert_eq!(found.total(), 16);
    }
}
