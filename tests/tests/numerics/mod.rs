//! Cases that break renderers, each with what is guaranteed here: no value that is no number, and an estimate that agrees with
//! the truth, or with an equivalent scene that is easy. `docs/numerics.md` has the table.

mod corners;
mod dielectrics;
mod film;
mod lights;
mod long_paths;
mod perturbations;
mod startup;
mod surfaces;
mod table;
mod units;

use std::ops::RangeInclusive;

use ergodic_pathspace::Scene;
use ergodic_render::{Method, Picture, RouletteSettings, Settings};
use ergodic_scattering::Rgb;
use ergodic_tests::{Estimate, estimate, nightly};

/// Pixels on a side of most pictures; even, for the halves.
const SIDE: u32 = 16;

const REPLICAS: usize = 16;

/// Paths of more edges than this are long: a sample of them takes as much time as many others.
const LONG: usize = 32;

/// Greatest distance of an estimate from the truth, in standard errors. With 16 replicas Student's t is beyond it once in 2000
/// times; there are some 200 comparisons, so that all hold but for a bad seed, and the seed is fixed.
const AGREES: f64 = 4.5;

/// Settings for paths of the given numbers of edges, without roulette and with little seeding, for scenes with long paths.
fn settings(method: Method, edges: &RangeInclusive<usize>, samples_per_pixel: f64) -> Settings {
    let mut settings = ergodic_tests::settings(method, edges, SIDE, samples_per_pixel);
    settings.roulette = RouletteSettings { start: 1000, survival: 1.0 };
    settings.mlt.seeding.max_samples = 30_000;
    settings
}

/// The mean over the whole picture, which for Metropolis light transport is its b, and over its left half, which its chains
/// make.
type Means = [Estimate; 2];

fn mean_over_columns(picture: &Picture, columns: usize) -> Rgb {
    let rows = picture.pixels.chunks(picture.width as usize);
    let sum: Rgb = rows.flat_map(|row| &row[..columns]).sum();
    sum / (columns * picture.height as usize) as f64
}

fn means(scene: &Scene, settings: &Settings) -> Means {
    let width = settings.size.0 as usize;
    estimate(scene, settings, REPLICAS, |picture| [width, width / 2].map(|columns| mean_over_columns(picture, columns)))
        .unwrap_or_else(|e| panic!("{e}"))
}

/// What is known exactly of the two means.
fn exactly(whole: Rgb, half: Rgb) -> Means {
    [whole, half].map(|mean| Estimate { mean, error: 1e-9 * mean })
}

/// Fails unless two pairs of means agree, and the first is better than `relative_error` over the whole picture.
fn assert_agree(what: &str, found: &Means, expected: &Means, relative_error: f64) {
    for ((found, expected), part) in found.iter().zip(expected).zip(["whole", "left half"]) {
        let z = found.z_against(expected);
        println!("{what}, {part}: {:.5} +- {:.5}, expected {:.5}, z = {z:.1}", found.mean, found.error, expected.mean);
        assert!(z < AGREES, "{what}, {part}: {found:?}, expected {expected:?}");
    }
    let reached = found[0].relative_error();
    assert!(reached < relative_error, "{what}: too few samples, {reached}");
}

/// Every method that is given samples against what is expected.
fn check(
    what: &str,
    scene: &Scene,
    edges: RangeInclusive<usize>,
    samples: [f64; 3],
    expected: &Means,
    relative_error: f64,
) {
    let [path, bidirectional, mutations] = samples;
    for (method, name) in Method::ALL {
        let samples = match method {
            Method::Path => path,
            Method::Bidirectional => bidirectional,
            Method::Mlt => mutations,
            Method::Mmlt => 0.5 * mutations,
            // Every mutation is a whole sample of the bidirectional method.
            Method::Pssmlt => 0.25 * mutations,
        };
        if samples == 0.0 {
            continue;
        }
        let mut settings = settings(method, &edges, samples);
        let long = *edges.end() > LONG;
        match method {
            // A sample is one path by one strategy: cheap unless it is long, and b, the mean of many, needs more of them.
            Method::Mmlt if !long => {
                settings.mlt.seeding.max_samples *= nightly(4, 16);
                settings.mlt.seeding.relative_error *= nightly(0.5, 0.25);
            }
            // A sample is all connections of two walks, as many as the square of their lengths.
            Method::Pssmlt if long => settings.mlt.seeding.max_samples /= 16,
            Method::Mlt if long => settings.mlt.seeding.max_samples /= nightly(4, 1),
            _ => {}
        }
        let found = means(scene, &settings);
        assert_agree(&format!("{what}, {name}"), &found, expected, relative_error);
    }
}

/// The mean of a function of the picture's plane over it, and over its left half: the midpoint rule.
fn plane_means(radiance: impl Fn(glam::DVec2) -> Rgb) -> Means {
    const STEPS: u32 = 256;
    let mean = |width: f64| {
        let at = |i: u32, j: u32| glam::DVec2::new(width * (f64::from(i) + 0.5), f64::from(j) + 0.5) / f64::from(STEPS);
        let sum: Rgb = (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| at(i, j))).map(&radiance).sum();
        sum / f64::from(STEPS * STEPS)
    };
    let quadrature = |mean: Rgb| Estimate { mean, error: 1e-5 * mean };
    [quadrature(mean(1.0)), quadrature(mean(0.5))]
}
