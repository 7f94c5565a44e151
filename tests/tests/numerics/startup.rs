//! Chains: where they start, what they share, and whether it is told when they cannot move.

use ergodic_assess::{Image, Reference, Verdict, test_replicas};
use ergodic_metropolis::Mixture;
use ergodic_mutations::{AnyMutation, MultiChain};
use ergodic_pathspace::{Lengths, Path, PathSpace};
use ergodic_render::{
    Budget, ChainRunner, Film, Ledger, Life, Method, Purpose, SplatBuffer, Unobserved, render, render_replicas,
    render_with_mixture, statistics::MutationStatistics, stream,
};
use ergodic_scattering::Filter;
use ergodic_tests::{PathSource, description, image, nightly, root, space, view_of};

use super::settings;
use crate::mutation_laws::{members, mixture};

#[test]
fn ten_mutations_in_each_of_many_chains_are_unbiased() {
    let reference = Reference::read(&root().join("reference/cornell.exr")).unwrap_or_else(|e| panic!("{e}"));
    let size = (reference.mean.width, reference.mean.height);
    let scene = view_of(description("cornell"), size);
    let mut settings = settings(Method::Mlt, &(1..=16), 0.0);
    settings.size = size;
    settings.mlt.chains = nightly(4_000, 100_000);
    settings.budget = Budget::SamplesPerPixel(10.0 * settings.mlt.chains as f64 / f64::from(size.0 * size.1));
    // More samples than chains, so that few start at the same path.
    settings.mlt.seeding.relative_error = 1e-6;
    settings.mlt.seeding.max_samples = 4 * settings.mlt.chains as u64;
    let all = settings.mlt.chains;
    // All at once, or one after the other as chains that begin anew.
    for (chains, life) in [(all, Life::Endless), (all / 4, Life::Mutations(10))] {
        (settings.mlt.chains, settings.mlt.life) = (chains, life);
        let renderings = render_replicas(&scene, &settings, 48, &Unobserved).expect("valid settings");
        let images: Vec<Image> = renderings.iter().map(|r| image(&r.picture)).collect();
        let mut too_bright = images.clone();
        too_bright.iter_mut().flat_map(|image| &mut image.pixels).flatten().for_each(|value| *value *= 1.1);
        let mutations = renderings[0].mlt.as_ref().map_or(0, |report| report.mutations);
        assert_eq!(mutations, 10 * all as u64);
        let right = test_replicas(&images, &reference).unwrap_or_else(|e| panic!("{e}"));
        println!(
            "10 mutations a start, {chains} chains: p of the largest block {:.2}, of exceedances {:.2}, of the total {:.2}",
            right.p_largest, right.exceedances.1, right.total.2
        );
        assert_eq!(right.verdict(1e-4), Verdict::Holds);
        let wrong = test_replicas(&too_bright, &reference).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(wrong.verdict(1e-4), Verdict::Fails);
    }
}

fn some_path(space: &PathSpace) -> Path {
    let mut path = Path::default();
    let mut source = PathSource::new(space);
    let mut rng = stream(1, Purpose::Starts, 0);
    while source.draw(&mut path, &mut rng).is_none() {}
    path
}

fn ledger(space: &PathSpace, members: usize) -> Ledger {
    Ledger {
        splats: SplatBuffer::new(),
        mutations: (0..members).map(|_| MutationStatistics::new("", space.lengths.max_edges)).collect(),
        faults: Vec::new(),
        none_suitable: 0,
        visits: None,
    }
}

#[test]
fn a_chain_run_in_parts_is_the_chain_run_at_once() {
    let space = space("glass", (32, 32), Lengths { min_edges: 1, max_edges: 8 });
    let (mixture, path) = (mixture(members()), some_path(&space));
    let run = |parts: &[u64]| {
        let mut runner = ChainRunner::new(0, path.clone(), stream(7, Purpose::Chain, 0));
        let mut ledger = ledger(&space, mixture.members().len());
        parts.iter().for_each(|steps| runner.run(*steps, &mixture, &space, &mut ledger));
        let at: Vec<_> = runner.path().vertices.iter().map(|v| v.position.to_array()).collect();
        let mut film = Film::new(32, 32, Filter::Box);
        film.merge(&mut [&mut ledger.splats]);
        (at, film.develop(1.0), ledger.mutations.iter().map(|m| m.total().accepted).collect::<Vec<_>>())
    };
    let (at, film, accepted) = run(&[30_000]);
    for parts in [&[15_000, 15_000][..], &[1, 29_998, 1], &[10_000; 3]] {
        let (at_parts, film_parts, accepted_parts) = run(parts);
        assert_eq!((&at_parts, &accepted_parts), (&at, &accepted));
        // Weight that a path has gathered is put down at the end of a part, so sums round another way.
        let worst =
            film.pixels.iter().zip(&film_parts.pixels).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f64::max);
        println!("{parts:?}: films differ by {worst:.1e}");
        assert!(worst < 1e-9, "{worst}");
    }
    assert!(accepted.iter().sum::<u64>() > 10_000 && film.mean().x > 0.0);
}

#[test]
fn chains_of_different_number_are_uncorrelated() {
    // From one and the same path, so that only their random numbers tell them apart.
    let space = space("cornell", (32, 32), Lengths { min_edges: 2, max_edges: 4 });
    let (mixture, path) = (mixture(members()), some_path(&space));
    let (chains, times, every) = (64u64, nightly(128, 2048), 256);
    let series: Vec<Vec<f64>> = (0..chains)
        .map(|index| {
            let mut runner = ChainRunner::new(index, path.clone(), stream(7, Purpose::Chain, index));
            let mut at = || {
                for _ in 0..every {
                    runner.step(&mixture, &space);
                }
                runner.path().raster.map_or(0.0, |r| r.x)
            };
            at();
            (0..times).map(|_| at()).collect()
        })
        .collect();
    let standardised: Vec<Vec<f64>> = series
        .iter()
        .map(|s| {
            let mean = s.iter().sum::<f64>() / s.len() as f64;
            let norm = s.iter().map(|x| (x - mean).powi(2)).sum::<f64>().sqrt();
            s.iter().map(|x| (x - mean) / norm).collect()
        })
        .collect();
    let correlation =
        |a: usize, b: usize| -> f64 { standardised[a].iter().zip(&standardised[b]).map(|(a, b)| a * b).sum() };
    let (mut worst, mut squares, mut pairs) = (0.0f64, 0.0, 0);
    for a in 0..chains as usize {
        for b in 0..a {
            let r = correlation(a, b);
            worst = worst.max(r.abs());
            squares += r * r;
            pairs += 1;
        }
    }
    let mean_square = squares / f64::from(pairs) * times as f64;
    println!("{pairs} pairs of chains: largest |r| {worst:.2}, mean of n r² {mean_square:.3}");
    // 1 for independent series; what is left of their own correlation makes it a little more.
    assert!(worst < 5.5 / (times as f64).sqrt(), "{worst}");
    assert!(mean_square < 1.3, "{mean_square}");
    // The measure can fail: two chains with the same stream.
    assert!((correlation(3, 3) - 1.0).abs() < 1e-9);
}

#[test]
fn a_chain_that_cannot_move_is_reported() {
    let scene = view_of(description("cornell"), (32, 32));
    let mut settings = settings(Method::Mlt, &(1..=6), 64.0);
    settings.size = (32, 32);
    let full = render(&scene, &settings, &Unobserved).expect("valid settings").mlt.expect("this is mlt").mixing;
    assert_eq!(full.stuck_chains, 0, "{:?}", full.warnings);
    // Nothing in the room has two chains of mirrors, so nothing can move.
    let mixture = Mixture::new(vec![(1.0, AnyMutation::MultiChain(MultiChain::default()))]).expect("positive weight");
    let rendering = render_with_mixture(&scene, &settings, &mixture, &["multi_chain"], &Unobserved);
    let report = rendering.expect("valid settings").mlt.expect("this is mlt").mixing;
    println!("{:?}", report.warnings);
    assert_eq!(report.stuck_chains, settings.mlt.chains);
    assert!(report.warnings.iter().any(|w| w.contains("stayed") && w.contains(" L")), "{:?}", report.warnings);
}

#[test]
fn two_rooms_and_a_door_are_the_reference_and_the_longest_stay_is_told() {
    let reference = Reference::read(&root().join("reference/ajar.exr")).unwrap_or_else(|e| panic!("{e}"));
    let size = (reference.mean.width, reference.mean.height);
    let scene = view_of(description("ajar"), size);
    let mut settings = settings(Method::Mlt, &(1..=16), 32.0);
    settings.size = size;
    let renderings = render_replicas(&scene, &settings, nightly(16, 32), &Unobserved).expect("valid settings");
    let longest = renderings.iter().filter_map(|r| r.mlt.as_ref()?.mixing.longest_stay).max_by_key(|stay| stay.steps);
    let images: Vec<Image> = renderings.iter().map(|r| image(&r.picture)).collect();
    let test = test_replicas(&images, &reference).unwrap_or_else(|e| panic!("{e}"));
    println!(
        "longest stay {longest:?}; p of the largest block {:.2}, of exceedances {:.2}, of the total {:.2}",
        test.p_largest, test.exceedances.1, test.total.2
    );
    assert!(longest.is_some_and(|stay| stay.steps > 0));
    assert_ne!(test.verdict(1e-4), Verdict::Fails);
}
