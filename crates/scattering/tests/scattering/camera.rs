//! The camera's maps, densities and responsivity, and the filters.

use ergodic_scattering::{Camera, Filter, Lens, Sight};
use glam::{DAffine3, DVec2, DVec3};

use crate::support::{Outcome, Random, Rings, chi_square, chi_square_directions};

fn camera(margin: f64) -> Camera {
    let transform = DAffine3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.1);
    Camera::new(transform, 1.2, 320, 200, margin)
}

/// The line of sight in a direction from the camera's middle.
fn sight(camera: &Camera, direction: DVec3) -> Sight {
    Sight { eye: camera.position(), point: camera.position() + direction, direction }
}

fn direction(camera: &Camera, raster: DVec2) -> DVec3 {
    camera.sight(camera.position(), raster).direction
}

fn integral(camera: &Camera, f: &dyn Fn(DVec3) -> f64) -> f64 {
    Rings::new(camera.forward(), 0.5, 16, 16).integrals(f, 1e-6).iter().sum()
}

#[test]
fn a_uniform_environment_has_mean_one() {
    let exact = camera(0.0);
    assert!((integral(&exact, &|w| exact.responsivity(&sight(&exact, w))) - 1.0).abs() < 1e-3);
    // The margin is extra: the image's area stays the unit.
    let enlarged = camera(10.0);
    let expected = 340.0 * 220.0 / (320.0 * 200.0);
    assert!((integral(&enlarged, &|w| enlarged.responsivity(&sight(&enlarged, w))) - expected).abs() < 1e-3);
    assert!((integral(&enlarged, &|w| enlarged.pdf_sight(&sight(&enlarged, w))) - 1.0).abs() < 1e-3);
}

#[test]
fn sampling_draws_from_the_density() {
    for margin in [0.0, 4.0] {
        let camera = camera(margin);
        let mut random = Random::new(11);
        let rings = Rings::new(camera.forward(), 0.5, 12, 12);
        chi_square_directions(&rings, 100_000, &|w| camera.pdf_sight(&sight(&camera, w)), &[], &mut || {
            Outcome::Direction(direction(&camera, camera.sample_raster(random.two())))
        })
        .unwrap();
        // Planted fault: the cosine is left out.
        let faulty = |w: DVec3| camera.pdf_sight(&sight(&camera, w)) * w.dot(camera.forward());
        let caught = chi_square_directions(&rings, 100_000, &faulty, &[], &mut || {
            Outcome::Direction(direction(&camera, camera.sample_raster(random.two())))
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
        let w = direction(&camera, raster);
        assert!((camera.raster(&sight(&camera, w)).unwrap_or(DVec2::NAN) - raster).length() < 1e-9);
        // d solid angle = |dw/dx x dw/dy| dx dy.
        let h = 1e-4;
        let along = |step: DVec2| (direction(&camera, raster + step) - direction(&camera, raster - step)) / (2.0 * h);
        let solid_angle = along(DVec2::new(h, 0.0)).cross(along(DVec2::new(0.0, h))).length();
        assert!((camera.raster_per_measure(&sight(&camera, w)) * solid_angle - 1.0).abs() < 1e-5);
    }
}

#[test]
fn the_raster_has_its_origin_at_the_top_left() {
    let camera = Camera::new(DAffine3::IDENTITY, std::f64::consts::FRAC_PI_2, 200, 100, 0.0);
    assert!((direction(&camera, DVec2::new(100.0, 50.0)) - DVec3::NEG_Z).length() < 1e-12);
    let corner = direction(&camera, DVec2::ZERO);
    assert!((corner - DVec3::new(-2.0, 1.0, -1.0).normalize()).length() < 1e-12);
    assert!(camera.raster(&sight(&camera, DVec3::Z)).is_none());
    assert!(camera.raster(&sight(&camera, DVec3::new(-2.1, 0.0, -1.0).normalize())).is_none());
    assert_eq!(camera.responsivity(&sight(&camera, DVec3::new(-2.1, 0.0, -1.0).normalize())), 0.0);
    // Scale in the transform changes nothing.
    let scaled = Camera::new(DAffine3::from_scale(DVec3::splat(7.0)), std::f64::consts::FRAC_PI_2, 200, 100, 0.0);
    assert!((direction(&scaled, DVec2::ZERO) - corner).length() < 1e-12);
}

const APERTURES: [(u32, f64); 4] = [(0, 0.0), (3, 0.4), (6, 0.0), (7, 1.0)];

fn lens(blades: u32, rotation: f64) -> Lens {
    Lens { radius: 0.5, focus_distance: 2.0, blades, rotation }
}

/// Whether a point lies in the aperture, by its sides.
fn is_inside(lens: &Lens, p: DVec2) -> bool {
    if lens.blades == 0 {
        return p.length() <= lens.radius;
    }
    let corner = |i: u32| {
        let angle = lens.rotation + std::f64::consts::TAU * f64::from(i) / f64::from(lens.blades);
        DVec2::from_angle(angle) * lens.radius
    };
    (0..lens.blades).all(|i| (corner(i + 1) - corner(i)).perp_dot(p - corner(i)) >= 0.0)
}

/// Shares of a lens in the cells of a square around it, by a fine grid; and the area of the lens.
fn shares(lens: &Lens, cells: usize) -> (Vec<f64>, f64) {
    let fine = 200;
    let side = 2.0 * lens.radius / (cells * fine) as f64;
    let mut counts = vec![0.0; cells * cells];
    for i in 0..cells * fine {
        for j in 0..cells * fine {
            let p = DVec2::new(i as f64 + 0.5, j as f64 + 0.5) * side - lens.radius;
            counts[i / fine * cells + j / fine] += f64::from(u8::from(is_inside(lens, p)));
        }
    }
    let sum: f64 = counts.iter().sum();
    counts.iter_mut().for_each(|count| *count /= sum);
    (counts, sum * side * side)
}

#[test]
fn points_are_uniform_over_the_aperture() {
    let cells = 9;
    for (blades, rotation) in APERTURES {
        let lens = lens(blades, rotation);
        let (expected, area) = shares(&lens, cells);
        assert!((lens.area() / area - 1.0).abs() < 1e-3, "{blades}: {} {area}", lens.area());
        let histogram = |sample: &dyn Fn([f64; 2]) -> DVec2| {
            let mut random = Random::new(31);
            let mut counts = vec![0; cells * cells];
            for _ in 0..200_000 {
                let p = sample(random.two());
                assert!(is_inside(&lens, p * (1.0 - 1e-12)), "{blades}: {p}");
                let cell = |x: f64| (((x / lens.radius + 1.0) * 0.5 * cells as f64) as usize).min(cells - 1);
                counts[cell(p.x) * cells + cell(p.y)] += 1;
            }
            counts
        };
        chi_square(&histogram(&|u| lens.sample(u)), &expected).unwrap();
        // Planted fault: a little denser towards the middle.
        assert!(chi_square(&histogram(&|u| lens.sample(u) * (1.0 - 0.03 * u[1])), &expected).is_err());
    }
}

/// Cameras with a lens and orthographic ones, whole and cropped.
fn others() -> Vec<Camera> {
    let transform = DAffine3::from_translation(DVec3::new(0.3, -2.0, 0.7))
        * DAffine3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.1);
    let lens = Camera::new(transform, 1.2, 320, 200, 2.0).with_lens(lens(5, 0.3));
    let orthographic = Camera::orthographic(transform, 1.7, 320, 200, 2.0);
    let crop = |camera: Camera| camera.cropped(DVec2::new(30.0, 50.0), DVec2::new(130.0, 110.0));
    vec![lens, orthographic, crop(lens), crop(orthographic), crop(Camera::new(transform, 1.2, 320, 200, 2.0))]
}

#[test]
fn lines_of_sight_lead_back_to_their_raster_positions_with_the_jacobian_that_is_stated() {
    for camera in others() {
        let mut random = Random::new(33);
        for _ in 0..1000 {
            let eye = camera.sample_aperture(random.two()).unwrap_or(camera.position());
            let raster = camera.sample_raster(random.two());
            let sight = camera.sight(eye, raster);
            assert!((camera.raster(&sight).unwrap_or(DVec2::NAN) - raster).length() < 1e-9);
            // Any point of the line is seen there.
            let at = |t: f64| Sight { eye, point: sight.eye + sight.direction * t, direction: sight.direction };
            assert!((camera.raster(&at(random.next() + 0.01)).unwrap_or(DVec2::NAN) - raster).length() < 1e-9);
            let h = 1e-4;
            let across = |f: &dyn Fn(Sight) -> DVec3| {
                let along =
                    |d: DVec2| (f(camera.sight(eye, raster + d)) - f(camera.sight(eye, raster - d))) / (2.0 * h);
                along(DVec2::new(h, 0.0)).cross(along(DVec2::new(0.0, h))).length()
            };
            // Of directions, or of points of the film: the other does not change.
            let measure = across(&|s| s.direction).max(across(&|s| s.eye));
            assert!((camera.raster_per_measure(&sight) * measure - 1.0).abs() < 1e-5);
            assert!((camera.pdf_sight(&sight) * measure * camera.domain_area() - 1.0).abs() < 1e-5);
            // W_e times the cosine over the densities of the lens point and of the line of sight.
            let cosine = if camera.has_aperture() { sight.direction.dot(camera.forward()) } else { 1.0 };
            let weight = camera.responsivity(&sight) * cosine / (camera.pdf_aperture() * camera.pdf_sight(&sight));
            assert!((camera.weight(&sight) / weight - 1.0).abs() < 1e-12);
            let share = camera.domain_area() / camera.image_area_pixels();
            assert!((weight / share - 1.0).abs() < 1e-12, "a uniform environment has mean 1: {weight} {share}");
        }
    }
}

#[test]
fn a_lens_sees_the_plane_in_focus_as_the_pinhole_does() {
    let pinhole = camera(0.0);
    let lens = pinhole.with_lens(lens(6, 0.2));
    let mut random = Random::new(34);
    let mut farthest: f64 = 0.0;
    for _ in 0..1000 {
        let raster = pinhole.sample_raster(random.two());
        let through = pinhole.sight(pinhole.position(), raster).direction;
        let eye = lens.sample_aperture(random.two()).unwrap();
        let seen_at = |depth: f64| {
            let point = pinhole.position() + through * (depth / through.dot(pinhole.forward()));
            lens.raster(&Sight { eye, point, direction: (point - eye).normalize() })
        };
        let sharp = seen_at(2.0);
        assert!(sharp.is_none_or(|r| r.distance(raster) < 1e-9) && (sharp.is_some() || raster.min_element() < 1e-9));
        farthest = farthest.max(seen_at(4.0).map_or(0.0, |r| r.distance(raster)));
    }
    // At twice the distance the circle of confusion has the radius of the aperture, seen at the distance in focus, by 1 - 2 / 4.
    let pixels = 0.5 / 2.0 * (1.0 - 2.0 / 4.0) / pinhole.length_per_pixel(1.0);
    assert!(farthest < pixels && farthest > 0.95 * pixels, "{farthest} {pixels}");
}

#[test]
fn a_window_shows_a_part_of_the_same_picture() {
    let transform = DAffine3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.1);
    let corner = DVec2::new(30.0, 50.0);
    for whole in [camera(0.0), camera(0.0).with_lens(lens(0, 0.0)), Camera::orthographic(transform, 2.0, 320, 200, 0.0)]
    {
        let part = whole.cropped(corner, DVec2::new(130.0, 110.0));
        assert_eq!(part.size(), DVec2::new(100.0, 60.0));
        let mut random = Random::new(35);
        for _ in 0..100 {
            let raster = part.sample_raster(random.two());
            let eye = whole.sample_aperture(random.two()).unwrap_or(whole.position());
            let (of_part, of_whole) = (part.sight(eye, raster), whole.sight(eye, raster + corner));
            assert!(
                of_part.direction.distance(of_whole.direction) < 1e-12 && of_part.eye.distance(of_whole.eye) < 1e-12
            );
            // A pixel is as bright in both; the mean is over fewer of them.
            let ratio = part.responsivity(&of_part) * part.image_area_pixels()
                / (whole.responsivity(&of_whole) * whole.image_area_pixels());
            assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
        }
    }
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
