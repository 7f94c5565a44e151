//! The camera's maps, densities and responsivity, and the filters.

use ergodic_scattering::{Camera, Filter};
use glam::{DAffine3, DVec2, DVec3};

use crate::support::{Outcome, Random, Rings, chi_square_directions};

fn camera(margin: f64) -> Camera {
    let transform = DAffine3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.1);
    Camera::new(transform, 1.2, 320, 200, margin)
}

fn integral(camera: &Camera, f: &dyn Fn(DVec3) -> f64) -> f64 {
    Rings::new(camera.forward(), 0.5, 16, 16).integrals(f, 1e-6).iter().sum()
}

#[test]
fn a_uniform_environment_has_mean_one() {
    let exact = camera(0.0);
    assert!((integral(&exact, &|w| exact.responsivity(w)) - 1.0).abs() < 1e-3);
    // The margin is extra: the image's area stays the unit.
    let enlarged = camera(10.0);
    let expected = 340.0 * 220.0 / (320.0 * 200.0);
    assert!((integral(&enlarged, &|w| enlarged.responsivity(w)) - expected).abs() < 1e-3);
    assert!((integral(&enlarged, &|w| enlarged.pdf_solid_angle(w)) - 1.0).abs() < 1e-3);
}

#[test]
fn sampling_draws_from_the_density() {
    for margin in [0.0, 4.0] {
        let camera = camera(margin);
        let mut random = Random::new(11);
        let rings = Rings::new(camera.forward(), 0.5, 12, 12);
        chi_square_directions(&rings, 100_000, &|w| camera.pdf_solid_angle(w), &[], &mut || {
            Outcome::Direction(camera.sample(random.two()))
        })
        .unwrap();
        // Planted fault: the cosine is left out.
        let faulty = |w: DVec3| camera.pdf_solid_angle(w) * w.dot(camera.forward());
        let caught = chi_square_directions(&rings, 100_000, &faulty, &[], &mut || {
            Outcome::Direction(camera.sample(random.two()))
        });
        assert!(caught.is_err());
    }
}

#[test]
fn raster_and_direction_are_inverse_and_their_jacobian_is_stated() {
    let camera = camera(2.0);
    let mut random = Random::new(12);
    for _ in 0..1000 {
        let raster = DVec2::from(random.two()) * DVec2::new(324.0, 204.0) - 2.0;
        let w = camera.direction(raster);
        assert!((camera.raster(w).unwrap_or(DVec2::NAN) - raster).length() < 1e-9);
        // d solid angle = |dw/dx x dw/dy| dx dy.
        let h = 1e-4;
        let along = |step: DVec2| (camera.direction(raster + step) - camera.direction(raster - step)) / (2.0 * h);
        let solid_angle = along(DVec2::new(h, 0.0)).cross(along(DVec2::new(0.0, h))).length();
        assert!((camera.raster_per_solid_angle(w) * solid_angle - 1.0).abs() < 1e-5);
    }
}

#[test]
fn the_raster_has_its_origin_at_the_top_left() {
    let camera = Camera::new(DAffine3::IDENTITY, std::f64::consts::FRAC_PI_2, 200, 100, 0.0);
    assert!((camera.direction(DVec2::new(100.0, 50.0)) - DVec3::NEG_Z).length() < 1e-12);
    let corner = camera.direction(DVec2::ZERO);
    assert!((corner - DVec3::new(-2.0, 1.0, -1.0).normalize()).length() < 1e-12);
    assert!(camera.raster(DVec3::Z).is_none());
    assert!(camera.raster(DVec3::new(-2.1, 0.0, -1.0).normalize()).is_none());
    assert_eq!(camera.responsivity(DVec3::new(-2.1, 0.0, -1.0).normalize()), 0.0);
    // Scale in the transform changes nothing.
    let scaled = Camera::new(DAffine3::from_scale(DVec3::splat(7.0)), std::f64::consts::FRAC_PI_2, 200, 100, 0.0);
    assert!((scaled.direction(DVec2::ZERO) - corner).length() < 1e-12);
}

#[test]
fn filters_integrate_to_one() {
    for filter in
        [Filter::Box, Filter::Gaussian { radius: 1.5, sigma: 0.5 }, Filter::Gaussian { radius: 3.0, sigma: 1.0 }]
    {
        let n = 1000;
        let step = 2.0 * filter.radius() / f64::from(n);
        let kernel = filter.kernel();
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                let at = |k: i32| (f64::from(k) + 0.5) * step - filter.radius();
                sum += kernel.weight(at(i), at(j));
            }
        }
        assert!((sum * step * step - 1.0).abs() < 1e-5, "{filter:?}: {sum}");
        assert_eq!(filter.weight(filter.radius(), 0.0), 0.0);
        assert_eq!(filter.weight(0.1, -0.2), kernel.weight(0.1, -0.2));
    }
    // Pixels of the box share every raster point out to exactly one.
    assert_eq!(Filter::Box.weight(-0.5, 0.2), 1.0);
}
