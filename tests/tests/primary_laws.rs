//! The laws of chains in primary sample space, on real scenes, with every sampler; and planted faults that break them.

use ergodic_laws::faults::Scaled;
use ergodic_laws::{Invariance, detailed_balance, one_step_invariance, way_back};
use ergodic_metropolis::{Mixture, Mutation};
use ergodic_pathspace::{PathClass, PathSpace, Roulette};
use ergodic_render::{
    BidirectionalPathTracer, Estimator, Multiplexed, PathTracer, PrimaryMutation, PrimarySample, PrimarySpace,
    PrimaryTarget, Purpose, stream,
};
use ergodic_scattering::{Everything, luminance};
use ergodic_tests::{nightly, space};
use rand_pcg::Pcg64Dxsm;

use crate::mutation_laws::{LENGTHS, SIZE};

const ROULETTE: Roulette = Roulette { start: 4, survival: 0.7 };

/// Functions of a sample whose means must stay where they are.
fn functions<E: Estimator<Repertoire = Everything>>(x: &PrimarySample<E>) -> [f64; 6] {
    let total = x.luminance();
    let at = x.splats().iter().max_by(|a, b| a.1.x.total_cmp(&b.1.x)).map_or([0.0; 2], |(raster, _)| raster.to_array());
    let red: f64 = x.splats().iter().map(|(_, color)| color.x).sum();
    [
        at[0] / f64::from(SIZE.0),
        f64_of(at[1] * 2.0 < f64::from(SIZE.1)),
        x.splats().len() as f64,
        red / total.max(f64::MIN_POSITIVE),
        f64_of(total > 1.0),
        x.splats().iter().map(|(_, color)| luminance(*color).min(1.0)).sum(),
    ]
}

fn f64_of(is: bool) -> f64 {
    f64::from(u8::from(is))
}

/// A uniform sample and its weight.
fn draw<E: Estimator<Repertoire = Everything>>(
    space: &PrimarySpace,
    estimator: &E,
    rng: &mut Pcg64Dxsm,
) -> Option<(PrimarySample<E>, f64)> {
    let mut x = PrimarySample::new(estimator.clone());
    x.draw(&space.scene, rng);
    let weight = x.luminance();
    (weight > 0.0).then_some((x, weight))
}

fn drift<E: Estimator<Repertoire = Everything>, M: Mutation<Space = PrimarySpace, State = PrimarySample<E>>>(
    space: &PrimarySpace,
    estimator: &E,
    mutation: &M,
    n: u64,
) -> Invariance {
    let mut rng = stream(3, Purpose::Chain, 0);
    let draw = |rng: &mut Pcg64Dxsm| draw(space, estimator, rng);
    one_step_invariance(&PrimaryTarget::default(), mutation, space, draw, functions, n, &mut rng)
}

fn members<E>() -> [PrimaryMutation<E>; 2] {
    [PrimaryMutation::Large, PrimaryMutation::small(1.0 / 1024.0, 1.0 / 64.0)]
}

pub(crate) fn check<E: Estimator<Repertoire = Everything>>(name: &str, space: &PathSpace, estimator: &E, n: u64) {
    let space = PrimarySpace { scene: space.scene.clone() };
    let mut rng = stream(3, Purpose::Chain, 1);
    let mut source = |rng: &mut Pcg64Dxsm| loop {
        if let Some((x, _)) = draw(&space, estimator, rng) {
            return x;
        }
    };
    for mutation in members::<E>() {
        let back = way_back(&mutation, &space, &mut source, n / 8, &mut rng);
        assert!(back.holds(0.0), "{name} {}: {back:?}", mutation.name());
        let balance = detailed_balance(&PrimaryTarget::default(), &mutation, &space, &mut source, n / 8, &mut rng);
        assert!(balance.holds(1e-8), "{name} {}: {balance:?}", mutation.name());
    }
    let mixture = Mixture::new(members::<E>().map(|m| (0.5, m)).to_vec()).expect("positive weights");
    let verdict = drift(&space, estimator, &mixture, n).verdict(1e-4);
    println!("{name}: largest |t| {:.2} of function {}, limit {:.2}", verdict.max_t, verdict.function, verdict.limit);
    assert!(verdict.holds, "{name}: {verdict:?}");

    // A step that is drawn to the right more often than its density says.
    let factor =
        |x: &PrimarySample<E>, y: &PrimarySample<E>, _| if functions(y)[0] > functions(x)[0] { 3.0 } else { 1.0 };
    let wrong = Scaled { mutation: PrimaryMutation::<E>::Large, factor };
    let verdict = drift(&space, estimator, &wrong, n).verdict(1e-4);
    assert!(!verdict.holds, "{name}: the planted fault is not noticed, {verdict:?}");
}

#[test]
fn chains_of_path_tracing_obey_the_laws() {
    for name in ["cornell", "glass"] {
        check(name, &space(name, SIZE, LENGTHS), &PathTracer::new(LENGTHS, ROULETTE), nightly(8_000, 200_000));
    }
}

#[test]
fn chains_of_bidirectional_sampling_obey_the_laws() {
    for name in ["cornell", "glass"] {
        check(
            name,
            &space(name, SIZE, LENGTHS),
            &BidirectionalPathTracer::new(LENGTHS, ROULETTE),
            nightly(8_000, 200_000),
        );
    }
}

#[test]
fn chains_of_multiplexed_sampling_obey_the_laws() {
    for name in ["cornell", "glass", "ring"] {
        let space = space(name, SIZE, LENGTHS);
        // One path a sample: more of them are cheap, and needed.
        check(name, &space, &Multiplexed::new(&space.scene, LENGTHS, 5), nightly(80_000, 2_000_000));
    }
}

#[test]
fn small_steps_keep_the_length_of_a_multiplexed_path_and_change_everything_else() {
    let space = space("cornell", SIZE, LENGTHS);
    let estimator = Multiplexed::new(&space.scene, LENGTHS, 5);
    let space = PrimarySpace { scene: space.scene.clone() };
    let mut rng = stream(3, Purpose::Chain, 2);
    let small = PrimaryMutation::small(1.0 / 1024.0, 1.0 / 64.0);
    let (mut lit, mut moved) = (0, 0);
    let mut lengths = [0; 9];
    for _ in 0..20_000 {
        let Some((x, _)) = draw(&space, &estimator, &mut rng) else { continue };
        let mut y = x.clone();
        assert_eq!(small.propose(&space, &x, &mut y, &mut rng), Ok(()));
        if y.luminance() > 0.0 {
            lit += 1;
            moved += u32::from(x.splats()[0].0 != y.splats()[0].0);
            assert_eq!(x.class().length, y.class().length);
        }
        lengths[x.class().length as usize] += 1;
        assert_ne!(x.class(), PathClass::MANY);
    }
    println!("{lit} lit, {moved} of them at another image point; lengths {lengths:?}");
    assert!(lit > 500 && moved * 10 > lit * 9, "{lit} {moved}");
    assert!(lengths[2..].iter().all(|n| *n > 20), "{lengths:?}");
}
