//! The laws of chains in primary sample space, on real scenes, with every sampler; and planted faults that break them.

use ergodic_laws::faults::Scaled;
use ergodic_laws::{Invariance, detailed_balance, one_step_invariance, way_back};
use ergodic_metropolis::diagnostics::Moments;
use ergodic_metropolis::{Mixture, Mutation};
use ergodic_pathspace::{PathClass, PathSpace, Roulette};
use ergodic_render::{
    BidirectionalPathTracer, Estimator, Multiplexed, PathTracer, PrimaryMutation, PrimarySample, PrimarySpace,
    PrimaryTarget, Purpose, Seedable, stream,
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

/// Weighted means of functions of single samples, and of the seeds that multiplexed sampling chooses among all strategies, are the same;
/// and seeds vary less.
#[test]
fn multiplexed_seeds_have_the_density_of_the_target() {
    for name in ["cornell", "glass"] {
        let space = space(name, SIZE, LENGTHS);
        let estimator = Multiplexed::new(&space.scene, LENGTHS, 1);
        let target = PrimaryTarget::default();
        let (mut single, mut seed) = (PrimarySample::new(estimator.clone()), PrimarySample::new(estimator));
        let new = || vec![Moments::new(); 7];
        let (mut plain, mut seeds, mut wrong) = (new(), new(), new());
        let add = |all: &mut Vec<Moments>, weight: f64, x: &PrimarySample<Multiplexed>| {
            let values = if weight > 0.0 { functions(x) } else { [0.0; 6] };
            all[0].add(weight);
            all[1..].iter_mut().zip(values).for_each(|(moments, value)| moments.add(weight * value));
        };
        for index in 0..nightly(40_000, 1_000_000) {
            single.draw(&space.scene, &mut stream(5, Purpose::Seeding, index));
            add(&mut plain, single.luminance(), &single);
            let found = Seedable::seed(&mut seed, &space.scene, &target, &mut stream(6, Purpose::Seeding, index));
            assert_eq!(found.luminance, found.weight, "without a map of brightness both are the same");
            assert!(found.weight == 0.0 || seed.luminance() > 0.0, "{name}: seed {index} carries nothing");
            add(&mut seeds, found.weight, &seed);
            // The light of the strategy that was chosen, in the place of that of all.
            add(&mut wrong, if found.weight > 0.0 { seed.luminance() } else { 0.0 }, &seed);
        }
        let t = |others: &[Moments]| {
            let of = |(a, b): (&Moments, &Moments)| {
                (a.mean() - b.mean()).abs() / a.standard_error().hypot(b.standard_error()).max(f64::MIN_POSITIVE)
            };
            plain.iter().zip(others).map(of).fold(0.0, f64::max)
        };
        let (right, wrong) = (t(&seeds), t(&wrong));
        let gain = plain[0].variance() / seeds[0].variance();
        println!("{name}: max |t| {right:.1}, with the wrong weight {wrong:.1}; {gain:.1} times less variance of b");
        // 14 comparisons, two-sided 1e-4 by Sidak: 4.5.
        assert!(right < 4.5 && wrong > 4.5 && gain > 1.5, "{name}: {right} {wrong} {gain}");
    }
}
