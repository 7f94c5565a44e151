//! Media: the phase function and free flight, samplers against densities, with the faults that they must notice.

use std::f64::consts::PI;

use ergodic_scattering::{Component, HenyeyGreenstein, Interaction, Medium, Rgb};
use glam::DVec3;

use crate::support::{Outcome, Random, Rings, chi_square_directions};

const ANISOTROPIES: [f64; 7] = [-0.8, -0.3, 0.0, 1e-9, 0.2, 0.7, 0.95];

fn at(anisotropy: f64) -> Interaction {
    Interaction::in_medium(HenyeyGreenstein { scattering: Rgb::new(0.5, 1.0, 2.0), anisotropy })
}

fn from() -> DVec3 {
    DVec3::new(0.48, -0.36, 0.8)
}

#[test]
fn the_phase_function_is_normalised_and_its_mean_cosine_is_its_parameter() {
    for g in ANISOTROPIES {
        let point = at(g);
        // The midpoint rule in the cosine of the turn; steps crowd where the function is steep.
        let n = 400_000;
        let (mut integral, mut mean) = (0.0, 0.0);
        for i in 0..n {
            let s = (f64::from(i) + 0.5) / f64::from(n);
            // 1 -+ cos = 2 s², so that d cos = 4 s ds.
            let cos = if g >= 0.0 { 1.0 - 2.0 * s * s } else { 2.0 * s * s - 1.0 };
            let side = (1.0 - cos * cos).sqrt();
            let frame = ergodic_geometry::Frame::from_normal(-from());
            let to = frame.n * cos + frame.t * side;
            let weight = 4.0 * s / f64::from(n) * 2.0 * PI;
            integral += weight * point.pdf(from(), to, Component::Rough);
            mean += weight * cos * point.pdf(from(), to, Component::Rough);
        }
        assert!((integral - 1.0).abs() < 1e-6, "g = {g}: {integral}");
        assert!((mean - g).abs() < 1e-6, "g = {g}: {mean}");
    }
}

#[test]
fn the_phase_function_is_reciprocal_and_is_what_is_scattered() {
    let mut random = Random::new(5);
    for g in ANISOTROPIES {
        let point = at(g);
        for _ in 0..1000 {
            let Some((to, component)) = point.sample(from(), random.three()) else { panic!("all is scattered") };
            let there = point.eval(from(), to, component);
            assert_eq!(there, point.eval(to, from(), component));
            let share = Rgb::new(0.5, 1.0, 2.0) * point.pdf(from(), to, component);
            assert!((there - share).length() <= 1e-14 * share.length());
            assert!((to.length() - 1.0).abs() < 1e-14);
        }
    }
}

fn check(sampled: f64, claimed: f64) -> bool {
    let (sampled, claimed) = (at(sampled), at(claimed));
    let mut random = Random::new(3);
    let mut sample = || Outcome::Direction(sampled.sample(from(), random.three()).map_or(DVec3::ZERO, |(w, _)| w));
    let density = |w: DVec3| claimed.pdf(from(), w, Component::Rough);
    // Rings about the direction in which light travels on.
    let rings = Rings::new(-from(), 0.3, 16, 12);
    chi_square_directions(&rings, 200_000, &density, &[], &mut sample).is_ok()
}

#[test]
fn directions_are_sampled_with_the_phase_function() {
    for g in ANISOTROPIES {
        assert!(check(g, g), "g = {g}");
    }
}

#[test]
fn a_wrong_phase_function_is_caught() {
    // The other sign, which is the commonest mistake, and a little more or less.
    for (g, wrong) in [(0.3, -0.3), (0.7, 0.68), (0.0, 0.02)] {
        assert!(!check(g, wrong), "g = {g} passes for {wrong}");
    }
}

/// Chi-square of flights in a medium against a density, given the distance and the transmittance there.
fn flights(medium: &Medium, pdf: &dyn Fn(f64) -> f64) -> (f64, f64) {
    let (cells, n, longest) = (40, 200_000u32, 4.0);
    let mut random = Random::new(11);
    let mut observed = vec![0u64; cells + 1];
    for _ in 0..n {
        let t = medium.sample_flight(random.three()[0]);
        observed[((t / longest * cells as f64) as usize).min(cells)] += 1;
    }
    let steps = 1000;
    let width = longest / cells as f64;
    let mut expected: Vec<f64> = (0..cells)
        .map(|cell| {
            let at = |i: i32| (cell as f64 + (f64::from(i) + 0.5) / f64::from(steps)) * width;
            f64::from(n) * (0..steps).map(|i| pdf(at(i))).sum::<f64>() * width / f64::from(steps)
        })
        .collect();
    let rest = f64::from(n) - expected.iter().sum::<f64>();
    expected.push(rest);
    let statistic = observed.iter().zip(&expected).map(|(o, e)| (*o as f64 - e).powi(2) / e).sum::<f64>();
    // At 40 degrees of freedom, 5 standard deviations beyond the mean: rarer than 1e-5.
    (statistic, 40.0 + 5.0 * 80f64.sqrt())
}

#[test]
fn free_flight_has_its_density() {
    for (scattering, absorption) in [
        (Rgb::new(0.4, 1.0, 3.0), Rgb::new(0.2, 0.0, 0.5)),
        (Rgb::splat(1.0), Rgb::ZERO),
        // A channel without a flight of its own.
        (Rgb::new(0.0, 1.0, 2.0), Rgb::ZERO),
    ] {
        let medium = Medium { scattering, absorption, anisotropy: 0.0 };
        let density = |t: f64| medium.flight_pdf(medium.transmittance(t));
        let (statistic, limit) = flights(&medium, &density);
        println!("chi-square {statistic:.1} of {limit:.1}");
        assert!(statistic < limit, "{scattering} {absorption}: {statistic}");
        // What is left is the probability of no event: the density is minus its derivative.
        let (t, step) = (0.7, 1e-6);
        let survival = |t: f64| medium.flight_survival(medium.transmittance(t));
        let slope = (survival(t - step) - survival(t + step)) / (2.0 * step);
        assert!((slope - density(t)).abs() < 1e-8);
    }
}

#[test]
fn a_transmittance_or_a_channel_forgotten_in_the_density_is_caught() {
    let medium = Medium { scattering: Rgb::new(0.4, 1.0, 3.0), absorption: Rgb::new(0.2, 0.0, 0.5), anisotropy: 0.0 };
    let extinction = medium.extinction();
    let (statistic, limit) = flights(&medium, &|t| extinction.y * medium.transmittance(t).y);
    assert!(statistic > 2.0 * limit);
    let mean = extinction.element_sum() / 3.0;
    let (statistic, limit) = flights(&medium, &|t| mean * (-mean * t).exp());
    assert!(statistic > 2.0 * limit);
}
