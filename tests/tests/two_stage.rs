//! Chains in two stages: the same picture, and dark parts as good as bright ones.

use ergodic_metropolis::diagnostics::Moments;
use ergodic_pathspace::{BrightnessMap, Lengths, Roulette, Scene};
use ergodic_render::{Direct, Method, Seeding, Seeds, Settings, Unobserved, render};
use ergodic_scattering::luminance;
use ergodic_tests::{description, nightly, view_of};
use glam::DVec2;

use crate::rendering::{LIMIT, settings};

const SIDE: u32 = 32;
const REPLICAS: u64 = 16;

/// For each replica the luminances of all pixels of indirect light.
fn replicas(scene: &Scene, method: Method, (two_stage, first): (bool, u64), samples: f64) -> Vec<Vec<f64>> {
    let mut settings = settings(method, (SIDE, SIDE), samples);
    settings.mlt.two_stage = two_stage;
    settings.mlt.direct = Direct::InChain;
    settings.mlt.seeding.max_samples = 4000;
    settings.min_edges = 3;
    let one = |seed| {
        let rendering = render(scene, &Settings { seed, ..settings.clone() }, &Unobserved).expect("valid settings");
        rendering.picture.pixels.into_iter().map(luminance).collect()
    };
    (first..first + REPLICAS).map(one).collect()
}

/// The centre of a pixel.
fn centre(i: usize) -> DVec2 {
    DVec2::new((i as u32 % SIDE) as f64 + 0.5, (i as u32 / SIDE) as f64 + 0.5)
}

/// What is known of each pixel.
fn moments(replicas: &[Vec<f64>]) -> Vec<Moments> {
    (0..replicas[0].len()).map(|i| replicas.iter().map(|replica| replica[i]).collect()).collect()
}

/// The pixels in order of their brightness in a picture.
fn by_brightness(picture: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..picture.len()).collect();
    order.sort_by(|a, b| picture[*a].total_cmp(&picture[*b]));
    order
}

/// The largest |t| of two sets of replicas over eight groups of pixels, from the darkest to the brightest.
fn disagreement(order: &[usize], a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let of = |pixels: &[usize], replicas: &[Vec<f64>]| -> Moments {
        replicas.iter().map(|replica| pixels.iter().map(|i| replica[*i]).sum::<f64>()).collect()
    };
    let t = |pixels| {
        let (a, b) = (of(pixels, a), of(pixels, b));
        (a.mean() - b.mean()).abs() / a.standard_error().hypot(b.standard_error())
    };
    order.chunks(order.len() / 8).map(t).fold(0.0, f64::max)
}

#[test]
fn the_picture_is_that_of_one_stage_and_of_bidirectional_path_tracing() {
    let samples = nightly(25.0, 400.0);
    for name in ["ajar", "cornell"] {
        let scene = view_of(description(name), (SIDE, SIDE));
        let known = replicas(&scene, Method::Bidirectional, (false, 0), samples);
        let picture: Vec<f64> = moments(&known).iter().map(Moments::mean).collect();
        let order = by_brightness(&picture);
        let size = DVec2::splat(f64::from(SIDE));
        let map = BrightnessMap::new(size, (SIDE as usize, SIDE as usize), &picture).expect("there is light");
        for method in [Method::Mlt, Method::Pssmlt, Method::Mmlt] {
            let found = replicas(&scene, method, (true, 100), samples);
            // What a visit adds, without the brightness that the target was divided by.
            let not_multiplied: Vec<Vec<f64>> = found
                .iter()
                .map(|replica| replica.iter().enumerate().map(|(i, value)| value / map.at(centre(i))).collect())
                .collect();
            let (right, wrong) = (disagreement(&order, &known, &found), disagreement(&order, &known, &not_multiplied));
            println!("{name}, {method:?}: max |t| {right:.1}; without the brightness {wrong:.1}");
            assert!(right < LIMIT && wrong > LIMIT, "{name}, {method:?}: {right} {wrong}");
        }
    }
}

#[test]
fn dark_parts_get_better() {
    let scene = view_of(description("ajar"), (SIDE, SIDE));
    let of = |two_stage, first| moments(&replicas(&scene, Method::Mlt, (two_stage, first), nightly(100.0, 800.0)));
    let (one, again, two) = (of(false, 0), of(false, 100), of(true, 200));
    let picture: Vec<f64> = one.iter().zip(&again).map(|(a, b)| a.mean() + b.mean()).collect();
    let order = by_brightness(&picture);
    let dark = &order[..order.len() / 2];
    // The middle one of the variances: few pixels have fireflies, and would decide all.
    let variance = |moments: &[Moments]| {
        let mut variances: Vec<f64> = dark.iter().map(|i| moments[*i].variance() / picture[*i].powi(2)).collect();
        variances.sort_by(f64::total_cmp);
        variances[variances.len() / 2]
    };
    let (gain, none) = (variance(&one) / variance(&two), variance(&one) / variance(&again));
    println!("variance of dark pixels: {gain:.2} times less with two stages, {none:.2} with other seeds only");
    let better = |gain: f64| gain > 1.3;
    assert!(better(gain) && !better(none), "{gain} {none}");
}

#[test]
fn the_integral_of_the_target_is_that_of_luminance_over_brightness() {
    let scene = view_of(description("cornell"), (SIDE, SIDE));
    let lengths = Lengths { min_edges: 2, max_edges: 6 };
    let (roulette, effort) = (Roulette::OFF, Seeding { relative_error: 0.005, max_samples: 200_000 });
    let draw = |map| Seeds::draw_for(&scene, map, (lengths, roulette), &effort, 3, &Unobserved);
    let plain = draw(None);
    assert_eq!(plain.b.to_bits(), plain.target.to_bits());
    // The right half counts 1.5 / 0.5 times as bright as the left one, with a ramp between them.
    let map = BrightnessMap::new(DVec2::splat(f64::from(SIDE)), (2, 1), &[0.0, 1.0]);
    let halves = draw(map.as_ref());
    let settings = Settings { max_edges: 6, min_edges: 2, ..settings(Method::Bidirectional, (SIDE, SIDE), 64.0) };
    let picture = render(&scene, &settings, &Unobserved).unwrap().picture;
    let map = map.expect("there is light");
    let value = |(i, pixel)| luminance(pixel) / map.at(centre(i));
    let pixels = picture.pixels.len() as f64;
    let expected = picture.pixels.iter().copied().enumerate().map(value).sum::<f64>() / pixels;
    println!("b {:.5}, target {:.5}, from the picture {expected:.5}", halves.b, halves.target);
    let agrees = |target: f64| (target / expected - 1.0).abs() < 0.03;
    assert!(agrees(halves.target) && !agrees(halves.b), "{} {} {expected}", halves.target, halves.b);
    assert!((halves.b / plain.b - 1.0).abs() < 0.03);
}
