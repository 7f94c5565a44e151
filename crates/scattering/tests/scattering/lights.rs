//! Lights: samplers against densities, powers against integrals; the warps they are made of.

use std::f64::consts::PI;

use ergodic_scattering::{PunctualLight, Rgb, emission, warp};
use glam::{DVec2, DVec3};

use crate::support::{Outcome, Random, Rings, chi_square, chi_square_directions};

const AXIS: DVec3 = DVec3::new(0.48, -0.36, 0.8);

fn spot(inner: f64, outer: f64) -> PunctualLight {
    PunctualLight::Spot {
        position: DVec3::ONE,
        axis: AXIS,
        intensity: Rgb::new(1.0, 2.0, 3.0),
        cos_inner: inner.cos(),
        cos_outer: outer.cos(),
    }
}

fn test(pdf: &dyn Fn(DVec3) -> f64, sample: &dyn Fn([f64; 2]) -> DVec3) -> Result<f64, String> {
    let mut random = Random::new(21);
    let rings = Rings::new(AXIS, 0.3, 16, 12);
    chi_square_directions(&rings, 100_000, pdf, &[], &mut || Outcome::Direction(sample(random.two())))
}

#[test]
fn lights_sample_their_density() {
    let point = PunctualLight::Point { position: DVec3::ONE, intensity: Rgb::ONE };
    for light in [point, spot(0.2, 0.5), spot(0.0, 1.4), spot(0.1, 0.1)] {
        let missing = test(&|w| light.pdf_direction(w), &|u| light.sample_direction(u)).unwrap();
        assert!(missing.abs() < 2e-3, "{missing}");
        assert_eq!(light.position(), Some(DVec3::ONE));
    }
    for double_sided in [false, true] {
        let pdf = |w: DVec3| emission::pdf_direction(double_sided, AXIS, w);
        let sample = |u: [f64; 2]| emission::sample_direction(double_sided, AXIS, u);
        let missing = test(&pdf, &sample).unwrap();
        assert!(missing.abs() < 1e-3);
        // Planted fault: uniform instead of proportional to the cosine.
        let sides = if double_sided { 2.0 } else { 1.0 };
        let uniform = |w: DVec3| if double_sided || w.dot(AXIS) > 0.0 { 0.5 / (PI * sides) } else { 0.0 };
        assert!(test(&uniform, &sample).is_err());
    }
}

#[test]
fn power_is_the_integral_of_what_is_emitted() {
    let rings = Rings::new(AXIS, 0.05, 40, 4);
    for light in [spot(0.2, 0.5), spot(0.0, 1.4), spot(0.0, 0.02), spot(0.3, 0.3)] {
        let integral: f64 = rings.integrals(&|w| light.emitted(w).y, 1e-9).iter().sum();
        let power = light.power(1.0).y;
        assert!((integral / power - 1.0).abs() < 1e-4, "{light:?}: {integral} {power}");
    }
    let point = PunctualLight::Point { position: DVec3::ONE, intensity: Rgb::ONE };
    assert!((point.power(3.0).x - 4.0 * PI).abs() < 1e-12);
    let sun = PunctualLight::Directional { direction: -AXIS, irradiance: Rgb::ONE };
    assert!((sun.power(3.0).x - 9.0 * PI).abs() < 1e-12);
    assert_eq!((sun.position(), sun.sample_direction([0.3, 0.4]), sun.pdf_direction(-AXIS)), (None, -AXIS, 1.0));
    assert_eq!(sun.emitted(-AXIS), Rgb::ONE);
}

#[test]
fn a_spot_falls_off_as_the_square_of_the_ramp() {
    let light = spot(0.2, 0.5);
    let at = |theta: f64| {
        let side = AXIS.any_orthonormal_vector();
        light.emitted(AXIS * theta.cos() + side * theta.sin()).x
    };
    assert!((at(0.1) - 1.0).abs() < 1e-12 && at(0.51) == 0.0 && at(2.0) == 0.0);
    let ramp = (0.4_f64.cos() - 0.5_f64.cos()) / (0.2_f64.cos() - 0.5_f64.cos());
    assert!((at(0.4) - ramp * ramp).abs() < 1e-12);
}

#[test]
fn area_lights_emit_from_their_front_or_from_both_sides() {
    let emitted = |double_sided, w| emission::emitted(Rgb::ONE, double_sided, DVec3::Z, w);
    let (up, down) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.6, 0.0, -0.8));
    assert_eq!((emitted(false, up), emitted(false, down)), (Rgb::ONE, Rgb::ZERO));
    assert_eq!((emitted(true, up), emitted(true, down)), (Rgb::ONE, Rgb::ONE));
    assert_eq!(emitted(true, DVec3::X), Rgb::ZERO);
}

#[test]
fn plane_warps_are_uniform() {
    let mut random = Random::new(22);
    let samples = 100_000;
    // Rings of equal area and sectors; barycentric coordinates in a grid of equal triangles' halves.
    let (mut disk, mut triangle) = (vec![0; 80], vec![0; 36]);
    for _ in 0..samples {
        let p: DVec2 = warp::concentric_disk(random.two());
        let sector = (p.y.atan2(p.x).rem_euclid(2.0 * PI) / (2.0 * PI) * 8.0) as usize;
        disk[(p.length_squared() * 10.0) as usize * 8 + sector.min(7)] += 1;
        let (u, v) = warp::uniform_triangle(random.two());
        assert!(u >= 0.0 && v >= 0.0 && u + v <= 1.0);
        // Six strips along each coordinate: the cell above the diagonal folds onto the one below.
        let (i, j) = ((u * 6.0) as usize, (v * 6.0) as usize);
        let upper = (u * 6.0).fract() + (v * 6.0).fract() > 1.0;
        let cell = if upper { (5 - i) * 6 + 5 - j } else { i * 6 + j };
        triangle[cell.min(35)] += 1;
    }
    chi_square(&disk, &[1.0 / 80.0; 80]).unwrap();
    chi_square(&triangle, &[1.0 / 36.0; 36]).unwrap();
    assert!((warp::CONCENTRIC_DISK_PDF * PI - 1.0).abs() < 1e-12);
}
