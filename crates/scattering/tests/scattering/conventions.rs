//! Reciprocity, the convention for Dirac components, and the factor of shading normals.

use ergodic_scattering::{Component, Interaction, Material, MaterialLayers, Rgb};
use glam::DVec3;

use crate::support::{ALL, BASE, Kind, Random, inclined, surface, textures};

const TILTED: DVec3 = DVec3::new(0.48, -0.36, 0.8);

fn index(at: &Interaction, w: DVec3) -> f64 {
    if w.dot(at.ng) < 0.0 { at.index_below() } else { 1.0 }
}

fn relative(a: Rgb, b: Rgb) -> f64 {
    let scale = a.abs().max_element().max(b.abs().max_element());
    if scale == 0.0 { 0.0 } else { (a - b).abs().max_element() / scale }
}

/// The largest violations of f(a->b)/n_b^2 = f(b->a)/n_a^2 and of f(a->b) = f(b->a) over random pairs, and how many
/// pairs did scatter.
fn reciprocity(kind: Kind, alpha: f64, ns: DVec3, pairs: u32) -> (f64, f64, u32) {
    let at = kind.at(alpha, ns);
    let mut random = Random::new(5);
    let (mut worst, mut worst_plain, mut scattered) = (0.0_f64, 0.0_f64, 0);
    for i in 0..pairs {
        let a = random.direction();
        // Uniform pairs, and pairs that the surface itself makes.
        let b = if i % 2 == 0 { Some(random.direction()) } else { at.sample(a, random.three()).map(|(b, _)| b) };
        let Some(b) = b else { continue };
        let unshaded = |l: DVec3, e: DVec3| at.eval(l, e, Component::Rough) * (l.dot(at.ng) / l.dot(at.frame.n)).abs();
        let (forth, back) = (unshaded(a, b), unshaded(b, a));
        if forth == Rgb::ZERO && back == Rgb::ZERO {
            continue;
        }
        scattered += 1;
        let (n_a, n_b) = (index(&at, a), index(&at, b));
        worst = worst.max(relative(forth / (n_b * n_b), back / (n_a * n_a)));
        worst_plain = worst_plain.max(relative(forth, back));
    }
    (worst, worst_plain, scattered)
}

#[test]
fn scattering_is_reciprocal_up_to_the_square_of_the_index() {
    // Where base and coat have different normals only their lobes have the law, each with its own factor.
    for kind in ALL.into_iter().filter(|kind| *kind != Kind::Peeled) {
        for alpha in [1.0, 0.3, 0.03, 2e-3] {
            for ns in [DVec3::Z, TILTED] {
                let (worst, _, scattered) = reciprocity(kind, alpha, ns, 2000);
                assert!(scattered > 100 || kind == Kind::Invisible, "{kind:?} {alpha}: {scattered}");
                assert!(worst < 1e-9, "{kind:?} {alpha} {ns}: {worst}");
            }
        }
    }
}

#[test]
fn a_coat_with_its_own_normal_scatters_by_that_normal() {
    // A black base, so that only the coat is left.
    let coated = |clearcoat_roughness: f64| {
        let layers = MaterialLayers { clearcoat: 1.0, clearcoat_roughness, ..MaterialLayers::default() };
        let material = Material { base_color: Rgb::ZERO, specular: 0.0, roughness: 0.5, ..Kind::Peeled.material(0.3) };
        let material = Material { metallic: 0.0, layers: Some(Box::new(layers)), ..material };
        material.interaction(&textures(), &surface(DVec3::Z))
    };
    let at = coated(0.5);
    assert!((at.frame.n - DVec3::Z).length() > 0.1);
    let mut random = Random::new(6);
    let mut scattered = 0;
    for _ in 0..2000 {
        let (a, b) = (random.direction(), random.direction());
        // Its normal is the geometric one, so that the factor is 1.
        let (forth, back) = (at.eval(a, b, Component::Rough), at.eval(b, a, Component::Rough));
        scattered += u32::from(forth != Rgb::ZERO);
        // The normal is stored in single precision.
        assert!(relative(forth, back) < 1e-4, "{forth} {back}");
    }
    assert!(scattered > 300);
    // A smooth one mirrors about it, in both directions and on both sides.
    let at = coated(0.0);
    assert!(at.has_dirac(Component::DiracReflection) && !at.has_dirac(Component::DiracTransmission));
    for cos in [1.0, 0.7, -0.4] {
        let from = inclined(cos, 0.3);
        let to = at.dirac_direction(from, Component::DiracReflection).unwrap();
        assert!((from + to - DVec3::Z * (2.0 * cos)).length() < 1e-6);
        let reflectance = 0.04 + 0.96 * (1.0 - cos.abs()).powi(5);
        let density = at.dirac_density(to, Component::DiracReflection);
        assert!((density - cos.abs()).abs() < 1e-6);
        let f = at.eval(from, to, Component::DiracReflection);
        assert!((f - reflectance).abs().max_element() < 1e-5, "{f} {reflectance}");
        assert!((at.pdf(from, to, Component::DiracReflection) / density - 1.0).abs() < 1e-9);
    }
}

#[test]
fn a_smooth_coat_over_a_smooth_base_is_one_mirror_or_none() {
    // The same normal: the shares add.
    let coat = MaterialLayers { clearcoat: 0.8, ..MaterialLayers::default() };
    let material = Material { layers: Some(Box::new(coat)), ..Kind::Metal.material(0.0) };
    let at = material.interaction(&[], &surface(DVec3::Z));
    for cos in [1.0, 0.6, -0.2] {
        let from = inclined(cos, 0.2);
        let weight = (1.0 - cos.abs()).powi(5);
        let coat = 0.8 * (0.04 + 0.96 * weight);
        let metal = BASE + (Rgb::ONE - BASE) * weight;
        let to = at.dirac_direction(from, Component::DiracReflection).unwrap();
        let f = at.eval(from, to, Component::DiracReflection);
        assert!((f - (metal * (1.0 - coat) + coat)).abs().max_element() < 2e-5, "{f}");
        assert!((at.pdf(from, to, Component::DiracReflection) - cos.abs()).abs() < 1e-9);
    }
    // Another one: the coat is a little rough, and the mirror is the metal's.
    let at = Kind::Peeled.at(0.0, DVec3::Z);
    assert!(at.has_rough() && at.has_dirac(Component::DiracReflection));
    let to = at.dirac_direction(DVec3::Z, Component::DiracReflection).unwrap();
    assert!((to - (at.frame.n * (2.0 * at.frame.n.z) - DVec3::Z)).length() < 1e-12);
    assert!(at.eval(DVec3::Z, DVec3::Z, Component::Rough).x > 1e3);
}

#[test]
fn leaving_the_square_of_the_index_out_is_noticed() {
    for (kind, ior) in [(Kind::Glass, 1.5), (Kind::MixedSolid, 1.8)] {
        let (_, worst, _) = reciprocity(kind, 0.3, DVec3::Z, 2000);
        let expected = 1.0 - 1.0 / (ior * ior);
        assert!((worst - expected).abs() < 1e-9, "{worst} {expected}");
    }
}

/// Fresnel's equations in the angles' form, independent of the library's.
fn fresnel(cos_i: f64, n_i: f64, n_t: f64) -> f64 {
    let theta_i = cos_i.acos();
    let sin_t = n_i / n_t * theta_i.sin();
    if sin_t >= 1.0 {
        return 1.0;
    }
    let theta_t = sin_t.asin();
    let s = (theta_i - theta_t).sin() / (theta_i + theta_t).sin();
    let p = (theta_i - theta_t).tan() / (theta_i + theta_t).tan();
    0.5 * (s * s + p * p)
}

/// Checks both identities of the convention for the component, and returns its coefficient.
fn identities(at: &Interaction, from: DVec3, to: DVec3, component: Component, expected: Rgb) {
    let density = at.dirac_density(to, component);
    let selection = at.pdf(from, to, component) / density;
    assert!(selection > 0.0 && selection <= 1.0 + 1e-12);
    let (n_from, n_to) = (index(at, from), index(at, to));
    let ns = at.frame.n;
    assert!((density - to.dot(ns).abs() * n_to * n_to).abs() < 1e-12);
    // Importance: from is the light's side. Left over is the shading-normal factor of the adjoint (Veach 5.3.2).
    let importance = at.eval(from, to, component) * to.dot(at.ng).abs() / at.pdf(from, to, component);
    let adjoint = (from.dot(ns) * to.dot(at.ng) / (from.dot(at.ng) * to.dot(ns))).abs();
    assert!(relative(importance, expected * adjoint / selection) < 1e-9, "{importance} {expected} {selection}");
    // Radiance: from is the eye's side. It is compressed by the square of the index, and no normal shows.
    let radiance = at.eval(to, from, component) * to.dot(at.ng).abs() / at.pdf(from, to, component);
    let compression = (n_from / n_to).powi(2);
    assert!(relative(radiance, expected * (compression / selection)) < 1e-9, "{radiance} {expected}");
}

#[test]
fn dirac_components_keep_the_convention() {
    for ns in [DVec3::Z, TILTED] {
        for cos in [0.95, 0.8, 0.5, 0.3, -0.9, -0.8, -0.7, -0.3] {
            for (kind, ior) in [(Kind::Glass, 1.5), (Kind::Thin, 1.5), (Kind::Bubble, 0.75)] {
                let at = kind.at(0.0, ns);
                let from = inclined(cos, 1.0);
                let cos_s = from.dot(ns);
                if cos * cos_s <= 0.0 {
                    continue;
                }
                let solid = kind != Kind::Thin;
                assert_eq!(at.medium_below(), solid);
                let (n_i, n_t) = if solid && cos < 0.0 { (ior, 1.0) } else { (1.0, ior) };
                let reflectance = fresnel(cos_s.abs(), n_i, n_t);
                if let Some(to) = at.dirac_direction(from, Component::DiracReflection) {
                    assert!((from + to - ns * (2.0 * cos_s)).length() < 1e-12);
                    identities(&at, from, to, Component::DiracReflection, Rgb::splat(reflectance));
                }
                let transmitted = at.dirac_direction(from, Component::DiracTransmission);
                if reflectance == 1.0 {
                    assert!(transmitted.is_none());
                }
                let Some(to) = transmitted else { continue };
                if solid {
                    // Snell's law: the tangential parts of n w cancel.
                    let sum = from * n_i + to * n_t;
                    assert!((sum - ns * sum.dot(ns)).length() < 1e-12);
                } else {
                    assert!((to + from).length() < 1e-12);
                }
                assert!(to.dot(ns) * cos_s < 0.0);
                identities(&at, from, to, Component::DiracTransmission, BASE * (1.0 - reflectance));
                let back = at.dirac_direction(to, Component::DiracTransmission).unwrap();
                assert!((back - from).length() < 1e-9);
            }
        }
    }
}

#[test]
fn a_smooth_metal_and_a_smooth_coat_keep_the_convention() {
    for cos in [1.0, 0.6, 0.2, -0.5] {
        let from = inclined(cos, 0.2);
        let weight = (1.0 - cos.abs()).powi(5);
        let metal = Kind::Metal.at(0.0, DVec3::Z);
        let to = metal.dirac_direction(from, Component::DiracReflection).unwrap();
        identities(&metal, from, to, Component::DiracReflection, BASE + (Rgb::ONE - BASE) * weight);
        let coated = Kind::Coated.at(0.0, DVec3::Z);
        identities(&coated, from, to, Component::DiracReflection, Rgb::splat(0.04 + 0.96 * weight));
        assert!(coated.has_rough() && !metal.has_rough());
        // The diffuse base keeps what the coat lets through at the half vector, and no more than the coat does not reflect.
        let w = inclined(0.4 * cos.signum(), 2.0);
        let lets_through = |cos: f64| 0.96 - 0.96 * (1.0 - cos.abs()).powi(5);
        let room = lets_through(from.z).min(lets_through(w.z)) / BASE.max_element();
        let kept = lets_through(from.dot((from + w).normalize()));
        assert_eq!(room < kept, cos == 0.2);
        let expected = BASE * (kept.min(room) / std::f64::consts::PI);
        assert!(relative(coated.eval(from, w, Component::Rough), expected) < 1e-12);
    }
}

#[test]
fn no_light_leaks_where_the_normals_disagree() {
    let ns = DVec3::new(std::f64::consts::FRAC_1_SQRT_2, 0.0, std::f64::consts::FRAC_1_SQRT_2);
    let mut random = Random::new(3);
    for kind in ALL {
        for alpha in [0.5, 0.05, 0.0] {
            let at = kind.at(alpha, ns);
            for _ in 0..2000 {
                let (from, other) = (random.direction(), random.direction());
                let disagree = |w: DVec3| w.dot(at.frame.n) * w.z <= 0.0;
                if disagree(from) || disagree(other) {
                    assert_eq!(at.eval(from, other, Component::Rough), Rgb::ZERO);
                    assert_eq!(at.pdf(from, other, Component::Rough), 0.0);
                }
                if let Some((to, component)) = at.sample(from, random.three()) {
                    assert!(!disagree(from) && !disagree(to));
                    assert!(!kind.is_opaque() || from.z * to.z > 0.0);
                    assert!(at.pdf(from, to, component) > 0.0);
                    if component != Component::Rough {
                        let again = at.dirac_direction(from, component).unwrap();
                        assert_eq!(to, again);
                    }
                }
            }
        }
    }
}

#[test]
fn the_shading_normal_enters_only_as_veachs_factor() {
    let mut random = Random::new(4);
    let (flat, bumpy) = (Kind::Lambert.at(1.0, DVec3::Z), Kind::Lambert.at(1.0, TILTED));
    for _ in 0..1000 {
        let (light, eye) = (random.direction(), random.direction());
        let f = bumpy.eval(light, eye, Component::Rough);
        if f != Rgb::ZERO {
            let factor = (light.dot(TILTED) / light.z).abs();
            assert!(relative(f, flat.eval(light, eye, Component::Rough) * factor) < 1e-12);
        }
    }
}
