//! Energy: furnaces, samples against quadrature, and the passage from rough to smooth.

use ergodic_scattering::{Component, Interaction, Material, MaterialLayers, Rgb};
use glam::DVec3;

use crate::support::{EXTENDED, Kind, Random, Rings, inclined, is_nightly, surface, textures};

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
    material.interaction(&textures(), &surface(DVec3::Z))
}

/// The share of power, channel x, that reaches `eye` from a white furnace, without chance.
pub fn albedo_by_quadrature(at: &Interaction, eye: DVec3, kind: Kind, alpha: f64) -> f64 {
    albedo_of_channel(at, eye, kind, alpha, 0)
}

/// The same of any channel.
pub fn albedo_of_channel(at: &Interaction, eye: DVec3, kind: Kind, alpha: f64, channel: usize) -> f64 {
    let over = |w: DVec3| at.eval(w, eye, Component::Rough)[channel] * w.z.abs();
    let n2 = |w: DVec3| if w.z < 0.0 { at.index_below().powi(2) } else { 1.0 };
    // Radiance is n^2 times as large in a medium of index n.
    let furnace = |w: DVec3| over(w) * n2(w) / n2(eye);
    let smooth = Material { roughness: 0.0, layers: None, ..kind.material(0.0) };
    let smooth = smooth.interaction(&textures(), &surface(DVec3::Z));
    let mut sum = 0.0;
    for (component, side) in [(Component::DiracReflection, 1.0), (Component::DiracTransmission, -1.0)] {
        let above = DVec3::Z * eye.z.signum() * side;
        let axis = smooth.dirac_direction(eye, component).unwrap_or(above);
        let rings = Rings::new(axis, (alpha * eye.z.abs()).max(0.01), 12, 8).within(&[DVec3::Z]);
        let one_side = |w: DVec3| if w.z * above.z > 0.0 { furnace(w) } else { 0.0 };
        sum += rings.integrals(&one_side, 1e-5).iter().sum::<f64>();
        if let Some(light) = at.dirac_direction(eye, component) {
            let density = at.dirac_density(light, component);
            sum += at.eval(light, eye, component)[channel] / density * light.z.abs() * n2(light) / n2(eye);
        }
    }
    sum
}

const GRID_ALPHAS: [f64; 4] = [1.0, 0.25, 0.04, 0.0];
const GRID_COSINES: [f64; 6] = [0.9, 0.3, 0.05, 0.005, -0.1, -0.7];

#[test]
fn effects_never_gain_energy() {
    let mut darkest = 1.0_f64;
    for kind in EXTENDED {
        let alphas = GRID_ALPHAS.into_iter().enumerate();
        for (i, alpha) in alphas.filter(|(_, alpha)| *alpha > 0.1 || !kind.is_anisotropic()) {
            for ior in [1.5, 2.4] {
                let material = kind.material(alpha);
                if ior != 1.5 && !material.is_solid() {
                    continue;
                }
                let mut layers = material.layers.clone().unwrap();
                layers.diffuse_transmission_color = Rgb::ONE;
                layers.sheen_color *= 1.0 / 0.9;
                layers.iridescence_ior = 0.5 + 0.6 * ior;
                let ior = if kind == Kind::SoapFilm { 1.0 } else { ior };
                let white = Material { base_color: Rgb::ONE, layers: Some(layers), ior, ..material };
                let at = white.interaction(&textures(), &surface(DVec3::Z));
                // Every other point of the grid, but at the nightly sizes.
                let cosines = GRID_COSINES.into_iter().enumerate();
                for (_, cos) in cosines.filter(|(j, _)| is_nightly() || (i + j) % 2 == 0) {
                    let albedo = albedo_by_quadrature(&at, inclined(cos, 0.4), kind, alpha);
                    assert!(albedo <= 1.001, "{kind:?} alpha {alpha} ior {ior} cos {cos}: {albedo}");
                    if kind != Kind::Peeled {
                        // A mapped normal faces away from grazing directions.
                        darkest = darkest.min(albedo);
                    }
                }
            }
        }
    }
    assert!(darkest > 0.05, "{darkest}");
}

#[test]
fn layers_never_add_energy_to_any_base() {
    for kind in [Kind::Varnished, Kind::Peeled, Kind::Velvet, Kind::Everything, Kind::EverythingSolid] {
        for alpha in GRID_ALPHAS.into_iter().filter(|alpha| *alpha > 0.1 || !kind.is_anisotropic()) {
            let material = Material { base_color: Rgb::ONE, ..kind.material(alpha) };
            let layers = material.layers.clone().unwrap();
            // The base: what is left without the coat and the sheen.
            let bare = Material {
                layers: Some(Box::new(MaterialLayers { clearcoat: 0.0, sheen_color: Rgb::ZERO, ..*layers })),
                ..material.clone()
            };
            for cos in GRID_COSINES {
                let eye = inclined(cos, 0.4);
                let albedo = |material: &Material| {
                    let at = material.interaction(&textures(), &surface(DVec3::Z));
                    albedo_by_quadrature(&at, eye, kind, alpha)
                };
                let (with, without) = (albedo(&material), albedo(&bare));
                assert!(with <= without.max(1.0) + 1e-3, "{kind:?} {alpha} {cos}: {without} became {with}");
            }
        }
    }
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
