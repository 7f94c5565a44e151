//! The laws of kernels on a toy path space, and that each planted fault breaks one of them.

mod toy;

use std::collections::BTreeMap;

use ergodic_laws::faults::{Forgetful, NonFinite, Scaled, WrongPath};
use ergodic_laws::{
    Flow, Invariance, detailed_balance, generator, normal_limit, one_step_invariance, sidak, volume, way_back,
};
use ergodic_metropolis::{Mixture, Mutation, NotProposed, RandomSource, Target, acceptance};
use toy::{Kernel, LONGEST, Outside, Path, Splice, Toy, choices, exact, kernels};

type Plan = (usize, Splice);

/// The weighted form of the exact sampler, so that weights other than 1 are tested too: plain uniform paths, f/p with
/// p = 1/LONGEST for each length.
fn weighted(rng: &mut rand_pcg::Pcg64) -> Option<(Path, f64)> {
    let x: Path = (0..1 + rng.below(LONGEST)).map(|_| rng.uniform()).collect();
    let f = Toy.evaluate(&x).exp();
    Some((x, f * LONGEST as f64))
}

fn functions(x: &Path) -> [f64; 6] {
    let length = |n| f64::from(u8::from(x.len() == n));
    [length(1), length(2), length(4), x[0], x[x.len() - 1] * x[0], x.iter().sum()]
}

fn drift<M: Mutation<State = Path, Space = ()>>(kernel: &M, seed: u64, n: u64) -> Invariance {
    one_step_invariance(&Toy, kernel, &(), |rng| Some((exact(rng), 1.0)), functions, n, &mut generator(seed))
}

/// The flow between four lengths times four quarters of the first number.
fn flow<M: Mutation<State = Path, Space = ()>>(kernel: &M, seed: u64, n: u64) -> Flow {
    let cell = |x: &Path| 4 * (x.len() - 1) + (4.0 * x[0]) as usize;
    let (mut flow, mut rng) = (Flow::new(), generator(seed));
    for _ in 0..n {
        let x = exact(&mut rng);
        let mut y = x.clone();
        if let Ok(plan) = kernel.propose(&(), &x, &mut y, &mut rng) {
            let (fx, fy) = (Toy.evaluate(&x), Toy.evaluate(&y));
            let a = acceptance::<Toy, M>(kernel, &(), (&x, &fx), (&y, &fy), plan);
            flow.record(a.unwrap_or(f64::NAN), cell(&x), cell(&y));
        }
    }
    flow
}

/// The Jacobian r of the perturbation is lost for moves to the right.
fn lost_jacobian(from: &Path, to: &Path, (index, plan): Plan) -> f64 {
    if index == 1 && to[plan.prefix] > from[plan.prefix] { to[plan.prefix] - from[plan.prefix] } else { 1.0 }
}

/// The number of choices is read off the path that is moved to.
fn choices_of_the_wrong_path(from: &Path, to: &Path, (index, _): Plan) -> f64 {
    if index == 0 { choices(from.len()).len() as f64 / choices(to.len()).len() as f64 } else { 1.0 }
}

/// One split of the insertion is counted instead of all: off by the number of ways.
fn one_split_only(_: &Path, to: &Path, (index, plan): Plan) -> f64 {
    if index == 0 { 1.0 / (to.len() - plan.prefix - plan.suffix + 1) as f64 } else { 1.0 }
}

#[test]
fn every_way_there_is_a_way_back() {
    let report = way_back(&kernels(), &(), exact, 100_000, &mut generator(1));
    assert!(report.holds(0.0), "{report:?}");
    assert!(report.built < report.asked, "the toy has proposals that fail");

    // A kernel that reaches further from short paths than it says it does from long ones.
    let short_of_support =
        Scaled { mutation: kernels(), factor: |from: &Path, to: &Path, _| f64::from(u8::from(from.len() <= to.len())) };
    let report = way_back(&short_of_support, &(), exact, 10_000, &mut generator(1));
    assert!(!report.holds(0.0) && report.forward_faults > 100 && report.one_way > 100, "{report:?}");

    let report = way_back(&NonFinite::new(kernels(), 1000), &(), exact, 10_000, &mut generator(1));
    assert!(!report.holds(0.0) && report.example.is_some(), "{report:?}");
}

#[test]
fn detailed_balance_holds_to_rounding() {
    let report = detailed_balance(&Toy, &kernels(), &(), exact, 100_000, &mut generator(2));
    assert!(report.holds(1e-12), "{report:?}");

    let report = detailed_balance(&Toy, &NonFinite::new(kernels(), 1000), &(), exact, 10_000, &mut generator(2));
    assert!(!report.holds(1e-12) && report.faults > 0, "{report:?}");
}

/// Volumes of what each member reaches from x. Resampling reaches all of the inserted numbers' unit cube; perturbing
/// number i reaches both rings that lie inside the unit interval.
fn reachable(x: &Path) -> BTreeMap<(usize, usize, usize, usize), f64> {
    let mut volumes = BTreeMap::new();
    for &(prefix, cut, put) in choices(x.len()) {
        volumes.insert((0, prefix, x.len() - prefix - cut, x.len() - cut + put), 1.0);
    }
    for (i, v) in x.iter().enumerate() {
        let side = |room: f64| (room.min(0.3) - 0.01).max(0.0);
        volumes.insert((1, i, x.len() - i - 1, x.len()), side(*v) + side(1.0 - v));
    }
    volumes
}

fn volumes<M: Mutation<State = Path, Space = (), Plan = Plan>>(
    kernel: &M,
    n: u64,
) -> ergodic_laws::Volume<(usize, usize, usize, usize)> {
    let x = vec![0.3, 0.8, 0.5];
    let bin = |y: &Path, (index, plan): Plan| Some(((index, plan.prefix, plan.suffix, y.len()), 1.0));
    volume(kernel, &(), &x, &reachable(&x), bin, n, &mut generator(3))
}

#[test]
fn densities_integrate_like_the_sampler() {
    let right = volumes(&kernels(), 1_000_000);
    assert!(right.bins.len() > 20);
    assert!(right.holds(1e-4), "{right:#?}");
}

#[test]
fn the_volume_law_catches_faults_in_the_forward_density() {
    let worst = [
        ("choice forgotten", volumes(&Forgetful(kernels()), 200_000).max_z()),
        ("Jacobian lost", volumes(&Scaled { mutation: kernels(), factor: lost_jacobian }, 200_000).max_z()),
        ("one split only", volumes(&Scaled { mutation: kernels(), factor: one_split_only }, 200_000).max_z()),
        ("not a number", volumes(&NonFinite::new(kernels(), 1000), 200_000).max_z()),
    ];
    for (fault, z) in worst {
        println!("{fault}: z = {z:.0}");
        assert!(z > 20.0, "{fault}: z = {z}");
    }
}

#[test]
fn one_step_leaves_the_target_invariant() {
    let verdict = drift(&kernels(), 4, 600_000).verdict(1e-4);
    assert!(verdict.holds, "{verdict:?}");

    let weighted = one_step_invariance(&Toy, &kernels(), &(), weighted, functions, 600_000, &mut generator(5));
    let verdict = weighted.verdict(1e-4);
    assert!(verdict.holds, "{verdict:?}");
}

#[test]
fn invariance_catches_every_fault() {
    let n = 300_000;
    let worst = [
        ("choice forgotten", drift(&Forgetful(kernels()), 4, n)),
        ("choice from the wrong path", drift(&WrongPath(kernels()), 4, n)),
        ("choices of the wrong path", drift(&Scaled { mutation: kernels(), factor: choices_of_the_wrong_path }, 4, n)),
        ("Jacobian lost one way", drift(&Scaled { mutation: kernels(), factor: lost_jacobian }, 4, n)),
        ("one split only", drift(&Scaled { mutation: kernels(), factor: one_split_only }, 4, n)),
        ("not a number", drift(&NonFinite::new(kernels(), 1000), 4, n)),
    ];
    for (fault, invariance) in worst {
        let verdict = invariance.verdict(1e-4);
        println!("{fault}: t = {:.0}", verdict.max_t);
        assert!(!verdict.holds && verdict.max_t > 15.0, "{fault}: {verdict:?}");
    }
}

#[test]
fn as_much_flows_there_as_back() {
    let right = flow(&kernels(), 6, 300_000).verdict();
    assert!(right.holds && right.dof > 50, "{right:?}");

    let faulty = [
        ("choice forgotten", flow(&Forgetful(kernels()), 6, 300_000)),
        ("choice from the wrong path", flow(&WrongPath(kernels()), 6, 300_000)),
        (
            "choices of the wrong path",
            flow(&Scaled { mutation: kernels(), factor: choices_of_the_wrong_path }, 6, 300_000),
        ),
        ("Jacobian lost one way", flow(&Scaled { mutation: kernels(), factor: lost_jacobian }, 6, 300_000)),
        ("not a number", flow(&NonFinite::new(kernels(), 1000), 6, 1_000)),
    ];
    for (fault, flow) in faulty {
        let verdict = flow.verdict();
        println!("{fault}: Q / P = {:.1}", verdict.q / verdict.dof as f64);
        assert!(!verdict.holds, "{fault}: {verdict:?}");
    }
}

/// A kernel that never builds anything leaves every distribution as it is. No law may take that for success.
#[test]
fn a_kernel_that_does_nothing_passes_nothing() {
    let stuck = Mixture::new(vec![(1.0, Kernel::Perturb { least: 2.0, most: 3.0 })]).unwrap();
    let fails = |x: &Path| {
        let mut y = x.clone();
        stuck.propose(&(), x, &mut y, &mut generator(7)) == Err(NotProposed::Failed { index: 0, reason: Outside })
    };
    assert!(fails(&vec![0.5, 0.5]));
    assert!(!way_back(&stuck, &(), exact, 1000, &mut generator(7)).holds(1.0));
    assert!(!detailed_balance(&Toy, &stuck, &(), exact, 1000, &mut generator(7)).holds(1.0));
    assert!(!volumes(&stuck, 1000).holds(0.01));
    assert!(!drift(&stuck, 7, 1000).verdict(0.01).holds);
    assert!(!flow(&stuck, 7, 1000).verdict().holds);
}

/// The level means what it says: at 10 % for all functions together about a tenth of the runs of a right kernel fail.
#[test]
fn the_level_of_the_invariance_test_is_right() {
    let failures = (0..200).filter(|seed| !drift(&kernels(), 100 + seed, 3000).verdict(0.1).holds).count();
    // The functions are correlated, so Sidak is on the safe side; 20 expected at most, standard deviation 4.
    assert!((2..=36).contains(&failures), "{failures}");
    assert!((normal_limit(sidak(0.1, 6)) - 2.378).abs() < 0.01);
}
