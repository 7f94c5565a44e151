//! The accumulators on their own: what they sum, how parts merge, and that nothing odd counts as success.

use ergodic_laws::{Flow, Invariance, generator};
use ergodic_metropolis::RandomSource;

/// One step of a Metropolis chain on the unit interval for f(x) = 2 x, from uniform starts with weight 2 x. The `bias` multiplies
/// the acceptance of moves upward.
fn steps(seed: u64, n: usize, bias: f64) -> (Invariance, Flow) {
    let mut rng = generator(seed);
    let (mut invariance, mut flow) = (Invariance::new(2), Flow::new());
    for _ in 0..n {
        let (x, y) = (rng.uniform(), rng.uniform());
        let a = if y > x { bias } else { y / x };
        invariance.record(2.0 * x, a, &[x, x * x], &[y, y * y]);
        flow.record(2.0 * x * a, (8.0 * x) as usize, (8.0 * y) as usize);
    }
    (invariance, flow)
}

#[test]
fn a_right_chain_passes_and_a_biased_one_does_not() {
    let (invariance, flow) = steps(1, 400_000, 1.0);
    assert!(invariance.verdict(1e-4).holds, "{:?}", invariance.verdict(1e-4));
    assert!(flow.verdict().holds && flow.verdict().dof == 28, "{:?}", flow.verdict());

    let (invariance, flow) = steps(1, 400_000, 0.95);
    let verdict = invariance.verdict(1e-4);
    assert!(!verdict.holds && verdict.max_t > 8.0, "{verdict:?}");
    assert!(invariance.t().iter().all(|t| *t < 0.0), "too little goes up: {:?}", invariance.t());
    let verdict = flow.verdict();
    assert!(!verdict.holds, "{verdict:?}");
    assert!(verdict.worst.is_some_and(|((low, high), z)| low < high && z < 0.0), "{verdict:?}");
}

#[test]
fn parts_merge_to_the_whole() {
    let (mut invariance, mut flow) = steps(2, 1000, 1.0);
    let (second_invariance, second_flow) = steps(3, 2000, 1.0);
    let alone = invariance.t()[0];
    invariance.merge(&second_invariance);
    flow.merge(&second_flow);
    assert_eq!(invariance.counts(), (3000, 3000, 0));
    assert_ne!(invariance.t()[0], alone);
    // Merging in the other order is the same.
    let (first_invariance, first_flow) = steps(2, 1000, 1.0);
    let (mut other_invariance, mut other_flow) = (second_invariance, second_flow);
    other_invariance.merge(&first_invariance);
    other_flow.merge(&first_flow);
    assert!((other_invariance.t()[1] - invariance.t()[1]).abs() < 1e-12);
    assert!((other_flow.verdict().q - flow.verdict().q).abs() < 1e-9);
}

#[test]
fn numbers_that_are_none_fail() {
    for (weight, acceptance) in [(f64::NAN, 1.0), (1.0, f64::NAN), (f64::INFINITY, 1.0), (-1.0, 0.5)] {
        let (mut invariance, mut flow) = steps(4, 1000, 1.0);
        invariance.record(weight, acceptance, &[0.0, 0.0], &[1.0, 1.0]);
        flow.record(weight * acceptance, 0, 1);
        assert!(!invariance.verdict(1e-9).holds);
        assert!(!flow.verdict().holds);
    }
    let (mut invariance, _) = steps(4, 1000, 1.0);
    invariance.record(1.0, 1.0, &[0.0, 0.0], &[1.0, f64::NAN]);
    assert!(!invariance.verdict(1e-9).holds);
    let (mut invariance, _) = steps(4, 1000, 1.0);
    invariance.record_fault();
    assert!(!invariance.verdict(1e-9).holds);
}

#[test]
fn nothing_seen_is_nothing_shown() {
    let mut still = Invariance::new(1);
    still.record_stay();
    still.record(1.0, 0.0, &[0.0], &[1.0]);
    assert_eq!(still.counts(), (2, 0, 0));
    assert!(!still.verdict(0.5).holds);
    let mut inside = Flow::new();
    inside.record(1.0, 3, 3);
    assert!(!inside.verdict().holds);
}
