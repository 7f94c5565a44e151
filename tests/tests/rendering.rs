//! Whole renders: the same bytes on any number of threads, faults that can be seen again, methods that agree.

use ergodic_geometry::Isa;
use ergodic_laws::faults::Scaled;
use ergodic_metropolis::diagnostics::Moments;
use ergodic_metropolis::{Fault, Mixture, Step};
use ergodic_mutations::{AnyMutation, Splice};
use ergodic_pathspace::{Path, Scene, SceneDescription, View};
use ergodic_render::{
    Budget, Direct, FilterSettings, Life, Method, MltReport, PrimarySampler, Replayed, Settings, Unobserved, render,
    render_with_mixture, replay,
};
use ergodic_scattering::luminance;
use ergodic_tests::{description, layered_room, nightly, view_of};

pub(crate) fn settings(method: Method, size: (u32, u32), samples: f64) -> Settings {
    let mut settings = Settings { method, size, budget: Budget::SamplesPerPixel(samples), ..Settings::default() };
    settings.mlt.chains = 64;
    settings.mlt.seeding.relative_error = 0.02;
    settings
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    for (name, filter) in
        [("cornell", FilterSettings::Box), ("glass", FilterSettings::Gaussian { radius: 1.5, sigma: 0.5 })]
    {
        let scene = view_of(description(name), (24, 16));
        for (method, _) in Method::ALL {
            let picture = |threads, seed| {
                let mut settings = Settings { threads, seed, filter, ..settings(method, (24, 16), 20.0) };
                // Chains begin anew twice.
                settings.mlt.life = Life::Mutations(50);
                render(&scene, &settings, &Unobserved).unwrap().picture
            };
            let one = picture(1, 1);
            assert_eq!(one, picture(2, 1), "{name} {method:?}");
            assert_eq!(one, picture(8, 1), "{name} {method:?}");
            assert_ne!(one, picture(1, 2), "{name} {method:?}: the seed changes nothing");
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_with_any_instructions() {
    let size = (24, 16);
    for name in ["cornell", "glass"] {
        let description = description(name);
        let view =
            View { camera: description.cameras[0].clone(), width: size.0, height: size.1, margin: 0.0, crop: None };
        let picture = |isa: Isa, seed| {
            let scene = Scene::searched_with(Some(isa), description.clone(), &view).unwrap();
            let rendering = render(&scene, &Settings { seed, ..settings(Method::Mlt, size, 200.0) }, &Unobserved);
            let rendering = rendering.unwrap();
            assert_eq!(rendering.instructions, isa.name());
            rendering.picture
        };
        let all = Isa::available();
        let plain = picture(all[0], 1);
        for isa in &all[1..] {
            assert_eq!(plain, picture(*isa, 1), "{name} {}", isa.name());
        }
        assert_ne!(plain, picture(all[0], 2), "{name}: the seed changes nothing");
    }
}

#[test]
fn many_merges_on_64_threads_give_the_bytes_of_one_thread() {
    let size = (64, 48);
    let scene = view_of(description("glass"), size);
    let filter = FilterSettings::Gaussian { radius: 2.0, sigma: 0.5 };
    // So many mutations that every buffer is full several times over.
    let mut settings = Settings { filter, ..settings(Method::Mlt, size, nightly(400.0, 4000.0)) };
    settings.mlt.layers = true;
    settings.mlt.direct = Direct::Separate { samples_per_pixel: 64 };
    let rendering = |threads, seed| {
        let rendering = render(&scene, &Settings { threads, seed, ..settings.clone() }, &Unobserved).unwrap();
        assert_eq!(rendering.threads, threads);
        (rendering.picture, rendering.mlt.and_then(|report| report.layers).expect("layers are asked for"))
    };
    let one = rendering(1, 1);
    for threads in [2, 8, 64] {
        assert!(rendering(threads, 1) == one, "{threads} threads");
    }
    assert!(rendering(64, 2) != one, "the seed changes nothing");
}

#[test]
fn the_standard_error_of_pixels_is_the_spread_of_replicas() {
    let size = (16, 16);
    let scene = view_of(description("cornell"), size);
    let samples = nightly(3200.0, 32_000.0);
    let rendering = |seed, samples| {
        let mut settings = Settings { seed, ..settings(Method::Mlt, size, samples) };
        settings.mlt.layers = true;
        settings.mlt.direct = Direct::InChain;
        let rendering = render(&scene, &settings, &Unobserved).unwrap();
        (rendering.picture, rendering.mlt.expect("this is mlt"))
    };
    // Relative to b, because the layer leaves out the error of b.
    let told = |report: &MltReport| {
        let layers = report.layers.as_ref().expect("layers are asked for");
        layers.standard_error.iter().map(|error| (error / report.b).powi(2)).sum::<f64>()
    };
    let mut values = vec![Moments::new(); 16 * 16];
    let (mut right, mut wrong) = (Moments::new(), Moments::new());
    for seed in 0..16 {
        let (picture, report) = rendering(seed, samples);
        values.iter_mut().zip(&picture.pixels).for_each(|(value, pixel)| value.add(luminance(*pixel) / report.b));
        right.add(told(&report));
        if seed < 4 {
            wrong.add(told(&rendering(100 + seed, samples / 2.0).1));
        }
        let longest = report.layers.unwrap().longest_stay.into_iter().fold(0.0, f64::max);
        assert!(report.mixing.longest_stay.is_some_and(|stay| stay.steps as f64 == longest), "{longest}");
    }
    let found: f64 = values.iter().map(Moments::variance).sum();
    println!(
        "sum of variances: {found:.3} over replicas; told {:.3}; of half as long chains {:.3}",
        right.mean(),
        wrong.mean()
    );
    // 256 pixels with 15 degrees of freedom each, not all independent.
    let agrees = |told: f64| (0.75..1.33).contains(&(told / found));
    assert!(agrees(right.mean()) && !agrees(wrong.mean()));
}

#[test]
fn a_density_that_is_no_number_is_rejected_counted_and_replayed() {
    let scene = view_of(description("cornell"), (24, 24));
    let mut settings = settings(Method::Mlt, (24, 24), 50.0);
    // Some faults are of chains that began anew.
    settings.mlt.life = Life::Mutations(100);
    // No number on paths of four edges whose second vertex is high up.
    let factor = |_: &Path, to: &Path, _: Splice| {
        if to.length() == 4 && to.vertices[1].position.y > 0.3 { f64::NAN } else { 1.0 }
    };
    let members = AnyMutation::all().into_iter().map(|mutation| (1.0, Scaled { mutation, factor })).collect();
    let mixture = Mixture::new(members).unwrap();
    let names: Vec<_> = AnyMutation::all().iter().map(AnyMutation::name).collect();
    let rendering = render_with_mixture(&scene, &settings, &mixture, &names, &Unobserved).unwrap();
    assert!(rendering.picture.pixels.iter().all(|p| p.is_finite()));
    let report = rendering.mlt.unwrap();
    let counted: u64 = report.statistics.iter().flat_map(|s| s.total().faulty).sum();
    assert!(counted > 100, "{counted}");
    assert!(!report.faults.is_empty());
    let chains = settings.mlt.chains as u64;
    let (first, later): (Vec<_>, Vec<_>) = report.faults.iter().partition(|record| record.chain < chains);
    assert!(first.len() >= 3 && later.len() >= 3, "{} and {}", first.len(), later.len());
    for record in first.into_iter().take(3).chain(later.into_iter().take(3)) {
        assert!(matches!(record.fault, Fault::Forward | Fault::Backward));
        let Replayed { before, step, .. } = replay(&scene, &settings, &mixture, record).unwrap();
        assert_eq!(before.steps(), record.step);
        assert_eq!(before.path().class(), record.class);
        assert!(matches!(step, Step::Faulty { plan: (m, _), fault } if m == record.mutation && fault == record.fault));
    }
    // The same mixture without the fault reports none.
    let whole = Mixture::new(AnyMutation::all().into_iter().map(|m| (1.0, m)).collect()).unwrap();
    let rendering = render_with_mixture(&scene, &settings, &whole, &names, &Unobserved).unwrap();
    assert!(rendering.mlt.unwrap().faults.is_empty());
}

/// Mean luminance of the blocks of a picture, 4 x 4 of them.
fn blocks(scene: &Scene, settings: &Settings) -> Vec<f64> {
    let picture = render(scene, settings, &Unobserved).expect("valid settings").picture;
    let (width, height) = (picture.width as usize, picture.height as usize);
    let mut sums = vec![0.0; 17];
    for (i, pixel) in picture.pixels.iter().enumerate() {
        let (x, y) = (i % width, i / width);
        sums[y * 4 / height * 4 + x * 4 / width] += luminance(*pixel) * 16.0 / (width * height) as f64;
        sums[16] += luminance(*pixel) / (width * height) as f64;
    }
    sums
}

/// Mean and squared standard error of each block over replicas.
pub(crate) fn replicate(scene: &Scene, settings: &Settings, replicas: u64) -> Vec<(f64, f64)> {
    let runs: Vec<Vec<f64>> =
        (0..replicas).map(|seed| blocks(scene, &Settings { seed: 100 + seed, ..settings.clone() })).collect();
    let n = replicas as f64;
    (0..runs[0].len())
        .map(|i| {
            let mean = runs.iter().map(|run| run[i]).sum::<f64>() / n;
            let variance = runs.iter().map(|run| (run[i] - mean).powi(2)).sum::<f64>() / (n - 1.0);
            (mean, variance / n)
        })
        .collect()
}

/// A block dimmer than this share of the picture's mean is judged as a part of the whole only: light that one method finds now and then
/// another may have found in no replica, which leaves no error to judge by.
const DIM: f64 = 0.01;

/// The largest |t| over blocks of two sets of replicas, the last of which is the whole picture.
pub(crate) fn disagreement(a: &[(f64, f64)], b: &[(f64, f64)]) -> f64 {
    let whole = a.last().map_or(0.0, |(mean, _)| *mean);
    a.iter()
        .zip(b)
        .filter(|((ma, va), (mb, vb))| va + vb > 0.0 && ma.max(*mb) >= DIM * whole)
        .map(|((ma, va), (mb, vb))| (ma - mb).abs() / (va + vb).sqrt())
        .fold(0.0, f64::max)
}

pub(crate) const REPLICAS: u64 = 12;

/// Two-sided 1e-4 over 6 scenes x 6 lengths x 17 blocks for Student's t with about 2 (12 - 1) degrees of freedom, by
/// Sidak: 8.0. A few blocks that hold a handful of fireflies have fewer effective degrees of freedom; none does here.
pub(crate) const LIMIT: f64 = 8.0;

fn check_agreement(name: &str) {
    check_chains(name, &view_of(description(name), (32, 32)));
}

/// Path tracing, bidirectional path tracing and Metropolis light transport make the same picture.
pub(crate) fn check_methods(name: &str, scene: &Scene) {
    let size = (32, 32);
    let path = replicate(scene, &settings(Method::Path, size, nightly(48.0, 384.0)), REPLICAS);
    let bidirectional = replicate(scene, &settings(Method::Bidirectional, size, nightly(24.0, 192.0)), REPLICAS);
    let t = disagreement(&path, &bidirectional);
    println!("{name}: path {:.5}, bidirectional {:.5}, max |t| {t:.1}", path[16].0, bidirectional[16].0);
    assert!(t < LIMIT, "{name}: {t}");
    check_chains(name, scene);
}

/// Chains of primary samples of all kinds make the picture of bidirectional path tracing; what is a fifth brighter is told apart.
pub(crate) fn check_primary(name: &str, scene: &Scene, size: (u32, u32)) {
    let pixels = f64::from(size.0 * size.1);
    let of = |method, sampler, samples| {
        let mut settings = Settings { min_edges: 1, max_edges: 6, ..settings(method, size, samples / pixels) };
        settings.primary.sampler = sampler;
        settings.mlt.direct = Direct::InChain;
        settings.mlt.seeding.max_samples = 8000;
        replicate(scene, &settings, REPLICAS)
    };
    let samples = nightly(8000.0, 200_000.0);
    let bidirectional = of(Method::Bidirectional, PrimarySampler::Bidirectional, samples);
    let brighter: Vec<_> = bidirectional.iter().map(|(mean, variance)| (1.2 * mean, *variance)).collect();
    for (method, sampler, more) in [
        (Method::Pssmlt, PrimarySampler::Path, 2.0),
        (Method::Pssmlt, PrimarySampler::Bidirectional, 1.0),
        (Method::Mmlt, PrimarySampler::Bidirectional, 4.0),
    ] {
        let found = of(method, sampler, more * samples);
        let (t, wrong) = (disagreement(&bidirectional, &found), disagreement(&brighter, &found));
        println!("{name}: {method:?} over {sampler:?}, max |t| {t:.1}, against a fifth more {wrong:.1}");
        assert!(t < LIMIT, "{name}: {method:?} over {sampler:?}, {t}");
        assert!(wrong > LIMIT, "{name}: {method:?} over {sampler:?}, a fifth more passes, {wrong}");
    }
}

fn check_chains(name: &str, scene: &Scene) {
    let size = (32, 32);
    let single = nightly(&[2, 3, 5][..], &[2, 3, 4, 5, 6]);
    for (min_edges, max_edges) in std::iter::once((1, 8)).chain(single.iter().map(|edges| (*edges, *edges))) {
        let lengths = |mut s: Settings| {
            s.min_edges = min_edges;
            s.max_edges = max_edges;
            s.mlt.direct = Direct::InChain;
            s.mlt.seeding.relative_error = 0.01;
            // The error of b is the same in all blocks of a replica; replicas bring it down.
            s.mlt.seeding.max_samples = nightly(25_000, 400_000);
            s
        };
        let samples = nightly(24.0, 192.0);
        let bidirectional = replicate(scene, &lengths(settings(Method::Bidirectional, size, samples)), REPLICAS);
        let mlt = replicate(scene, &lengths(settings(Method::Mlt, size, 6.0 * samples)), REPLICAS);
        let t = disagreement(&bidirectional, &mlt);
        println!(
            "{name} {min_edges}..{max_edges}: bidirectional {:.5}, mlt {:.5}, max |t| {t:.1}",
            bidirectional[16].0, mlt[16].0
        );
        assert!(t < LIMIT, "{name}, {min_edges} to {max_edges} edges: {t}\n{bidirectional:?}\n{mlt:?}");
    }
}

#[test]
fn bidirectional_and_mlt_agree_on_cornell() {
    check_agreement("cornell");
}

#[test]
fn bidirectional_and_mlt_agree_on_ajar() {
    check_agreement("ajar");
}

#[test]
fn bidirectional_and_mlt_agree_on_ring() {
    check_agreement("ring");
}

#[test]
fn bidirectional_and_mlt_agree_on_glass() {
    check_agreement("glass");
}

#[test]
fn bidirectional_and_mlt_agree_on_dusk() {
    check_agreement("dusk");
}

#[test]
fn bidirectional_and_mlt_agree_on_pool() {
    check_agreement("pool");
}

#[test]
fn bidirectional_and_mlt_agree_on_layered_materials() {
    check_chains("layered", &view_of(layered_room(), (32, 32)));
}

/// The comparison can fail: a picture 3 % too bright is told apart.
#[test]
fn a_picture_that_is_too_bright_is_told_apart() {
    let size = (32, 32);
    let scene = view_of(description("cornell"), size);
    let bidirectional = replicate(&scene, &settings(Method::Bidirectional, size, 24.0), REPLICAS);
    let too_bright: Vec<_> = replicate(&scene, &settings(Method::Path, size, 24.0), REPLICAS)
        .into_iter()
        .map(|(mean, variance)| (1.03 * mean, variance))
        .collect();
    assert!(disagreement(&bidirectional, &too_bright) > LIMIT);
}

#[test]
fn path_and_bidirectional_agree_on_cornell() {
    path_and_bidirectional_agree(description("cornell"));
}

#[test]
fn path_and_bidirectional_agree_on_layered_materials() {
    path_and_bidirectional_agree(layered_room());
}

fn path_and_bidirectional_agree(description: SceneDescription) {
    let size = (32, 32);
    let scene = view_of(description, size);
    let path = replicate(&scene, &settings(Method::Path, size, 64.0), REPLICAS);
    let bidirectional = replicate(&scene, &settings(Method::Bidirectional, size, 32.0), REPLICAS);
    let t = disagreement(&path, &bidirectional);
    assert!(t < LIMIT, "{t}");
}
