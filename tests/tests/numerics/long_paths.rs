//! Paths of many vertices: products of many factors, and weights of many strategies.

use ergodic_metropolis::Density;
use ergodic_pathspace::{Lengths, PathSpace, Roulette, Scene, View};
use ergodic_scattering::Rgb;
use ergodic_tests::{Eye, cuboid, description, diffuse, glass, quad, scene_of};
use glam::DVec3;

use super::{SIDE, check, exactly};

#[test]
fn sixty_four_bounces_in_a_white_box() {
    let eye = Eye { from: DVec3::new(0.3, -0.2, 0.1), at: DVec3::new(-0.9, 0.9, -0.4), up: DVec3::Z, fov: 1.2 };
    let room = (cuboid(DVec3::new(1.0, 1.0, 0.5), true), diffuse(1.0, 1.0));
    let scene = scene_of(vec![room], Vec::new(), &eye, SIDE);
    // Nothing is lost, so the 64th bounce is as bright as the first: 65 edges carry the emission itself.
    check("64 bounces", &scene, 65..=65, [4.0, 0.5, 8.0], &exactly(Rgb::ONE, Rgb::ONE), 0.03);
}

#[test]
fn sixty_four_interfaces_in_a_row() {
    // 32 panes between the eye and a lamp. Each of 64 faces lets 0.96 through, and a path of 65 edges cannot also reflect.
    let mut things = vec![(quad(DVec3::new(-30.0, -30.0, -34.0), DVec3::X * 60.0, DVec3::Y * 60.0), diffuse(0.0, 1.0))];
    for i in 0..32 {
        let mut pane = cuboid(DVec3::new(20.0, 20.0, 0.25), false);
        pane.positions.iter_mut().for_each(|p| p.z -= f64::from(i) + 1.0);
        things.push((pane, glass(1.5)));
    }
    let eye = Eye::over(DVec3::Z, DVec3::ZERO, DVec3::Y, 1e-3);
    let scene = scene_of(things, Vec::new(), &eye, SIDE);
    let radiance = Rgb::splat(0.96_f64.powi(64));
    check("64 interfaces", &scene, 65..=65, [48.0, 16.0, 48.0], &exactly(radiance, radiance), 0.05);
}

#[test]
fn products_of_densities_keep_their_range() {
    // Area densities of a path of 65 vertices in a scene 1e-6 or 1e6 across: far outside the range of f64.
    for exponent in [-30, 30] {
        let factor = 10f64.powi(exponent);
        let (mut product, mut plain) = (Density::ONE, 1.0);
        for _ in 0..65 {
            product.multiply(factor);
            plain *= factor;
        }
        let expected = 65.0 * factor.ln();
        println!("ln of a product of 65 densities {factor:e}: {:.6}, expected {expected:.6}", product.ln());
        assert!((product.ln() / expected - 1.0).abs() < 1e-12);
        // The plain product has lost it.
        assert!(plain == 0.0 || plain == f64::INFINITY);
    }
}

#[test]
fn weights_sum_to_one_where_the_image_has_a_margin() {
    // A wide filter widens the domain of the camera, as a crop window narrows it: both enter every density of the eye.
    for name in ["cornell", "glass"] {
        let scene = description(name);
        let camera = scene.cameras[0].clone();
        let view = View { camera, width: 32, height: 24, margin: 2.5, crop: None };
        let scene = Scene::new(scene, &view).unwrap_or_else(|e| panic!("{e}"));
        let space = PathSpace { scene, lengths: Lengths { min_edges: 1, max_edges: 8 } };
        let pairs = ergodic_tests::nightly(20_000, 1_000_000);
        let (checked, estimate, weight) =
            crate::strategies::check_connections(&space, Roulette { start: 3, survival: 0.6 }, 12, pairs);
        println!("{name}: {checked} connections, estimate off by {estimate:.1e}, weight by {weight:.1e}");
        assert!(estimate < 1e-6 && weight < 1e-6, "{name}: {estimate}, {weight}");
    }
}
