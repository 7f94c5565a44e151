//! Light from the environment: closed forms, strategies, the laws of mutations and whole renders, with the faults that they see.
//!
//! - A convex body that absorbs nothing is invisible in an environment of one radiance.
//! - A Lambert surface of albedo a under an environment L(y) = l + m y above its horizon has radiance a (l + 2 m / 3), because
//!   its irradiance is the integral of 2 pi L(y) y dy over 0 .. 1.
//! - An environment whose light comes from a small spot is a directional light of the same irradiance.

use std::f64::consts::PI;

use ergodic_geometry::Mesh;
use ergodic_laws::faults::Scaled;
use ergodic_mutations::{AnyMutation, Bidirectional, Caustic, Splice};
use ergodic_pathspace::{Kind, Lengths, Path, PathSpace, Roulette, Scene};
use ergodic_scattering::{Component, Environment, Material, Rgb};
use ergodic_tests::{Eye, Thing, cuboid, description_of, diffuse, glass, mirror, nightly, quad, sphere, view_of};
use glam::DVec3;

use crate::closed_forms::{SIDE, USUAL, check};
use crate::mutation_laws::{ALPHA, CAUGHT, check_kernels, drifts, mixture};
use crate::rendering::check_methods;
use crate::strategies::{AGREE, check_connections, disagreement};

/// Things under an environment.
fn under(environment: Environment, things: Vec<Thing>, eye: &Eye, side: u32) -> Scene {
    let mut description = description_of(things, Vec::new(), eye);
    description.environment = Some(environment);
    view_of(description, (side, side))
}

fn moved(mut mesh: Mesh, by: DVec3) -> Mesh {
    mesh.positions.iter_mut().for_each(|p| *p += by);
    mesh
}

#[test]
fn what_absorbs_nothing_is_invisible_in_an_even_environment() {
    let eye = Eye { from: DVec3::new(1.0, 2.0, 4.0), at: DVec3::ZERO, up: DVec3::Y, fov: 0.6 };
    let radiance = Rgb::new(0.5, 1.0, 2.0);
    let even = || Environment::constant(radiance);
    let ball = |material| vec![(sphere(DVec3::ZERO, 1.0, 32, false), material)];
    check("white ball", &under(even(), ball(diffuse(1.0, 0.0)), &eye, SIDE), 1..=2, USUAL, |_| radiance);
    check("mirror ball", &under(even(), ball(mirror()), &eye, SIDE), 1..=2, USUAL, |_| radiance);
    // What is reflected inside more than 18 times is 1e-6 of the light, but where faces are met at a grazing angle.
    let block = vec![(cuboid(DVec3::new(0.8, 0.5, 0.6), false), glass(1.5))];
    check("glass block", &under(even(), block, &eye, SIDE), 1..=20, USUAL, |_| radiance);
    // Two that see each other, and each other's light, up to what 12 edges leave.
    let mut pair = ball(diffuse(1.0, 0.0));
    pair.push((sphere(DVec3::new(1.6, -0.9, 0.8), 0.7, 32, false), mirror()));
    check("two balls", &under(even(), pair, &eye, SIDE), 1..=12, USUAL, |_| radiance);
}

/// A floor from straight above.
fn floor(albedo: f64) -> (Vec<Thing>, Eye) {
    let floor = quad(DVec3::new(-3.0, 0.0, -3.0), DVec3::Z * 6.0, DVec3::X * 6.0);
    (vec![(floor, diffuse(albedo, 0.0))], Eye::over(DVec3::new(0.3, 2.0, 0.2), DVec3::ZERO, DVec3::NEG_Z, 1.0))
}

#[test]
fn a_floor_gathers_the_sky_above_it() {
    let albedo = 0.6;
    let (things, eye) = floor(albedo);
    let even = under(Environment::constant(Rgb::splat(2.0)), things.clone(), &eye, SIDE);
    check("even sky", &even, 1..=3, USUAL, |_| Rgb::splat(albedo * 2.0));
    // Brighter towards the zenith, linear in y as it is read between the rows of a map. The cap within the first row is
    // constant, and 8e-5 of the sky at 256 rows.
    let (horizon, zenith) = (0.5, 2.0);
    let rows = 256;
    let texels = (0..rows).flat_map(|j| {
        let y = (PI * (f64::from(j) + 0.5) / f64::from(rows)).cos();
        [(horizon + (zenith - horizon) * y.max(0.0)) as f32; 3]
    });
    let sky = Environment::map(1, rows, texels.collect(), 1.0, 0.0).unwrap();
    let radiance = albedo * (horizon + (zenith - horizon) * 2.0 / 3.0);
    check("sky with a gradient", &under(sky, things, &eye, SIDE), 2..=2, USUAL, |_| Rgb::splat(radiance));
}

#[test]
fn a_small_sun_is_a_directional_light() {
    let albedo = 0.5;
    let (things, eye) = floor(albedo);
    // One texel of 0.35 degrees, whose tent is symmetric about its centre, 40 degrees from the zenith.
    let (width, height, row, column, rotation) = (1024, 512, 113, 700, 25.0);
    let mut texels = vec![0.0; 3 * width * height];
    texels[3 * (row * width + column)..][..3].copy_from_slice(&[30000.0, 20000.0, 10000.0]);
    let sun = Environment::map(width as u32, height as u32, texels, 1.0, rotation).unwrap();
    let cosine = (PI * (row as f64 + 0.5) / height as f64).cos();
    let irradiance = sun.mean() * (4.0 * PI) * cosine;
    check("sun", &under(sun.clone(), things.clone(), &eye, SIDE), 2..=2, USUAL, |_| irradiance * (albedo / PI));

    // A wall stands in its light, or does not: the azimuth is the one that is documented.
    let azimuth = ((column as f64 + 0.5) / width as f64 - 0.5) * 2.0 * PI - f64::to_radians(rotation);
    let towards = DVec3::new(azimuth.cos(), 0.0, azimuth.sin());
    let across = towards.cross(DVec3::Y);
    for (side, seen) in [(1.0, Rgb::ZERO), (-1.0, irradiance * (albedo / PI))] {
        let wall = quad(towards * (2.5 * side) - across * 6.0, across * 12.0, DVec3::Y * 20.0);
        let mut things = things.clone();
        things.push((wall, diffuse(0.0, 0.0)));
        let scene = under(sun.clone(), things, &eye, SIDE);
        if seen == Rgb::ZERO {
            let settings = ergodic_tests::settings(ergodic_render::Method::Bidirectional, &(2..=2), SIDE, 16.0);
            let picture = ergodic_render::render(&scene, &settings, &ergodic_render::Unobserved).unwrap().picture;
            assert!(picture.pixels.iter().all(|pixel| *pixel == Rgb::ZERO));
        } else {
            check("sun beside a wall", &scene, 2..=2, USUAL, |_| seen);
        }
    }
}

/// A sky with a sun, black and bright texels; the ground is half as bright.
fn sky() -> Environment {
    let (width, height) = (16, 8);
    let texel = |(j, i): (u32, u32)| match (j, i) {
        (2, 5) => [20.0, 17.0, 14.0],
        (3, 9 | 10) => [0.0; 3],
        (4.., _) => [0.2, 0.25, 0.3],
        _ => [0.4, 0.6, 0.5 + 0.1 * j as f32],
    };
    let texels = (0..height).flat_map(|j| (0..width).map(move |i| (j, i))).flat_map(texel).collect();
    Environment::map(width, height, texels, 1.0, 40.0).expect("as many texels as it says")
}

/// Balls of glass, mirror and glossy metal on a floor under [`sky`], and a lamp if there is to be one.
fn garden(lamp: bool, side: u32, lengths: Lengths) -> PathSpace {
    let glossy = Material { metallic: 1.0, roughness: 0.4, base_color: Rgb::new(0.9, 0.7, 0.4), ..Material::default() };
    let mut things = vec![
        (quad(DVec3::new(-2.0, 0.0, -2.0), DVec3::Z * 4.0, DVec3::X * 4.0), diffuse(0.6, 0.0)),
        (sphere(DVec3::new(-1.0, 0.51, 0.0), 0.5, 24, false), mirror()),
        (sphere(DVec3::new(0.1, 0.51, 0.7), 0.5, 24, false), glass(1.5)),
        (sphere(DVec3::new(0.6, 0.51, -0.6), 0.5, 24, false), glossy),
        (moved(cuboid(DVec3::new(0.3, 0.4, 0.3), false), DVec3::new(1.4, 0.41, 0.4)), diffuse(0.8, 0.0)),
    ];
    if lamp {
        things.push((quad(DVec3::new(-0.4, 2.0, -0.4), DVec3::X * 0.8, DVec3::Z * 0.8), diffuse(0.0, 8.0)));
    }
    let eye = Eye { from: DVec3::new(0.5, 1.6, 4.0), at: DVec3::new(0.1, 0.5, 0.0), up: DVec3::Y, fov: 0.8 };
    PathSpace { scene: under(sky(), things, &eye, side), lengths }
}

const LENGTHS: Lengths = Lengths { min_edges: 1, max_edges: 7 };

#[test]
fn every_connection_agrees_with_the_path_seen_from_outside() {
    for lamp in [false, true] {
        let space = garden(lamp, 32, LENGTHS);
        for roulette in [Roulette::OFF, Roulette { start: 3, survival: 0.6 }] {
            let (checked, estimate, weight) = check_connections(&space, roulette, 13, nightly(6000, 100_000));
            println!("{checked} connections, estimate {estimate:.1e}, weight {weight:.1e}");
            assert!(checked > 5000, "only {checked} connections");
            assert!(estimate < 1e-6, "estimate and f / p differ by {estimate}");
            assert!(weight < 1e-6, "weights do not sum to 1, by {weight}");
        }
    }
}

/// A box and a lamp on a floor, all diffuse, so that every strategy makes every path.
fn yard(lamp: bool, lengths: Lengths) -> PathSpace {
    let (mut things, _) = floor(0.7);
    things.push((moved(cuboid(DVec3::new(0.5, 0.5, 0.5), false), DVec3::Y * 0.51), diffuse(0.8, 0.0)));
    if lamp {
        things.push((quad(DVec3::new(1.0, 2.0, -0.4), DVec3::X * 0.8, DVec3::Z * 0.8), diffuse(0.2, 8.0)));
    }
    let eye = Eye { from: DVec3::new(1.5, 2.0, 4.0), at: DVec3::new(0.0, 0.4, 0.0), up: DVec3::Y, fov: 0.8 };
    PathSpace { scene: under(sky(), things, &eye, 64), lengths }
}

#[test]
fn single_strategies_agree_per_length() {
    for lamp in [false, true] {
        let space = yard(lamp, Lengths { min_edges: 1, max_edges: 4 });
        let z = disagreement(&space, nightly(400_000, 4_000_000), |_, _| 1.0);
        assert!(z < AGREE, "{z}");
    }
}

/// Faults of single strategies: the cosine that belongs to the environment's disk left out where light starts on it, or taken
/// twice where rays escape.
#[test]
fn a_lost_cosine_is_caught() {
    let space = yard(false, Lengths { min_edges: 2, max_edges: 2 });
    let cosine = |path: &Path| path.edges[0].to_eye_side;
    let z = disagreement(&space, 200_000, |path, s| if s == 2 { 1.0 / cosine(path) } else { 1.0 });
    assert!(z > 1.5 * AGREE, "{z}");
    let z = disagreement(&space, 200_000, |path, s| if s == 0 { cosine(path) } else { 1.0 });
    assert!(z > 1.5 * AGREE, "{z}");
}

#[test]
fn one_step_leaves_the_target_invariant_under_an_environment() {
    check_kernels("garden", &garden(false, 64, LENGTHS), nightly(150_000, 4_000_000));
}

#[test]
fn one_step_leaves_the_target_invariant_under_an_environment_and_a_lamp() {
    check_kernels("garden with a lamp", &garden(true, 64, LENGTHS), nightly(150_000, 4_000_000));
}

#[test]
fn a_direction_measured_as_an_area_is_caught() {
    // Short paths only: longer ones come with weights so uneven that they hide it.
    let space = yard(true, Lengths { min_edges: 1, max_edges: 3 });
    // As if the projected solid angle were the measure of the environment's new directions.
    let factor = |_: &Path, to: &Path, (_, plan): (usize, Splice)| {
        if plan.prefix == 0 && to.vertices[0].kind == Kind::Environment { 1.0 / to.edges[0].geometry } else { 1.0 }
    };
    let kernels = [Scaled { mutation: mixture(vec![AnyMutation::Bidirectional(Bidirectional {})]), factor }];
    let (law, _) = &drifts(&space, &kernels, 600_000, 29)[0];
    let z = law.verdict(ALPHA).max_t;
    println!("z = {z}");
    assert!(z > CAUGHT, "z = {z}");
}

#[test]
fn a_shift_measured_across_the_light_is_caught() {
    let space = yard(false, Lengths { min_edges: 2, max_edges: 2 });
    // Without the step from the plane across the light to the surface that it meets. Large shifts, to surfaces that face elsewhere.
    let factor = |_: &Path, to: &Path, _: (usize, Splice)| 1.0 / to.edges[0].to_eye_side;
    let large = Caustic { min_pixels: 2.0, image_share: 1.0 };
    let kernels = [Scaled { mutation: mixture(vec![AnyMutation::Caustic(large)]), factor }];
    let (law, _) = &drifts(&space, &kernels, 500_000, 31)[0];
    let z = law.verdict(ALPHA).max_t;
    println!("z = {z}");
    assert!(z > CAUGHT, "z = {z}");
}

/// What the laws above are about is there: paths that start at the environment, at the lamp, and go through every component.
#[test]
fn the_garden_has_all_kinds_of_paths() {
    let space = garden(true, 64, LENGTHS);
    let mut source = ergodic_tests::PathSource::new(&space);
    let mut rng = ergodic_render::stream(7, ergodic_render::Purpose::Chain, 6);
    let mut path = Path::default();
    let mut seen = [0u32; 6];
    for _ in 0..20_000 {
        if source.draw(&mut path, &mut rng).is_none() {
            continue;
        }
        let k = path.length();
        let environment = path.vertices[0].kind == Kind::Environment;
        let first = path.vertices[1].component;
        seen[0] += u32::from(!environment);
        seen[1] += u32::from(environment && k == 1);
        seen[2] += u32::from(environment && k > 1 && first == Component::Rough);
        seen[3] += u32::from(environment && k > 1 && first == Component::DiracReflection);
        seen[4] += u32::from(environment && k > 1 && first == Component::DiracTransmission);
        seen[5] +=
            u32::from(environment && path.vertices[1..k].iter().all(|v| v.component != Component::Rough) && k > 2);
    }
    println!("{seen:?}");
    assert!(seen.iter().all(|count| *count > 50), "{seen:?}");
}

#[test]
fn all_methods_agree_under_an_environment() {
    check_methods("garden", &garden(false, 32, LENGTHS).scene);
}

#[test]
fn all_methods_agree_under_an_environment_and_a_lamp() {
    check_methods("garden with a lamp", &garden(true, 32, LENGTHS).scene);
}
