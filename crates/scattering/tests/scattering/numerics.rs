//! Grazing angles, degenerate indices and sizes.

use ergodic_scattering::{Bsdf, Component, Extended, Interaction, Layered};
use glam::DVec3;

use crate::support::{ALL, Kind, Random, inclined};

#[test]
fn nothing_breaks_at_grazing_angles() {
    let mut random = Random::new(8);
    for kind in ALL {
        for alpha in [1.0, 0.5, 0.1, 1e-2, 2e-3, 1e-3, 0.0] {
            let at = kind.at(alpha, DVec3::Z);
            let mut largest = 0.0_f64;
            for exponent in 0..=16 {
                for side in [1.0, -1.0] {
                    let from = inclined(side * 10.0_f64.powf(-0.5 * f64::from(exponent)), 0.9);
                    for _ in 0..300 {
                        let Some((to, component)) = at.sample(from, random.three()) else { continue };
                        let pdf = at.pdf(from, to, component);
                        let f = at.eval(from, to, component);
                        let weight = f * (to.z.abs() / pdf);
                        assert!(to.is_finite() && (to.length() - 1.0).abs() < 1e-9, "{kind:?} {alpha} {from}");
                        assert!(
                            pdf > 0.0 && pdf.is_finite() && f.is_finite(),
                            "{kind:?} {alpha} {from} {to}: {pdf} {f}"
                        );
                        largest = largest.max(weight.max_element());
                    }
                    // Any other direction, down to grazing itself.
                    let cos = 10.0_f64.powf(-8.0 * random.next()) * if random.next() < 0.5 { 1.0 } else { -1.0 };
                    let to = inclined(cos, 7.0 * random.next());
                    let rough = Component::Rough;
                    assert!(at.eval(from, to, rough).is_finite() && at.pdf(from, to, rough).is_finite());
                }
            }
            // A single lobe drawn by visible normals weighs what masking leaves, at most 1; a mixture at most the inverse
            // of the least share that a lobe is chosen with.
            let bound = if matches!(kind, Kind::Metal | Kind::Lambert) { 1.0 + 1e-6 } else { 40.0 };
            // Where the normals differ, so do their cosines with the light.
            assert!(largest <= bound || kind == Kind::Peeled, "{kind:?} {alpha}: {largest}");
        }
    }
}

#[test]
fn equal_indices_let_light_pass_straight() {
    for alpha in [0.0, 0.3] {
        let at = Kind::Invisible.at(alpha, DVec3::Z);
        for cos in [1.0, 0.5, 1e-5, -1e-5, -0.5, -1.0] {
            let from = inclined(cos, 0.4);
            let (to, component) = at.sample(from, [0.3, 0.6, 0.1]).unwrap();
            assert_eq!(component, Component::DiracTransmission);
            assert!((to + from).length() < 1e-9);
        }
    }
}

#[test]
fn directions_in_the_surface_scatter_nothing() {
    for kind in ALL {
        for alpha in [0.5, 0.0] {
            let at = kind.at(alpha, DVec3::Z);
            assert!(at.sample(DVec3::X, [0.5; 3]).is_none());
            assert_eq!(at.pdf(DVec3::X, DVec3::Z, Component::Rough), 0.0);
            assert_eq!(at.eval(DVec3::Z, DVec3::X, Component::Rough), DVec3::ZERO);
            assert!(at.dirac_direction(DVec3::X, Component::DiracReflection).is_none());
        }
    }
}

#[test]
fn an_interaction_stays_compact() {
    assert!(size_of::<Interaction>() <= 208, "{}", size_of::<Interaction>());
    // The effects of few materials must not make the vertices of all paths larger.
    assert!(size_of::<Extended>() <= 88, "{}", size_of::<Extended>());
    assert_eq!(size_of::<Bsdf>(), size_of::<Layered>());
}
