//! Every sampler draws from the density that `pdf` states.

use std::f64::consts::PI;

use ergodic_geometry::Frame;
use ergodic_scattering::{Component, Interaction, Material};
use glam::DVec3;

use crate::support::{Kind, Outcome, Random, Rings, chi_square_directions, inclined, is_nightly, surface, textures};

const SAMPLES: u64 = 40_000;
const ALPHAS: [f64; 6] = [1.0, 0.5, 0.1, 1e-2, 2e-3, 1e-4];
const COSINES: [f64; 5] = [1.0, 0.7, 0.3, 0.05, 2e-3];
const DIRAC: [Component; 2] = [Component::DiracReflection, Component::DiracTransmission];

/// Tilts of the shading normal.
const STRAIGHT: DVec3 = DVec3::Z;
const TILTED: DVec3 = DVec3::new(0.48, -0.36, 0.8);

/// Probabilities with which the Dirac components come out: those of choosing one, where there is a direction then. Their densities say
/// the same.
fn dirac_probabilities(at: &Interaction, from: DVec3) -> [f64; 2] {
    let chosen = at.dirac_probabilities(from);
    [0, 1].map(|i| {
        at.dirac_direction(from, DIRAC[i]).map_or(0.0, |to| {
            let density = chosen[i] * at.dirac_density(to, DIRAC[i]);
            assert!((at.pdf(from, to, DIRAC[i]) - density).abs() <= 1e-12 * density, "{from} {:?}", DIRAC[i]);
            chosen[i]
        })
    })
}

/// One draw of which only the directions on the side of `axis` count as such.
fn draw(at: &Interaction, from: DVec3, axis: DVec3, u: [f64; 3]) -> Outcome {
    match at.sample(from, u) {
        None => Outcome::Nothing,
        Some((w, Component::Rough)) if w.z * axis.z > 0.0 => Outcome::Direction(w),
        Some((_, Component::Rough)) => Outcome::Nothing,
        Some((_, Component::DiracReflection)) => Outcome::Other(0),
        Some((_, Component::DiracTransmission)) => Outcome::Other(1),
    }
}

/// Where the reflected and the transmitted lobe point: what a smooth surface of the kind would do.
fn axes(kind: Kind, ns: DVec3, from: DVec3) -> [Option<DVec3>; 2] {
    // Any index but 1, so that there is a mirror.
    let smooth = Material { roughness: 0.0, layers: None, ..kind.material(0.0) };
    let smooth = Material { ior: if smooth.ior == 1.0 { 1.5 } else { smooth.ior }, ..smooth };
    let at = smooth.interaction(&textures(), &surface(ns));
    DIRAC.map(|component| at.dirac_direction(from, component))
}

fn check(kind: Kind, alpha: f64, ns: DVec3, from: DVec3, seed: u64) -> Result<(), String> {
    let at = kind.at(alpha, ns);
    let [reflected, transmitted] = axes(kind, ns, from);
    let above = DVec3::Z * from.z.signum();
    for axis in [reflected.unwrap_or(above), transmitted.unwrap_or(-above)] {
        let mut random = Random::new(seed);
        let width = if alpha < 1e-3 { 1.0 } else { alpha * from.dot(ns).abs().clamp(0.1, 1.0) };
        let rings = Rings::new(axis, width, 11, 8).within(&[DVec3::Z, ns]);
        let pdf = |w: DVec3| if w.z * axis.z > 0.0 { at.pdf(from, w, Component::Rough) } else { 0.0 };
        let others = dirac_probabilities(&at, from);
        chi_square_directions(&rings, SAMPLES, &pdf, &others, &mut || draw(&at, from, axis, random.three()))
            .map_err(|error| format!("{kind:?} alpha {alpha} from {from} about {axis}: {error}"))?;
    }
    Ok(())
}

/// Goes over alphas and inclinations like a chessboard whose fields are the sides. Of the costly surfaces with layers half of the fields,
/// as many of each side, at nightly size all.
fn check_all(kind: Kind, sides: &[f64]) -> Result<(), String> {
    let mut seed = kind as u64 * 1000;
    let nightly = is_nightly();
    let is_costly = kind.material(1.0).layers.is_some();
    for (j, alpha) in ALPHAS.into_iter().enumerate() {
        if alpha < 0.05 && kind.is_anisotropic() {
            // A ridge that the quadrature would miss.
            continue;
        }
        for (i, cos) in COSINES.into_iter().enumerate() {
            seed += 1;
            if is_costly && !nightly && (i + 2 * j) % 4 >= 2 {
                continue;
            }
            let from = inclined(cos, 0.6 + 0.5 * i as f64) * sides[(i + j) % sides.len()];
            check(kind, alpha, STRAIGHT, from, seed)?;
            // The tilted normal is tried with every other direction.
            if i % 2 == 1 {
                check(kind, alpha, TILTED, from, seed)?;
            }
        }
    }
    Ok(())
}

const ABOVE: &[f64] = &[1.0];
const BOTH: &[f64] = &[1.0, -1.0];

#[test]
fn lambert() {
    for (ns, cos) in [(STRAIGHT, 1.0), (TILTED, 0.7), (TILTED, -0.4), (STRAIGHT, 1e-3)] {
        check(Kind::Lambert, 1.0, ns, inclined(cos, 2.0), 1).unwrap();
    }
}

#[test]
fn metal() {
    check_all(Kind::Metal, ABOVE).unwrap();
}

#[test]
fn coated() {
    check_all(Kind::Coated, ABOVE).unwrap();
}

#[test]
fn half_metal() {
    // From behind: two-sided.
    check_all(Kind::HalfMetal, &[-1.0]).unwrap();
}

#[test]
fn glass() {
    check_all(Kind::Glass, BOTH).unwrap();
}

#[test]
fn mixed_solid() {
    check_all(Kind::MixedSolid, BOTH).unwrap();
}

#[test]
fn bubble() {
    check_all(Kind::Bubble, BOTH).unwrap();
}

#[test]
fn thin() {
    check_all(Kind::Thin, ABOVE).unwrap();
}

#[test]
fn mixed_thin() {
    check_all(Kind::MixedThin, &[-1.0]).unwrap();
}

#[test]
fn varnished() {
    check_all(Kind::Varnished, BOTH).unwrap();
}

#[test]
fn peeled() {
    check_all(Kind::Peeled, BOTH).unwrap();
}

#[test]
fn velvet() {
    check_all(Kind::Velvet, BOTH).unwrap();
}

#[test]
fn brushed() {
    check_all(Kind::Brushed, BOTH).unwrap();
}

#[test]
fn brushed_glass() {
    check_all(Kind::BrushedGlass, BOTH).unwrap();
}

#[test]
fn oiled() {
    check_all(Kind::Oiled, ABOVE).unwrap();
}

#[test]
fn soap_film() {
    check_all(Kind::SoapFilm, BOTH).unwrap();
}

#[test]
fn opal() {
    check_all(Kind::Opal, BOTH).unwrap();
}

#[test]
fn leaf() {
    check_all(Kind::Leaf, BOTH).unwrap();
}

#[test]
fn wax() {
    check_all(Kind::Wax, BOTH).unwrap();
}

#[test]
fn murky() {
    check_all(Kind::Murky, BOTH).unwrap();
}

#[test]
fn murky_bubble() {
    check_all(Kind::MurkyBubble, BOTH).unwrap();
}

#[test]
fn everything() {
    check_all(Kind::Everything, BOTH).unwrap();
}

#[test]
fn everything_solid() {
    check_all(Kind::EverythingSolid, BOTH).unwrap();
}

/// A planted fault must fail.
fn assert_caught(kind: Kind, alpha: f64, from: DVec3, faulty: &dyn Fn(&Interaction, DVec3) -> f64) {
    let at = kind.at(alpha, STRAIGHT);
    let [axis, _] = axes(kind, STRAIGHT, from);
    let axis = axis.unwrap_or(DVec3::Z);
    let mut random = Random::new(9);
    let rings = Rings::new(axis, alpha.max(0.1), 14, 10);
    let pdf = |w: DVec3| if w.z * axis.z > 0.0 { faulty(&at, w) } else { 0.0 };
    let others = dirac_probabilities(&at, from);
    let result = chi_square_directions(&rings, SAMPLES, &pdf, &others, &mut || draw(&at, from, axis, random.three()));
    assert!(result.is_err(), "the fault was not noticed");
}

#[test]
fn a_missing_jacobian_is_caught() {
    let from = inclined(0.7, 0.4);
    for alpha in [0.5, 0.1] {
        // The density of the half vector, scaled so that only its shape is wrong.
        assert_caught(Kind::Metal, alpha, from, &|at, w| {
            at.pdf(from, w, Component::Rough) * from.dot((from + w).normalize()) / 0.7
        });
    }
}

#[test]
fn a_forgotten_lobe_choice_is_caught() {
    let from = inclined(0.5, 0.4);
    // A smooth coat over a diffuse base: the diffuse density without the probability of not reflecting.
    assert_caught(Kind::Coated, 0.0, from, &|_, w| w.z / PI);
    // Two rough lobes mixed as if they were equally likely.
    let metal = Kind::Metal.at(0.1, STRAIGHT);
    assert_caught(Kind::Coated, 0.1, from, &|_, w| 0.5 * w.z / PI + 0.5 * metal.pdf(from, w, Component::Rough));
}

#[test]
fn a_coat_drawn_but_not_counted_is_caught() {
    let from = inclined(0.5, 0.4);
    // The metal's density alone, as if the coat were never chosen.
    let metal = Material { layers: None, ..Kind::Varnished.material(0.1) }.interaction(&[], &surface(STRAIGHT));
    assert_caught(Kind::Varnished, 0.1, from, &|_, w| metal.pdf(from, w, Component::Rough));
}

#[test]
fn a_forgotten_axis_of_the_anisotropy_is_caught() {
    let from = inclined(0.7, 0.4);
    // As if the surface were turned by a quarter.
    assert_caught(Kind::Brushed, 0.1, from, &|at, w| {
        let turned: Interaction =
            Interaction::new(Frame { t: at.frame.b, b: -at.frame.t, n: at.frame.n }, at.ng, at.bsdf);
        turned.pdf(from, w, Component::Rough)
    });
}

#[test]
fn light_that_is_not_sent_through_a_leaf_is_caught() {
    let from = inclined(0.7, 0.4);
    // What is transmitted counted as reflected.
    assert_caught(Kind::Leaf, 0.5, from, &|at, w| {
        at.pdf(from, w, Component::Rough) + at.pdf(from, -w, Component::Rough)
    });
}

#[test]
fn a_sheen_drawn_by_the_cosine_is_caught() {
    let from = inclined(0.2, 0.4);
    assert_caught(Kind::Velvet, 0.3, from, &|at, w| {
        let (uniform, cosine) = (0.5 / PI, w.z / PI);
        // The share of the uniform part, from the density where the cosine's part is nothing.
        let share = at.pdf(from, inclined(1e-9, 1.0), Component::Rough) / uniform;
        at.pdf(from, w, Component::Rough) + share * (cosine - uniform)
    });
}
