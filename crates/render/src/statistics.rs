//! What the mutations did: folds over the steps of the chains.

use ergodic_metropolis::Fault;
use ergodic_mutations::Rejection;
use ergodic_pathspace::PathClass;

/// Counts of one mutation, or of one mutation on paths of one length or class.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Proposals begun.
    pub proposed: u64,
    /// Proposals that could not be built, by the index of [`Rejection::ALL`].
    pub not_built: [u64; Rejection::ALL.len()],
    /// Proposals rejected because a density was not a number or the contribution negative, by the index of [`Fault::ALL`].
    pub faulty: [u64; Fault::ALL.len()],
    /// Proposals accepted.
    pub accepted: u64,
    /// Sum of acceptance probabilities.
    pub acceptance_sum: f64,
    /// Sum over built proposals of acceptance times the distance moved on the image, in pixels.
    pub jump_sum: f64,
    /// Nanoseconds spent in the steps that were timed.
    pub nanoseconds: u64,
    /// How many steps were timed.
    pub timed: u64,
}

impl Tally {
    fn add(&mut self, other: &Self) {
        self.proposed += other.proposed;
        for (sum, more) in self.not_built.iter_mut().zip(&other.not_built) {
            *sum += more;
        }
        for (sum, more) in self.faulty.iter_mut().zip(&other.faulty) {
            *sum += more;
        }
        self.accepted += other.accepted;
        self.acceptance_sum += other.acceptance_sum;
        self.jump_sum += other.jump_sum;
        self.nanoseconds += other.nanoseconds;
        self.timed += other.timed;
    }

    /// Mean acceptance probability over all proposals; one that was not built counts as 0.
    pub fn acceptance(&self) -> Option<f64> {
        (self.proposed > 0).then(|| self.acceptance_sum / self.proposed as f64)
    }

    /// Mean distance moved on the image when moved, in pixels: weighted by acceptance.
    pub fn mean_jump_pixels(&self) -> Option<f64> {
        (self.acceptance_sum > 0.0).then(|| self.jump_sum / self.acceptance_sum)
    }

    /// Mean time of a proposal in nanoseconds, acceptance test and splats included.
    pub fn ns_per_proposal(&self) -> Option<f64> {
        (self.timed > 0).then(|| self.nanoseconds as f64 / self.timed as f64)
    }
}

/// What one step of a chain came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// No candidate.
    NotBuilt(Rejection),
    /// A density was not a number.
    Faulty(Fault),
    /// A candidate was weighed.
    Tried {
        /// Acceptance probability.
        acceptance: f64,
        /// Whether it was accepted.
        accepted: bool,
        /// Distance between the two image points in pixels.
        jump: f64,
    },
}

/// Intervals of jump distances: none at all, less than 1/16 pixel, then from each power of two to the next, and 2048 pixels or more.
pub const JUMP_INTERVALS: usize = 18;

/// The greatest power of two below which all jumps but 0 are in one interval.
const SHORTEST_JUMP: i32 = -4;

/// The interval of a distance. The exponent of a floating-point number is its power of two.
#[inline]
fn jump_interval(pixels: f64) -> usize {
    if pixels == 0.0 {
        return 0;
    }
    let exponent = (pixels.to_bits() >> 52 & 0x7ff) as i32 - 1023;
    (exponent - SHORTEST_JUMP + 2).clamp(1, JUMP_INTERVALS as i32 - 1) as usize
}

/// From what distance on, and up to which, an interval counts, in pixels. The last has no end; the first is 0 alone.
pub fn jump_bounds(interval: usize) -> (f64, f64) {
    let bound = |interval: usize| libm::exp2(f64::from(SHORTEST_JUMP) + interval as f64 - 2.0);
    match interval {
        0 => (0.0, 0.0),
        1 => (0.0, bound(2)),
        _ if interval + 1 < JUMP_INTERVALS => (bound(interval), bound(interval + 1)),
        _ => (bound(interval), f64::INFINITY),
    }
}

/// Paths up to this many edges are told apart by class.
pub const CLASSIFIED_EDGES: u32 = 8;

/// Number of classes up to [`CLASSIFIED_EDGES`] edges: 2^(k-1) for each k.
const CLASSES: usize = (1 << CLASSIFIED_EDGES) - 1;

/// Of a class of at most so many edges; shorter ones first.
fn class_index(class: PathClass) -> usize {
    (1 << (class.length - 1)) - 1 + class.specular as usize
}

fn class_of_index(index: usize) -> PathClass {
    let length = usize::BITS - (index + 1).leading_zeros();
    PathClass { length, specular: (index + 1 - (1 << (length - 1))) as u64 }
}

/// What steps are told apart by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Of a path that is short enough.
    Class(PathClass),
    /// Number of edges of one that is not.
    Longer(usize),
    /// [`PathClass::MANY`].
    Many,
}

impl Kind {
    fn of(class: PathClass) -> Self {
        match class.length {
            1..=CLASSIFIED_EDGES => Self::Class(class),
            _ if class == PathClass::MANY => Self::Many,
            length => Self::Longer(length as usize),
        }
    }

    /// Dense, from 0 on.
    #[inline]
    fn index(self) -> usize {
        match self {
            Self::Class(class) => class_index(class),
            Self::Many => CLASSES,
            Self::Longer(edges) => CLASSES + edges - CLASSIFIED_EDGES as usize,
        }
    }

    fn of_index(index: usize) -> Self {
        match index {
            0..CLASSES => Self::Class(class_of_index(index)),
            CLASSES => Self::Many,
            _ => Self::Longer(index - CLASSES + CLASSIFIED_EDGES as usize),
        }
    }

    /// How many there are among paths of at most `max_edges` edges.
    const fn count(max_edges: usize) -> usize {
        CLASSES + 1 + max_edges.saturating_sub(CLASSIFIED_EDGES as usize)
    }
}

/// Tallies of one mutation.
///
/// A step is counted in one place only: by class if the path is short enough, else by length. Everything else is summed
/// from that.
#[derive(Clone, Debug)]
pub struct MutationStatistics {
    /// Name of the mutation.
    pub name: &'static str,
    /// Where the tally of each kind is, by [`Kind::index`].
    places: Vec<u16>,
    /// Those of kinds met so far. There is room for all, of which memory that is never met is never touched.
    tallies: Vec<Tally>,
    /// Sums of acceptance probabilities by the interval of the jump.
    jumps: [f64; JUMP_INTERVALS],
}

/// The place of a kind that has not been met.
const NOWHERE: u16 = u16::MAX;

impl MutationStatistics {
    /// Empty tallies for paths of at most `max_edges` edges.
    pub fn new(name: &'static str, max_edges: usize) -> Self {
        let count = Kind::count(max_edges);
        let (places, tallies) = (vec![NOWHERE; count], Vec::with_capacity(count));
        Self { name, places, tallies, jumps: [0.0; JUMP_INTERVALS] }
    }

    /// Empty tallies for each member of a mixture, by their names.
    pub(crate) fn of_members(names: &[&'static str], max_edges: usize) -> Vec<Self> {
        names.iter().map(|name| Self::new(name, max_edges)).collect()
    }

    /// Bytes of the tallies for paths of at most `max_edges` edges.
    pub(crate) const fn bytes(max_edges: usize) -> usize {
        Kind::count(max_edges) * (size_of::<u16>() + size_of::<Tally>()) + size_of::<[f64; JUMP_INTERVALS]>()
    }

    /// The tally of a kind, empty if it has not been met before.
    #[inline]
    fn tally(&mut self, index: usize) -> &mut Tally {
        let place = &mut self.places[index];
        if *place == NOWHERE {
            *place = self.tallies.len() as u16;
            self.tallies.push(Tally::default());
        }
        &mut self.tallies[usize::from(*place)]
    }

    /// Kinds that have been met, in the order of their indices.
    fn met(&self) -> impl Iterator<Item = (usize, &Tally)> {
        let places = self.places.iter().enumerate().filter(|(_, place)| **place != NOWHERE);
        places.map(|(index, place)| (index, &self.tallies[usize::from(*place)]))
    }

    /// Records a step from a path of `class`.
    #[inline]
    pub fn record(&mut self, class: PathClass, outcome: Outcome, nanoseconds: Option<u64>) {
        let tally = self.tally(Kind::of(class).index());
        tally.proposed += 1;
        match outcome {
            Outcome::NotBuilt(reason) => tally.not_built[reason as usize] += 1,
            Outcome::Faulty(fault) => tally.faulty[fault as usize] += 1,
            Outcome::Tried { acceptance, accepted, jump } => {
                tally.acceptance_sum += acceptance;
                tally.accepted += u64::from(accepted);
                tally.jump_sum += acceptance * jump;
            }
        }
        if let Some(nanoseconds) = nanoseconds {
            tally.timed += 1;
            tally.nanoseconds += nanoseconds;
        }
        if let Outcome::Tried { acceptance, jump, .. } = outcome {
            self.jumps[jump_interval(jump)] += acceptance;
        }
    }

    /// Adds the tallies of another part of the same run.
    pub fn add(&mut self, other: &Self) {
        other.met().for_each(|(index, more)| self.tally(index).add(more));
        for (sum, more) in self.jumps.iter_mut().zip(&other.jumps) {
            *sum += more;
        }
    }

    /// Everything.
    pub fn total(&self) -> Tally {
        let mut total = Tally::default();
        self.met().for_each(|(_, tally)| total.add(tally));
        total
    }

    /// Share of the accepted weight by the interval of the distance moved on the image ([`jump_bounds`]); `None` if nothing was
    /// accepted.
    pub fn jump_shares(&self) -> Option<[f64; JUMP_INTERVALS]> {
        let all: f64 = self.jumps.iter().sum();
        (all > 0.0).then(|| self.jumps.map(|part| part / all))
    }

    /// Lengths (edges of the path that was to be changed) with at least one proposal.
    pub fn lengths(&self) -> Vec<(usize, Tally)> {
        let mut lengths: Vec<(usize, Tally)> = Vec::new();
        for (index, tally) in self.met() {
            let length = match Kind::of_index(index) {
                Kind::Class(class) => class.length as usize,
                Kind::Longer(edges) => edges,
                Kind::Many => continue,
            };
            // Indices go up with the length.
            match lengths.last_mut().filter(|(last, _)| *last == length) {
                Some((_, sum)) => sum.add(tally),
                None => lengths.push((length, *tally)),
            }
        }
        lengths
    }

    /// Of one class; nothing for classes of more than [`CLASSIFIED_EDGES`] edges.
    pub fn class(&self, class: PathClass) -> Tally {
        let Kind::Class(class) = Kind::of(class) else { return Tally::default() };
        let place = usize::from(self.places[class_index(class)]);
        self.tallies.get(place).copied().unwrap_or_default()
    }

    /// Classes (of the path that was to be changed) with at least one proposal, up to [`CLASSIFIED_EDGES`] edges.
    pub fn classes(&self) -> Vec<(PathClass, Tally)> {
        let class = |(index, tally): (usize, &Tally)| match Kind::of_index(index) {
            Kind::Class(class) => Some((class, *tally)),
            Kind::Longer(_) | Kind::Many => None,
        };
        self.met().filter_map(class).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_of_kinds_are_dense_and_invertible() {
        let max_edges = CLASSIFIED_EDGES as usize + 3;
        let mut seen = vec![false; Kind::count(max_edges)];
        let classes = (1..=max_edges as u32).flat_map(|length| {
            let classes = if length <= CLASSIFIED_EDGES { 1 << (length - 1) } else { 1 };
            (0..classes).map(move |specular| PathClass { length, specular })
        });
        for class in classes.chain([PathClass::MANY]) {
            let kind = Kind::of(class);
            assert!(!std::mem::replace(&mut seen[kind.index()], true));
            assert_eq!(Kind::of_index(kind.index()), kind);
            assert!(kind == Kind::Class(class) || class.length > CLASSIFIED_EDGES || kind == Kind::Many);
        }
        assert!(seen.iter().all(|&s| s));
    }

    #[test]
    fn what_was_met_in_any_order_is_told_in_order_and_sums_up() {
        let class = |length, specular| PathClass { length, specular };
        let paths = [class(12, 5), class(2, 1), class(3, 0), PathClass::MANY, class(2, 0), class(12, 0), class(2, 1)];
        let (mut one, mut first, mut second) = {
            let none = MutationStatistics::new("any", 16);
            (none.clone(), none.clone(), none)
        };
        for (i, path) in paths.into_iter().enumerate() {
            let outcome = Outcome::Tried { acceptance: 0.5, accepted: i % 2 == 0, jump: 1.0 };
            one.record(path, outcome, None);
            if i < 3 { first.record(path, outcome, None) } else { second.record(path, outcome, None) }
        }
        // The parts met the kinds in another order.
        second.add(&first);
        for statistics in [&one, &second] {
            let classes: Vec<_> = statistics.classes().iter().map(|(class, tally)| (*class, tally.proposed)).collect();
            assert_eq!(classes, [(class(2, 0), 1), (class(2, 1), 2), (class(3, 0), 1)]);
            let lengths: Vec<_> =
                statistics.lengths().iter().map(|(length, tally)| (*length, tally.proposed)).collect();
            assert_eq!(lengths, [(2, 3), (3, 1), (12, 2)]);
            let total = statistics.total();
            assert_eq!((total.proposed, total.accepted, total.acceptance()), (7, 4, Some(0.5)));
            assert_eq!(statistics.class(class(2, 1)).proposed, 2);
            assert_eq!(statistics.class(class(3, 1)), Tally::default());
            assert_eq!(statistics.class(class(12, 5)), Tally::default());
        }
    }

    #[test]
    fn jumps_are_counted_where_their_bounds_say() {
        let class = PathClass { length: 2, specular: 0 };
        for jump in [0.0, 1e-300, 0.06, 0.0625, 0.1, 0.99, 1.0, 1.5, 2.0, 2047.9, 2048.0, 1e6, 5e-324] {
            let mut statistics = MutationStatistics::new("any", 4);
            statistics.record(class, Outcome::Tried { acceptance: 0.25, accepted: false, jump }, None);
            let shares = statistics.jump_shares().unwrap();
            for (interval, share) in shares.into_iter().enumerate() {
                let (from, to) = jump_bounds(interval);
                let inside = if interval == 0 { jump == 0.0 } else { jump > 0.0 && from <= jump && jump < to };
                assert_eq!(share, if inside { 1.0 } else { 0.0 }, "{jump} in {from} to {to}");
            }
        }
        assert_eq!(MutationStatistics::new("none", 4).jump_shares(), None);
        let bounds: Vec<_> = (1..JUMP_INTERVALS).map(jump_bounds).collect();
        assert!(bounds.windows(2).all(|pair| pair[0].1 == pair[1].0) && bounds[0] == (0.0, 0.0625));
    }

    #[test]
    fn reasons_are_counted_in_the_order_of_their_list() {
        for (i, reason) in Rejection::ALL.into_iter().enumerate() {
            assert_eq!(reason as usize, i);
        }
        for (i, fault) in Fault::ALL.into_iter().enumerate() {
            assert_eq!(fault as usize, i);
        }
    }
}
