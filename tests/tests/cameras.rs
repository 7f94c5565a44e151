//! Cameras other than the pinhole: thin lenses and orthographic ones, whole and cropped. The laws of mutations and of strategies,
//! methods that agree, and pictures that are known.

use std::f64::consts::TAU;

use ergodic_mutations::{AnyMutation, Bidirectional, Lens as LensPerturbation, Splice};
use ergodic_pathspace::{CameraDescription, Lengths, Path, PathSpace, Projection, Roulette, Scene};
use ergodic_render::{Direct, LensSettings, Method, Settings};
use ergodic_scattering::{Lens, Rgb};
use ergodic_tests::{Estimate, Eye, description, diffuse, estimate, nightly, quad, settings, view_of};
use glam::{DAffine3, DVec2, DVec3};

use crate::mutation_laws::{LENGTHS, check_balance, check_kernels, drift_of};
use crate::rendering;
use crate::strategies::{AGREE, check_connections, disagreement};

/// A scene of the repository seen by its own camera with another projection.
fn space(name: &str, lengths: Lengths, change: impl Fn(Projection) -> Projection) -> PathSpace {
    let mut description = description(name);
    let camera = &mut description.cameras[0];
    camera.projection = change(camera.projection);
    PathSpace { scene: view_of(description, (64, 64)), lengths }
}

/// Glass in front of the plane in focus, a wide aperture.
fn with_lens(name: &str, lengths: Lengths) -> PathSpace {
    space(name, lengths, |projection| match projection {
        Projection::Perspective { vertical_fov, .. } => {
            let lens = Lens { radius: 0.15, focus_distance: 2.0, blades: 5, rotation: 0.3 };
            Projection::Perspective { vertical_fov, lens: Some(lens) }
        }
        other => other,
    })
}

fn orthographic(name: &str, lengths: Lengths) -> PathSpace {
    space(name, lengths, |_| Projection::Orthographic { height: 1.2, near: 0.3 })
}

type MakeSpace = fn(&str, Lengths) -> PathSpace;

const CAMERAS: [(&str, MakeSpace); 2] = [("lens", with_lens), ("orthographic", orthographic)];

#[test]
fn the_way_back_has_support_and_balance_is_detailed() {
    for (camera, make) in CAMERAS {
        for scene in ["glass", "cornell"] {
            check_balance(&format!("{scene} by {camera}"), &make(scene, LENGTHS));
        }
    }
}

#[test]
fn one_step_leaves_the_target_invariant_through_a_lens() {
    check_kernels("glass by lens", &with_lens("glass", LENGTHS), nightly(150_000, 4_000_000));
}

#[test]
fn one_step_leaves_the_target_invariant_before_an_orthographic_camera() {
    check_kernels("glass by orthographic", &orthographic("glass", LENGTHS), nightly(150_000, 4_000_000));
}

#[test]
fn wrong_densities_of_the_lens_are_caught() {
    let space = with_lens("cornell", Lengths { min_edges: 1, max_edges: 4 });
    // The step from solid angle to area at the vertex that a new point of the lens sees.
    let members = vec![AnyMutation::Bidirectional(Bidirectional {})];
    let z = drift_of(&space, members, 150_000, &|_: &Path, to: &Path, (_, plan): (usize, Splice)| {
        if plan.suffix == 0 { -to.edges[to.length() - 1].to_light_side.max(1e-3).ln() } else { 0.0 }
    });
    assert!(z > 8.0, "z = {z}");
    // The same of the lens perturbation, which keeps the point of the lens.
    let z = drift_of(&space, vec![AnyMutation::Lens(LensPerturbation::default())], 150_000, &|_, to: &Path, _| {
        -to.edges[to.length() - 1].to_light_side.ln()
    });
    assert!(z > 8.0, "z = {z}");
}

#[test]
fn every_connection_agrees_with_the_path_seen_from_outside() {
    for (camera, make) in CAMERAS {
        for scene in ["glass", "cornell"] {
            let space = make(scene, LENGTHS);
            let roulette = Roulette { start: 3, survival: 0.6 };
            let (checked, estimate, weight) = check_connections(&space, roulette, 11, nightly(6000, 100_000));
            println!("{scene} by {camera}: {checked} connections, estimate {estimate:.1e}, weight {weight:.1e}");
            assert!(checked > 1000 && estimate < 1e-6 && weight < 1e-6, "{scene} by {camera}: {estimate} {weight}");
        }
    }
}

#[test]
fn single_strategies_agree_per_length() {
    for (camera, make) in CAMERAS {
        let space = make("cornell", Lengths { min_edges: 2, max_edges: 3 });
        let z = disagreement(&space, nightly(300_000, 4_000_000), |_, _| 1.0);
        assert!(z < AGREE, "{camera}: {z}");
        // Light that is connected to the camera, 3 % too much of it.
        let z = disagreement(&space, 1_000_000, |path, s| if s == path.length() { 1.03 } else { 1.0 });
        assert!(z > AGREE, "{camera}: the planted fault passes, {z}");
    }
}

#[test]
fn methods_agree() {
    for (camera, make) in CAMERAS {
        // Path tracing rarely finds light behind glass.
        for (scene, method, samples) in
            [("cornell", Method::Path, nightly(24.0, 48.0)), ("glass", Method::Mlt, nightly(40.0, 150.0))]
        {
            let space = make(scene, LENGTHS);
            let of = |method, samples| {
                let mut settings =
                    Settings { min_edges: 1, max_edges: 6, ..rendering::settings(method, (64, 64), samples) };
                settings.mlt.direct = Direct::InChain;
                settings.mlt.seeding.max_samples = 100_000;
                rendering::replicate(&space.scene, &settings, rendering::REPLICAS)
            };
            let t = rendering::disagreement(&of(Method::Bidirectional, nightly(6.0, 12.0)), &of(method, samples));
            println!("{scene} by {camera}: {method:?} against bidirectional, max |t| {t:.1}");
            assert!(t < rendering::LIMIT, "{scene} by {camera}, {method:?}: {t}");
        }
    }
}

#[test]
fn chains_of_primary_samples_agree_through_a_lens() {
    rendering::check_primary("cornell by lens", &with_lens("cornell", LENGTHS).scene, (64, 64));
}

const SIDE: u32 = 12;
/// What the picture shows at the distance of the lamp is 2 high.
const LAMP_DISTANCE: f64 = 3.0;
const LAMP: (DVec2, DVec2) = (DVec2::new(-0.5, -0.7), DVec2::new(0.8, 0.3));
const WINDOW: (u32, u32, u32, u32) = (1, 2, 9, 10);
const SHOWN: usize = 64;

/// A lamp before black, seen from the origin along -z.
fn lamp(projection: Projection, crop: Option<(u32, u32, u32, u32)>) -> Scene {
    let (low, high) = LAMP;
    let size = high - low;
    let mesh = quad(low.extend(-LAMP_DISTANCE), DVec3::X * size.x, DVec3::Y * size.y);
    // Only the light itself is looked at.
    let eye = Eye { from: DVec3::ZERO, at: DVec3::NEG_Z, up: DVec3::Y, fov: 1.0 };
    let mut description = ergodic_tests::description_of(vec![(mesh, diffuse(0.0, 2.0))], Vec::new(), &eye);
    description.cameras = vec![CameraDescription { name: String::new(), transform: DAffine3::IDENTITY, projection }];
    let settings = Settings { size: (SIDE, SIDE), crop, ..Settings::default() };
    let view = settings.view(description.cameras[0].clone());
    Scene::new(description, &view).unwrap_or_else(|e| panic!("{e}"))
}

/// Points of a fine grid that lie in the aperture, found by its sides.
fn aperture(lens: &Lens) -> Vec<DVec2> {
    const FINE: i32 = 44;
    let corner = |i: u32| DVec2::from_angle(lens.rotation + TAU * f64::from(i) / f64::from(lens.blades));
    let inside = |p: &DVec2| match lens.blades {
        0 => p.length() <= 1.0,
        n => (0..n).all(|i| (corner(i + 1) - corner(i)).perp_dot(*p - corner(i)) >= 0.0),
    };
    let at = |i: i32| (f64::from(i) + 0.5) / f64::from(FINE) * 2.0 - 1.0;
    let grid = (0..FINE * FINE).map(|i| DVec2::new(at(i / FINE), at(i % FINE)));
    grid.filter(inside).map(|p| p * lens.radius).collect()
}

/// The share of the lamp in each pixel of the window: the mean over pixel and aperture of pinhole pictures, each from one point of
/// the lens through the points of the plane in focus.
fn shares(lens: Option<&Lens>) -> Vec<f64> {
    const FINE: u32 = 16;
    let (points, magnified) = match lens {
        None => (vec![DVec2::ZERO], 1.0),
        Some(lens) => (aperture(lens), LAMP_DISTANCE / lens.focus_distance),
    };
    let (left, top, right, bottom) = WINDOW;
    let mut shares = Vec::new();
    for (y, x) in (top..bottom).flat_map(|y| (left..right).map(move |x| (y, x))) {
        let mut seen = 0u32;
        for (i, j) in (0..FINE).flat_map(|i| (0..FINE).map(move |j| (i, j))) {
            let raster =
                |pixel: u32, i: u32| (f64::from(pixel) + (f64::from(i) + 0.5) / f64::from(FINE)) / f64::from(SIDE);
            // Where the line through the middle of the lens meets the lamp's plane; what goes through the point in focus from
            // elsewhere on the lens meets it a little beside.
            let middle = DVec2::new(2.0 * raster(x, i) - 1.0, 1.0 - 2.0 * raster(y, j));
            let on_lamp = |p: &&DVec2| {
                let met = middle + **p * (1.0 - magnified);
                met.cmpge(LAMP.0).all() && met.cmple(LAMP.1).all()
            };
            seen += points.iter().filter(on_lamp).count() as u32;
        }
        shares.push(f64::from(seen) / (f64::from(FINE * FINE) * points.len() as f64));
    }
    shares
}

/// The greatest distance of a pixel in the window from what is expected, beyond the error of the fine grid, in standard errors.
fn farthest(projection: Projection, expected: &[f64], method: Method) -> f64 {
    let scene = lamp(projection, Some(WINDOW));
    let mut settings = settings(method, &(1..=1), SIDE, 800.0);
    (settings.size, settings.crop) = ((SIDE, SIDE), Some(WINDOW));
    let found: [Estimate; SHOWN] = estimate(&scene, &settings, 16, |picture| {
        assert_eq!((picture.width, picture.height), (8, 8));
        std::array::from_fn(|i| picture.pixels[i])
    })
    .unwrap_or_else(|e| panic!("{e}"));
    let z = |(found, share): (&Estimate, &f64)| {
        let truth = 2.0 * share;
        ((found.mean.x - truth).abs() - 4e-3).max(0.0) / found.error.x.max(1e-4)
    };
    found.iter().zip(expected).map(z).fold(0.0, f64::max)
}

fn through(lens: Option<Lens>) -> Projection {
    Projection::Perspective { vertical_fov: 2.0 * (1.0 / LAMP_DISTANCE).atan(), lens }
}

#[test]
fn a_lens_shows_the_mean_of_the_pinholes_in_it() {
    for blades in [0, 5] {
        let lens = Lens { radius: 0.6, focus_distance: 2.0, blades, rotation: 0.4 };
        let expected = shares(Some(&lens));
        for (method, name) in Method::ALL {
            let z = farthest(through(Some(lens)), &expected, method);
            println!("{blades} blades, {name}: z = {z:.1}");
            assert!(z < 6.5, "{blades} blades, {name}: {z}");
            // A lens a tenth narrower would show another picture.
            let wrong = farthest(through(Some(Lens { radius: 0.54, ..lens })), &expected, method);
            assert!(wrong > 6.5, "{blades} blades, {name}: a narrower lens passes, {wrong}");
        }
    }
}

#[test]
fn the_plane_in_focus_is_sharp_and_a_pinhole_and_an_orthographic_camera_are_sharp_everywhere() {
    let sharp = shares(None);
    let lens = Lens { radius: 0.6, focus_distance: LAMP_DISTANCE, blades: 0, rotation: 0.0 };
    let parallel = Projection::Orthographic { height: 2.0, near: 0.5 };
    for (method, name) in Method::ALL {
        for projection in [through(None), through(Some(lens)), parallel] {
            let z = farthest(projection, &sharp, method);
            println!("{name}, {projection:?}: z = {z:.1}");
            assert!(z < 6.5, "{name}, {projection:?}: {z}");
        }
        // Out of focus it is not.
        let blurred = farthest(through(Some(Lens { focus_distance: 2.0, ..lens })), &sharp, method);
        assert!(blurred > 6.5, "{name}: {blurred}");
    }
}

#[test]
fn what_lies_behind_the_film_is_not_seen() {
    let behind = Projection::Orthographic { height: 2.0, near: LAMP_DISTANCE + 0.5 };
    let mut settings = settings(Method::Path, &(1..=1), SIDE, 4.0);
    settings.crop = Some(WINDOW);
    let [mean] = estimate(&lamp(behind, Some(WINDOW)), &settings, 2, |picture| [picture.mean()]).unwrap();
    assert_eq!(mean.mean, Rgb::ZERO);
}

#[test]
fn the_lens_of_the_settings_replaces_that_of_the_file() {
    let file = CameraDescription::pinhole(DAffine3::IDENTITY, 1.0);
    let with = |radius| {
        let lens = LensSettings { radius, focus_distance: 2.0, blades: 0, rotation: 0.0 };
        let settings = Settings { lens: Some(lens), ..Settings::default() };
        match settings.view(file.clone()).camera.projection {
            Projection::Perspective { lens, .. } => lens.map(|lens| lens.radius),
            Projection::Orthographic { .. } => None,
        }
    };
    assert_eq!((with(0.1), with(0.0)), (Some(0.1), None));
}
