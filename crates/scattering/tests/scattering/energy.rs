//! Energy: furnaces, samples against quadrature, and the passage from rough to smooth.

use ergodic_scattering::{Component, Interaction, Material, Rgb};
use glam::DVec3;

use crate::support::{Kind, Random, Rings, inclined};

/// Mean and standard error of the share of power, channel x, that scatters when light comes from `from`.
fn albedo_by_sampling(at: &Interaction, from: DVec3, samples: u32, seed: u64) -> (f64, f64) {
    let mut random = Random::new(seed);
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..samples {
        let weight = at.sample(from, random.three()).map_or(0.0, |(to, component)| {
            at.eval(from, to, component).x * to.dot(at.ng).abs() / at.pdf(from, to, component)
        });
        sum += weight;
        squares += weight * weight;
    }
    let n = f64::from(samples);
    let mean = sum / n;
    (mean, ((squares / n - mean * mean).max(0.0) / n).sqrt())
}

fn white(kind: Kind, alpha: f64) -> Interaction {
    let material = Material { base_color: Rgb::ONE, ..kind.material(alpha) };
    material.interaction(&[], &crate::support::surface(DVec3::Z))
}

#[test]
fn white_lambert_conserves_energy() {
    for cos in [1.0, 0.3, 1e-3] {
        let (mean, _) = albedo_by_sampling(&white(Kind::Lambert, 1.0), inclined(cos, 0.0), 1000, 1);
        assert!((mean - 1.0).abs() < 1e-12);
    }
}

#[test]
fn smooth_surfaces_reflect_and_transmit_all() {
    for kind in [Kind::Glass, Kind::Thin, Kind::Bubble, Kind::Invisible] {
        let at = white(kind, 0.0);
        for i in -2000..=2000 {
            let from = inclined(f64::from(i) / 2000.0, 0.3);
            let mut sum = 0.0;
            for component in [Component::DiracReflection, Component::DiracTransmission] {
                if let Some(to) = at.dirac_direction(from, component) {
                    sum += at.eval(from, to, component).x / at.dirac_density(to, component) * to.z.abs();
                }
            }
            assert!(i == 0 || (sum - 1.0).abs() < 1e-6, "{kind:?} {i}: {sum}");
        }
    }
}

#[test]
fn near_total_internal_reflection_nothing_is_lost() {
    let at = white(Kind::Glass, 0.0);
    let critical = (1.0_f64 - 1.0 / 2.25).sqrt();
    for exponent in 3..17 {
        for sign in [-1.0, 1.0] {
            let from = inclined(-(critical + sign * 10.0_f64.powi(-exponent)), 0.3);
            let coefficient = |component| {
                at.dirac_direction(from, component)
                    .map_or(0.0, |to| at.eval(from, to, component).x / at.dirac_density(to, component) * to.z.abs())
            };
            let (r, t) = (coefficient(Component::DiracReflection), coefficient(Component::DiracTransmission));
            assert!((r + t - 1.0).abs() < 1e-6, "1e-{exponent}: {r} + {t}");
        }
    }
}

#[test]
fn rough_surfaces_never_gain_energy_and_lose_none_when_nearly_smooth() {
    for kind in [Kind::Metal, Kind::Glass, Kind::Bubble, Kind::Thin] {
        for alpha in [1.0, 0.3, 0.1, 0.01, 2e-3] {
            for cos in [1.0, 0.5, 0.1, -0.9, -0.3] {
                let (mean, error) = albedo_by_sampling(&white(kind, alpha), inclined(cos, 0.1), 20_000, 2);
                assert!(mean < 1.0 + 4.0 * error + 1e-9, "{kind:?} {alpha} {cos}: {mean} +- {error}");
                if alpha <= 0.01 && cos.abs() >= 0.3 {
                    assert!(mean > 0.99 - 4.0 * error, "{kind:?} {alpha} {cos}: {mean} +- {error}");
                }
            }
        }
    }
}

#[test]
fn sampling_agrees_with_quadrature() {
    let kinds =
        [Kind::Metal, Kind::Coated, Kind::HalfMetal, Kind::Glass, Kind::MixedSolid, Kind::Thin, Kind::MixedThin];
    let tilted = DVec3::new(0.3, 0.0, 0.91_f64.sqrt());
    let mut cases = 0;
    for kind in kinds {
        for alpha in [0.8, 0.2] {
            for (ns, cos) in [(DVec3::Z, 0.9), (DVec3::Z, -0.6), (tilted, 0.3), (tilted, -0.8)] {
                let at = kind.at(alpha, ns);
                let from = inclined(cos, 0.7);
                let rings = Rings::new(DVec3::Z, 0.5, 16, 16);
                let over = |w: DVec3| at.eval(from, w, Component::Rough).x * w.z.abs();
                let exact: f64 = rings.integrals(&over, 1e-5).iter().sum();
                let (mean, error) = albedo_by_sampling(&at, from, 40_000, 7 + cases);
                assert!((mean - exact).abs() < 4.0 * error + 1e-4, "{kind:?} {alpha} {cos}: {mean} {error} {exact}");
                cases += 1;
            }
        }
    }
}

#[test]
fn crossing_the_threshold_of_smoothness_changes_no_albedo() {
    for kind in [Kind::Metal, Kind::Coated, Kind::Glass, Kind::Thin] {
        for cos in [1.0, 0.5, -0.85] {
            let from = inclined(cos, 0.4);
            let rough = albedo_by_sampling(&kind.at(1.1e-3, DVec3::Z), from, 100_000, 3);
            let smooth = albedo_by_sampling(&kind.at(0.9e-3, DVec3::Z), from, 100_000, 4);
            let difference = (rough.0 - smooth.0).abs();
            assert!(difference < 4.0 * rough.1.hypot(smooth.1) + 1e-3, "{kind:?} {cos}: {rough:?} {smooth:?}");
        }
    }
}
