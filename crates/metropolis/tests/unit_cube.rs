//! Mutations of the unit cube: with a constant target every coordinate stays uniform; densities are the samplers'.

use std::convert::Infallible;

use ergodic_laws::{Invariance, generator, kolmogorov_smirnov_uniform};
use ergodic_metropolis::unit_cube::{LargeStep, SmallStep};
use ergodic_metropolis::{Chain, Mutation, RandomSource, Step, Target};

const DIMENSIONS: usize = 6;
const STEP: SmallStep = SmallStep { min: 1.0 / 1024.0, max: 1.0 / 8.0 };

/// The constant target: acceptance is by the densities alone.
struct Flat;

impl Target for Flat {
    type State = Vec<f64>;
    type Value = f64;

    fn evaluate(&self, _: &Vec<f64>) -> f64 {
        0.0
    }

    fn ln_density(value: &f64) -> f64 {
        *value
    }
}

/// From uniform points, `steps` steps: the least probability over coordinates that they are still uniform, corrected for how
/// many there are.
fn prior<M: Mutation<Space = (), State = Vec<f64>>>(kernel: &M, steps: usize, points: usize) -> f64 {
    let mut rng = generator(3);
    let mut coordinates = vec![Vec::new(); DIMENSIONS];
    for _ in 0..points {
        let mut chain = Chain::new((0..DIMENSIONS).map(|_| rng.uniform()).collect(), &Flat);
        for _ in 0..steps {
            assert!(matches!(chain.step(&Flat, kernel, &(), &mut rng), Step::Tried { .. }));
        }
        for (all, value) in coordinates.iter_mut().zip(chain.current().0) {
            all.push(*value);
        }
    }
    let least = coordinates.iter_mut().map(|all| kolmogorov_smirnov_uniform(all).p_value).fold(1.0, f64::min);
    // The least of so many uniform numbers.
    1.0 - (1.0 - least).powi(DIMENSIONS as i32)
}

/// A small step that stops at the border where it should wrap around, and says of itself that it is symmetric.
struct Clamped;

impl Mutation for Clamped {
    type Space = ();
    type State = Vec<f64>;
    type Plan = ();
    type Failure = Infallible;

    fn propose(&self, _: &(), x: &Vec<f64>, y: &mut Vec<f64>, rng: &mut impl RandomSource) -> Result<(), Infallible> {
        y.clear();
        y.extend(x.iter().map(|x| (x + 0.25 * (rng.uniform() - 0.5)).clamp(0.0, 1.0)));
        Ok(())
    }

    fn ln_density(&self, _: &(), _: &Vec<f64>, _: &Vec<f64>, _: ()) -> f64 {
        0.0
    }
}

/// A small step to the right more often than to the left.
struct Drifting;

impl Mutation for Drifting {
    type Space = ();
    type State = Vec<f64>;
    type Plan = ();
    type Failure = Infallible;

    fn propose(&self, _: &(), x: &Vec<f64>, y: &mut Vec<f64>, rng: &mut impl RandomSource) -> Result<(), Infallible> {
        y.clear();
        // Towards 1, and less so the nearer it is: the cube is no torus to it.
        y.extend(x.iter().map(|x| x + 0.05 * rng.uniform() * (1.0 - x)));
        Ok(())
    }

    fn ln_density(&self, _: &(), _: &Vec<f64>, _: &Vec<f64>, _: ()) -> f64 {
        0.0
    }
}

#[test]
fn primary_samples_stay_uniform() {
    let points = if std::env::var("ERGODIC_TESTS").is_ok_and(|v| v == "nightly") { 1_000_000 } else { 100_000 };
    for steps in [1, 8] {
        let found = [prior(&LargeStep {}, steps, points), prior(&STEP, steps, points)];
        println!("{steps} steps: p = {found:?}");
        assert!(found.iter().all(|p| *p > 1e-4), "{found:?}");
        let faulty = [prior(&Clamped, steps, points), prior(&Drifting, steps, points)];
        assert!(faulty.iter().all(|p| *p < 1e-6), "a planted fault passes: {faulty:?}");
    }
}

/// A target that leans to one corner.
struct Leaning;

impl Target for Leaning {
    type State = Vec<f64>;
    type Value = f64;

    fn evaluate(&self, x: &Vec<f64>) -> f64 {
        x.iter().map(|x| x.ln()).sum()
    }

    fn ln_density(value: &f64) -> f64 {
        *value
    }
}

#[test]
fn one_step_leaves_a_leaning_target_invariant() {
    let mut rng = generator(5);
    let mut law = Invariance::new(3);
    let mut faulty = Invariance::new(3);
    let h = |x: &[f64]| [x[0], x[1] * x[1], (x[0] - x[2]).abs()];
    for _ in 0..200_000 {
        // The square root of a uniform number has density 2 x.
        let x: Vec<f64> = (0..3).map(|_| rng.uniform().sqrt().min(1f64.next_down())).collect();
        for (kernel_is_right, law) in [(true, &mut law), (false, &mut faulty)] {
            let mut chain = Chain::new(x.clone(), &Leaning);
            let step = if kernel_is_right {
                chain.step(&Leaning, &STEP, &(), &mut rng)
            } else {
                chain.step(&Leaning, &Drifting, &(), &mut rng)
            };
            let Step::Tried { acceptance, accepted, .. } = step else { panic!("{step:?}") };
            let y = if accepted { chain.current().0 } else { chain.other().0 };
            law.record(1.0, acceptance, &h(&x), &h(y));
        }
    }
    let (verdict, fault) = (law.verdict(1e-4), faulty.verdict(1e-4));
    println!("max |t| {:.1}, of the planted fault {:.1}, limit {:.1}", verdict.max_t, fault.max_t, verdict.limit);
    assert!(verdict.holds && !fault.holds);
}

#[test]
fn small_steps_keep_to_their_sizes_and_to_the_cube() {
    let mut rng = generator(7);
    let mut y = Vec::new();
    for corner in [0.0, 1e-300, 0.5, 1f64.next_down()] {
        let x = vec![corner; DIMENSIONS];
        for _ in 0..1000 {
            assert_eq!(STEP.propose(&(), &x, &mut y, &mut rng), Ok(()));
            assert!(y.iter().all(|v| (0.0..1.0).contains(v)), "{y:?}");
            let (there, back) = (STEP.ln_density(&(), &x, &y, ()), STEP.ln_density(&(), &y, &x, ()));
            assert!(there.is_finite() && there == back, "{there} {back}");
        }
    }
    assert_eq!(STEP.ln_density(&(), &vec![0.5], &vec![0.5], ()), f64::NEG_INFINITY);
    assert_eq!(STEP.ln_density(&(), &vec![0.2], &vec![0.5], ()), f64::NEG_INFINITY);
}
