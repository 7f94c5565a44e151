//! What a chain reports, how a mixture chooses, and where random numbers lie.

use std::convert::Infallible;

use ergodic_laws::faults::NonFinite;
use ergodic_laws::{chi_square, generator};
use ergodic_metropolis::finite::{FiniteProposal, FiniteTarget, TransitionMatrix};
use ergodic_metropolis::{
    Chain, Fault, Mixture, MixtureError, Mutation, NotProposed, RandomSource, Replay, Step, Target, acceptance,
};

/// Moves a number by one, up or down; weighs itself by `suits`.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Walk {
    suits: f64,
}

impl Mutation for Walk {
    type Space = ();
    type State = i64;
    type Plan = ();
    type Failure = Infallible;

    fn suitability(&self, (): &(), x: &i64) -> f64 {
        if *x < 0 { 0.0 } else { self.suits }
    }

    fn propose(&self, (): &(), x: &i64, y: &mut i64, rng: &mut impl RandomSource) -> Result<(), Infallible> {
        *y = if rng.uniform() < 0.5 { x - 1 } else { x + 1 };
        Ok(())
    }

    fn ln_density(&self, (): &(), _: &i64, _: &i64, (): ()) -> f64 {
        0.5f64.ln()
    }
}

/// The logarithm of the target is looked up; 0 where nothing is said.
struct Table(Vec<(i64, f64)>);

impl Target for Table {
    type State = i64;
    type Value = f64;

    fn evaluate(&self, x: &i64) -> f64 {
        self.0.iter().find(|(state, _)| state == x).map_or(0.0, |(_, ln)| *ln)
    }

    fn ln_density(value: &f64) -> f64 {
        *value
    }
}

fn walk() -> Walk {
    Walk { suits: 1.0 }
}

#[test]
fn a_target_that_is_no_number_is_reported_and_not_entered() {
    for bad in [f64::NAN, f64::INFINITY] {
        let target = Table(vec![(1, bad), (-1, bad)]);
        let mut chain = Chain::new(0, &target);
        for seed in 0..20 {
            let step = chain.step(&target, &walk(), &(), &mut generator(seed));
            assert_eq!(step, Step::Faulty { plan: (), fault: Fault::Target });
            assert_eq!(*chain.current().0, 0);
        }
    }
}

#[test]
fn densities_that_are_no_numbers_are_reported() {
    let target = Table(vec![]);
    // The first density that is asked for is the one of the way there, the second the one of the way back.
    for (period, fault) in [(1, Fault::Forward), (2, Fault::Backward)] {
        let mut chain = Chain::new(0, &target);
        let step = chain.step(&target, &NonFinite::new(walk(), period), &(), &mut generator(1));
        assert_eq!(step, Step::Faulty { plan: (), fault });
        assert_eq!(*chain.current().0, 0);
    }
}

#[test]
fn a_bad_start_is_reported() {
    let target = Table(vec![(0, f64::NAN)]);
    let mut chain = Chain::new(0, &target);
    let step = chain.step(&target, &walk(), &(), &mut generator(1));
    assert_eq!(step, Step::Faulty { plan: (), fault: Fault::Target });
}

#[test]
fn zero_is_left_at_once_and_never_entered() {
    let zero = Table(vec![(0, f64::NEG_INFINITY)]);
    let accept = |x: i64, y: i64| {
        let (fx, fy) = (zero.evaluate(&x), zero.evaluate(&y));
        acceptance::<Table, Walk>(&walk(), &(), (&x, &fx), (&y, &fy), ())
    };
    assert_eq!(accept(0, 1), Ok(1.0));
    assert_eq!(accept(1, 0), Ok(0.0));
    assert_eq!(accept(1, 2), Ok(1.0));
}

#[test]
fn after_a_step_both_ends_can_be_seen() {
    let target = Table(vec![(1, -1.0), (-1, -1.0)]);
    let mut rng = generator(3);
    let (mut accepted_seen, mut rejected_seen) = (false, false);
    for _ in 0..50 {
        let mut chain = Chain::new(0, &target);
        let Step::Tried { acceptance, accepted, .. } = chain.step(&target, &walk(), &(), &mut rng) else {
            panic!("nothing is faulty here");
        };
        assert!((acceptance - (-1.0f64).exp()).abs() < 1e-15);
        let (here, there) = if accepted { (chain.current(), chain.other()) } else { (chain.other(), chain.current()) };
        assert!(here.0.abs() == 1 && *here.1 == -1.0);
        assert_eq!(there, (&0, &0.0));
        (accepted_seen, rejected_seen) = (accepted_seen || accepted, rejected_seen || !accepted);
    }
    assert!(accepted_seen && rejected_seen);
}

#[test]
fn a_mixture_chooses_by_weight_times_suitability() {
    let members: Vec<(f64, Walk)> =
        [(1.0, 0.5), (0.0, 9.0), (2.0, 1.0), (0.7, 0.0)].map(|(w, suits)| (w, Walk { suits })).into();
    let mixture = Mixture::new(members).unwrap();
    let probabilities: Vec<f64> = (0..4).map(|i| mixture.probability(i, &(), &0)).collect();
    assert!((probabilities.iter().sum::<f64>() - 1.0).abs() < 1e-15);
    assert_eq!(probabilities, [0.2, 0.0, 0.8, 0.0]);

    let (mut rng, mut y, mut counts) = (generator(4), 0, vec![0u64; 4]);
    for _ in 0..100_000 {
        let (index, ()) = mixture.propose(&(), &0, &mut y, &mut rng).unwrap();
        counts[index] += 1;
    }
    let expected = |p: &[f64]| p.iter().map(|p| p * 1e5).collect::<Vec<_>>();
    assert!(chi_square(&counts, &expected(&probabilities), 5.0).unwrap().p_value > 1e-4);
    assert!(chi_square(&counts, &expected(&[0.21, 0.0, 0.79, 0.0]), 5.0).unwrap().p_value < 1e-6);

    // The same probability is in the density, and the extreme numbers choose members that can be chosen.
    assert!((mixture.ln_density(&(), &0, &1, (2, ())) - (0.8f64 * 0.5).ln()).abs() < 1e-15);
    assert_eq!(mixture.ln_density(&(), &0, &1, (1, ())), f64::NEG_INFINITY);
    for u in [0.0, 1.0 - f64::EPSILON / 2.0] {
        let (index, ()) = mixture.propose(&(), &0, &mut y, &mut Replay::new(vec![u, 0.3])).unwrap();
        assert!(probabilities[index] > 0.0);
    }
}

#[test]
fn where_nothing_is_suitable_nothing_is_proposed() {
    let mixture = Mixture::new(vec![(1.0, walk()), (3.0, walk())]).unwrap();
    let target = Table(vec![]);
    let mut chain = Chain::new(-1, &target);
    let step = chain.step(&target, &mixture, &(), &mut generator(5));
    assert_eq!(step, Step::NotProposed(NotProposed::NoneSuitable));
    assert_eq!(*chain.current().0, -1);
    assert_eq!(mixture.probability(0, &(), &-1), 0.0);
    // From 0 the step to -1 has no way back and is always rejected.
    for seed in 0..50 {
        let mut chain = Chain::new(0, &target);
        chain.step(&target, &mixture, &(), &mut generator(seed));
        assert!(*chain.current().0 >= 0);
    }
}

#[test]
fn weights_are_checked_from_code_and_from_files() {
    assert_eq!(Mixture::<Walk>::new(vec![]).unwrap_err(), MixtureError::Empty);
    assert_eq!(Mixture::new(vec![(0.0, walk())]).unwrap_err(), MixtureError::Empty);
    assert_eq!(
        Mixture::new(vec![(1.0, walk()), (-2.0, walk())]).unwrap_err(),
        MixtureError::Weight { index: 1, weight: -2.0 }
    );
    assert!(Mixture::new(vec![(f64::NAN, walk())]).is_err());

    let read: Mixture<Walk> = ron::from_str("[(1.0, (suits: 0.5)), (2, (suits: 1))]").unwrap();
    assert_eq!(read.probability(0, &(), &0), 0.2);
    let again: Mixture<Walk> = ron::from_str(&ron::to_string(&read).unwrap()).unwrap();
    assert_eq!(again.members().len(), 2);
    let error = ron::from_str::<Mixture<Walk>>("[(-1.0, (suits: 0.5))]").unwrap_err();
    assert!(error.to_string().contains("the weight of mutation 0 is -1"), "{error}");
    let error = ron::from_str::<Mixture<Walk>>("[(1.0, (suit: 0.5))]").unwrap_err();
    assert!(error.to_string().contains("suit"), "{error}");
}

/// A generator that gives one word for ever.
struct Constant(u64);

impl rand_core::TryRng for Constant {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok(self.0 as u32)
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(self.0)
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        bytes.fill(self.0 as u8);
        Ok(())
    }
}

#[test]
fn uniform_numbers_are_never_one() {
    for (word, number) in
        [(0, 0.0), (1 << 63, 0.5), (u64::MAX, 1.0 - f64::EPSILON / 2.0), (2047, 0.0), (2048, 2f64.powi(-53))]
    {
        assert_eq!(Constant(word).uniform(), number);
    }
    for n in [1, 2, 3, 1000, usize::MAX] {
        assert_eq!(Constant(0).below(n), 0);
        assert!(Constant(u64::MAX).below(n) < n);
    }
    assert_eq!(Constant(u64::MAX).below(1000), 999);
}

#[test]
fn uniform_numbers_fill_the_interval_evenly() {
    let mut rng = generator(8);
    let mut counts = vec![0u64; 100];
    (0..1_000_000).for_each(|_| counts[rng.below(100)] += 1);
    assert!(chi_square(&counts, &[10_000.0; 100], 5.0).unwrap().p_value > 1e-4);
}

#[test]
fn replayed_numbers_come_back_in_order() {
    let mut replay = Replay::new(vec![0.1, 0.2]);
    assert_eq!([0; 4].map(|_| replay.uniform()), [0.1, 0.2, 0.2, 0.2]);
    assert_eq!(Replay::new(vec![]).uniform(), 0.5);
}

#[test]
fn the_same_seed_walks_the_same_way() {
    let matrix = TransitionMatrix::from_rows(vec![vec![0.5, 0.5], vec![0.5, 0.5]]).unwrap();
    let (kernel, target) = (FiniteProposal::new(matrix), FiniteTarget::new(vec![1.0, 3.0]).unwrap());
    let run = |seed| {
        let (mut chain, mut rng) = (Chain::new(0, &target), generator(seed));
        (0..200)
            .map(|_| {
                chain.step(&target, &kernel, &(), &mut rng);
                *chain.current().0
            })
            .collect::<Vec<_>>()
    };
    assert_eq!(run(9), run(9));
    assert_ne!(run(9), run(10));
}
