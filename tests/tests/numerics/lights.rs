//! Lights of every kind and size, together and apart; lights that hardly any path reaches.

use std::f64::consts::PI;

use ergodic_geometry::Mesh;
use ergodic_pathspace::{Path, Scene, contribution};
use ergodic_render::{Method, Purpose, RenderError, Unobserved, render, stream};
use ergodic_scattering::{PunctualLight, Rgb, Wavelength};
use ergodic_tests::{Estimate, Eye, Thing, cuboid, diffuse, glass, nightly, quad, scene_of};
use glam::DVec3;

use super::{Means, SIDE, check, exactly, means, plane_means, settings};

const ALBEDO: f64 = 0.6;

/// A floor and a wall, seen from above.
fn corner() -> (Vec<Thing>, Eye) {
    let floor = quad(DVec3::new(-2.0, -2.0, 0.0), DVec3::X * 4.0, DVec3::Y * 4.0);
    let wall = quad(DVec3::new(-2.0, 2.0, 0.0), DVec3::X * 4.0, DVec3::Z * 2.0);
    let eye = Eye { from: DVec3::new(0.3, -1.8, 1.6), at: DVec3::new(0.0, 1.0, 0.3), up: DVec3::Z, fov: 0.9 };
    (vec![(floor, diffuse(ALBEDO, 0.0)), (wall, diffuse(ALBEDO, 0.0))], eye)
}

/// The kinds of light: an emitter or a punctual light.
enum Light {
    Area(Box<Thing>),
    Punctual(PunctualLight),
}

fn light(kind: usize) -> (&'static str, Light) {
    let position = DVec3::new(-0.7, 0.2, 1.2);
    match kind {
        0 => ("point", Light::Punctual(PunctualLight::Point { position, intensity: Rgb::new(1.0, 0.6, 0.3) })),
        1 => {
            let axis = DVec3::new(0.5, 0.5, -1.0).normalize();
            let intensity = Rgb::new(0.3, 1.2, 0.5);
            (
                "spot",
                Light::Punctual(PunctualLight::Spot {
                    position: DVec3::new(0.4, -0.3, 1.4),
                    axis,
                    intensity,
                    cos_inner: 0.95,
                    cos_outer: 0.7,
                }),
            )
        }
        2 => {
            let direction = DVec3::new(-0.2, 0.7, -0.6).normalize();
            (
                "directional",
                Light::Punctual(PunctualLight::Directional { direction, irradiance: Rgb::new(0.4, 0.5, 0.9) }),
            )
        }
        _ => {
            let lamp = quad(DVec3::new(0.2, 0.2, 1.8), DVec3::Y * 0.6, DVec3::X * 0.6);
            ("area", Light::Area(Box::new((lamp, diffuse(0.0, 3.0)))))
        }
    }
}

fn lit_by(kinds: &[usize]) -> Scene {
    let (mut things, eye) = corner();
    let mut lights = Vec::new();
    for kind in 0..4 {
        match light(kind).1 {
            // A lamp that is switched off still casts its shadow.
            Light::Area(lamp) => {
                let (mesh, lamp) = *lamp;
                things.push((mesh, if kinds.contains(&kind) { lamp } else { diffuse(0.0, 0.0) }));
            }
            Light::Punctual(punctual) if kinds.contains(&kind) => lights.push(punctual),
            Light::Punctual(_) => {}
        }
    }
    scene_of(things, lights, &eye, SIDE)
}

#[test]
fn two_lights_together_are_the_sum_of_each_alone() {
    let edges = 2..=4;
    let alone: Vec<Means> =
        (0..4).map(|kind| means(&lit_by(&[kind]), &settings(Method::Bidirectional, &edges, 64.0))).collect();
    for (kind, expected) in alone.iter().enumerate() {
        check(light(kind).0, &lit_by(&[kind]), edges.clone(), [64.0, 0.0, 192.0], expected, 0.02);
    }
    let pairs = [(0, 1), (2, 3), (1, 2), (0, 2), (0, 3), (1, 3)];
    for (a, b) in pairs.into_iter().take(nightly(3, 6)) {
        let both = lit_by(&[a, b]);
        let sum: Means = std::array::from_fn(|i| {
            let (a, b) = (alone[a][i], alone[b][i]);
            Estimate { mean: a.mean + b.mean, error: (a.error * a.error + b.error * b.error).map(f64::sqrt) }
        });
        let what = format!("{} and {}", light(a).0, light(b).0);
        check(&what, &both, edges.clone(), [64.0, 64.0, 192.0], &sum, 0.02);
        let picture =
            render(&both, &settings(Method::Bidirectional, &edges, 64.0), &Unobserved).expect("valid settings").picture;
        let mut values: Vec<f64> = picture.pixels.iter().map(|p| p.element_sum()).collect();
        values.sort_by(f64::total_cmp);
        let ratio = values[values.len() - 1] / values[values.len() / 2];
        println!("{what}: brightest pixel over median {ratio:.1}");
        assert!(ratio < 50.0, "{what}: a firefly, {ratio}");
    }
}

/// A point light and a sun in the middle of the picture: a Dirac on the image that only a connection of light and eye could find.
#[test]
fn lights_without_extent_are_not_seen_themselves() {
    let floor = || (quad(DVec3::new(-1.0, -1.0, 0.0), DVec3::X * 2.0, DVec3::Y * 2.0), diffuse(ALBEDO, 0.0));
    let at = DVec3::new(0.0, 0.0, 0.3);
    let eye = Eye::over(DVec3::new(0.0, -4.0, 0.3), at, DVec3::Z, 0.7);
    let point = PunctualLight::Point { position: at, intensity: Rgb::ONE };
    // Five degrees above the horizon, half way to the upper edge.
    let sun =
        PunctualLight::Directional { direction: DVec3::new(0.0, -0.9962, -0.0872).normalize(), irradiance: Rgb::ONE };
    for (name, light) in [("point", point), ("sun", sun)] {
        let scene = scene_of(vec![floor()], vec![light], &eye, SIDE);
        let seen = means(&scene, &settings(Method::Path, &(1..=3), 256.0));
        assert!(seen[0].mean.x > 0.0);
        check(name, &scene, 1..=3, [0.0, 64.0, 192.0], &seen, 0.02);
        let mut light = scene.camera_vertex();
        scene.sample_emitter(Wavelength::NONE, &mut light, &mut stream(1, Purpose::Chain, 0));
        let direct = Path::of(&scene, vec![light, scene.camera_vertex()]);
        assert_eq!(contribution(&direct).rgb, Rgb::ZERO, "{name}");
    }
}

/// Radiance of the floor under a small patch that emits an intensity downwards with the cosine.
fn under_patch(intensity: f64, height: f64, p: DVec3) -> Rgb {
    let squared = p.truncate().length_squared() + height * height;
    let cos = height / squared.sqrt();
    Rgb::splat(ALBEDO / PI * intensity * cos * cos / squared)
}

#[test]
fn a_light_of_a_micrometre_is_a_point() {
    let (side, intensity) = (1e-6, 2.0);
    let floor = (quad(DVec3::new(-1.0, -1.0, 0.0), DVec3::X * 2.0, DVec3::Y * 2.0), diffuse(ALBEDO, 0.0));
    let half = 0.5 * side;
    let lamp = quad(DVec3::new(-half, -half, 1.0), DVec3::Y * side, DVec3::X * side);
    let emission = intensity / (side * side);
    let eye = Eye::over(DVec3::new(0.3, 0.0, 0.8), DVec3::new(0.3, 0.0, 0.0), DVec3::Y, 0.6);
    let scene = scene_of(vec![floor, (lamp, diffuse(0.0, emission))], Vec::new(), &eye, SIDE);
    let truth = plane_means(|p| under_patch(intensity, 1.0, eye.sees(p)));
    check("a light of 1e-6", &scene, 2..=2, [16.0, 16.0, 256.0], &truth, 0.005);
}

#[test]
fn a_light_of_a_thousand_kilometres_is_a_sky() {
    let (side, emission) = (1e6, 1.5);
    let floor = (quad(DVec3::new(-1.0, -1.0, 0.0), DVec3::X * 2.0, DVec3::Y * 2.0), diffuse(ALBEDO, 0.0));
    let sky = quad(DVec3::new(-0.5 * side, -0.5 * side, 2.0), DVec3::Y * side, DVec3::X * side);
    let eye = Eye::over(DVec3::new(0.4, 0.2, 1.0), DVec3::ZERO, DVec3::Z, 0.2);
    let scene = scene_of(vec![floor, (sky, diffuse(0.0, emission))], Vec::new(), &eye, SIDE);
    // The floor sees nothing else.
    let radiance = Rgb::splat(ALBEDO * emission);
    check("a light of 1e6", &scene, 2..=2, [16.0, 16.0, 256.0], &exactly(radiance, radiance), 0.005);
}

#[test]
fn the_size_of_the_scene_does_not_matter_to_a_directional_light() {
    let edges = 2..=4;
    let near = means(&lit_by(&[2]), &settings(Method::Bidirectional, &edges, 64.0));
    for far in [1e3, 1e6] {
        let (mut things, eye) = corner();
        let Light::Area(lamp) = light(3).1 else { unreachable!("the last light is a lamp") };
        things.push((lamp.0, diffuse(0.0, 0.0)));
        // A speck so far away that the scene's bounding sphere, which light is sent through, is that much wider.
        let speck = quad(DVec3::new(far, 0.0, -far), DVec3::X * 1e-3, DVec3::Y * 1e-3);
        things.push((speck, diffuse(ALBEDO, 0.0)));
        let Light::Punctual(sun) = light(2).1 else { unreachable!("the third light is directional") };
        let scene = scene_of(things, vec![sun], &eye, SIDE);
        check(&format!("a speck at {far:e}"), &scene, edges.clone(), [64.0, 64.0, 192.0], &near, 0.03);
    }
}

#[test]
fn saturated_lights_keep_their_colours() {
    let (mut things, eye) = corner();
    let mut lights = Vec::new();
    for (i, position) in
        [DVec3::new(-1.0, 0.0, 1.0), DVec3::new(0.0, 0.5, 1.3), DVec3::new(1.0, 0.0, 1.0)].into_iter().enumerate()
    {
        let mut colour = Rgb::ZERO;
        colour[i] = 1.0;
        lights.push(PunctualLight::Point { position, intensity: colour });
    }
    // Blue counts for 7 % of the luminance that chains sample by, and a blue wall sees it alone.
    things[1].1.base_color = Rgb::new(0.0, 0.05, 0.9);
    let scene = scene_of(things, lights, &eye, SIDE);
    let expected = means(&scene, &settings(Method::Bidirectional, &(2..=4), 256.0));
    check("saturated lights", &scene, 2..=4, [128.0, 0.0, 1024.0], &expected, 0.02);
}

#[test]
fn an_emitter_given_twice_shines_once() {
    let lamp = || quad(DVec3::new(0.2, 0.2, 1.8), DVec3::Y * 0.6, DVec3::X * 0.6);
    let mut turned = lamp();
    turned.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let mut twice = lamp();
    twice.triangles.extend(lamp().triangles);
    let picture = |lamps: Vec<Mesh>, method| {
        let (mut things, eye) = corner();
        things.extend(lamps.into_iter().map(|mesh| (mesh, diffuse(0.0, 3.0))));
        render(&scene_of(things, Vec::new(), &eye, SIDE), &settings(method, &(1..=4), 16.0), &Unobserved)
            .expect("valid settings")
            .picture
    };
    for (method, name) in Method::ALL {
        let once = picture(vec![lamp()], method);
        // To the bit: the copies are neither hit nor chosen.
        assert_eq!(once, picture(vec![twice.clone()], method), "{name}: twice in one mesh");
        assert_eq!(once, picture(vec![lamp(), lamp()], method), "{name}: two meshes");
        assert_eq!(once, picture(vec![lamp(), turned.clone()], method), "{name}: one of two turned over");
    }
}

#[test]
fn a_light_that_no_path_reaches_is_an_error_of_the_chains_and_black_otherwise() {
    // A point light and the eye, each inside glass: no walk hits either, and between them is one surface only that could be
    // connected, to neither of them.
    let (mut things, eye) = corner();
    let lamp = DVec3::new(0.0, 0.5, 1.0);
    for (half, at) in [(0.2, lamp), (0.05, eye.from)] {
        let mut shell = cuboid(DVec3::splat(half), false);
        shell.positions.iter_mut().for_each(|p| *p += at);
        things.push((shell, glass(1.5)));
    }
    let light = PunctualLight::Point { position: lamp, intensity: Rgb::ONE };
    let scene = scene_of(things, vec![light], &eye, SIDE);
    for method in [Method::Path, Method::Bidirectional] {
        let picture = render(&scene, &settings(method, &(1..=4), 16.0), &Unobserved).expect("valid settings").picture;
        assert!(picture.pixels.iter().all(|p| *p == Rgb::ZERO));
    }
    let error = render(&scene, &settings(Method::Mlt, &(1..=4), 16.0), &Unobserved).unwrap_err();
    println!("{error}");
    assert!(matches!(error, RenderError::Dark(_)), "{error}");
}

#[test]
fn one_path_in_a_million_is_found_in_its_share_of_the_seeds() {
    // A lamp behind glass that covers 1e-6 of the image: only a walk from the eye that goes there finds it.
    let share: f64 = 1e-6;
    let side = share.sqrt();
    let lamp = quad(DVec3::new(0.1, 0.2, -2.0), DVec3::X * side * 2.0, DVec3::Y * side * 2.0);
    let mut pane = cuboid(DVec3::new(3.0, 3.0, 1e-6), false);
    pane.positions.iter_mut().for_each(|p| p.z -= 1.0);
    let eye = Eye { from: DVec3::ZERO, at: DVec3::NEG_Z * 2.0, up: DVec3::Y, fov: 2.0 * 0.5_f64.atan() };
    let scene = scene_of(vec![(lamp, diffuse(0.0, 1.0)), (pane, glass(1.5))], Vec::new(), &eye, SIDE);
    let replicas = nightly(8, 64);
    let (mut b, mut found, mut dark, mut samples) = (Vec::new(), 0, 0, 0);
    for seed in 0..replicas {
        let mut settings = settings(Method::Mlt, &(3..=3), 16.0);
        settings.seed = seed;
        settings.mlt.seeding.max_samples = 1 << 20;
        settings.mlt.seeding.relative_error = 1e-6;
        match render(&scene, &settings, &Unobserved) {
            Ok(rendering) => {
                let report = rendering.mlt.expect("this is Metropolis light transport");
                assert!(rendering.picture.pixels.iter().all(|p| p.is_finite()));
                // The error of b is told: of n rare paths it is 1 / sqrt n.
                assert!(report.b_relative_error > 0.3, "{}", report.b_relative_error);
                samples += report.seeding_samples;
                b.push(report.b);
                found += 1;
            }
            Err(RenderError::Dark(_)) => {
                samples += 1 << 20;
                b.push(0.0);
                dark += 1;
            }
            Err(other) => panic!("{other}"),
        }
    }
    // Through two faces of 0.04 at nearly normal incidence.
    let truth = share * 0.96_f64.powi(2);
    let mean = b.iter().sum::<f64>() / b.len() as f64;
    let expected_paths = samples as f64 * share;
    println!(
        "{found} seedings found a path, {dark} did not; b = {mean:.2e}, truth {truth:.2e}, {expected_paths:.1} paths expected"
    );
    assert!(found > 0);
    assert!((mean / truth - 1.0).abs() < 4.0 / expected_paths.sqrt(), "{mean} {truth}");
}

#[test]
fn light_at_grazing_incidence_keeps_its_falloff() {
    // A point light 1e-7 above the floor: cosines of 1e-7 at half a unit.
    let height = 1e-7;
    let floor = (quad(DVec3::new(-1.0, -1.0, 0.0), DVec3::X * 2.0, DVec3::Y * 2.0), diffuse(ALBEDO, 0.0));
    let light = PunctualLight::Point { position: DVec3::Z * height, intensity: Rgb::splat(1e7) };
    let eye = Eye::over(DVec3::new(0.6, 0.0, 0.5), DVec3::new(0.6, 0.0, 0.0), DVec3::Y, 0.2);
    let scene = scene_of(vec![floor.clone()], vec![light], &eye, SIDE);
    let truth = plane_means(|p| {
        let squared = eye.sees(p).truncate().length_squared() + height * height;
        Rgb::splat(ALBEDO / PI * 1e7 * height / squared.powf(1.5))
    });
    check("a light 1e-7 above the floor", &scene, 2..=2, [32.0, 32.0, 512.0], &truth, 0.01);
    // The eye so low: what it sees of the floor is lit evenly by a sky that hides all else.
    let sky = quad(DVec3::new(-50.0, -50.0, 0.1), DVec3::Y * 100.0, DVec3::X * 100.0);
    let eye = Eye { from: DVec3::new(-0.9, 0.0, height), at: DVec3::ZERO, up: DVec3::Z, fov: 1e-7 };
    let scene = scene_of(vec![floor, (sky, diffuse(0.0, 1.0))], Vec::new(), &eye, SIDE);
    let lit = exactly(Rgb::splat(ALBEDO), Rgb::splat(ALBEDO));
    check("an eye 1e-7 above the floor", &scene, 2..=2, [32.0, 32.0, 512.0], &lit, 0.01);
}
