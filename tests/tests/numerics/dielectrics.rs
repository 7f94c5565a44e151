//! Refracting solids: radiance inside them, total internal reflection, solids in and against each other.

use std::f64::consts::PI;

use ergodic_geometry::Mesh;
use ergodic_render::Method;
use ergodic_scattering::{Material, PunctualLight, Rgb};

use ergodic_tests::{Estimate, Eye, Thing, cuboid, diffuse, glass, quad, scene_of};
use glam::DVec3;

use super::{SIDE, check, means, plane_means, settings};

fn moved(mut mesh: Mesh, by: DVec3) -> Mesh {
    mesh.positions.iter_mut().for_each(|p| *p += by);
    mesh
}

/// Fresnel's unpolarised reflectance from inside, `cos` the cosine there.
fn fresnel_from_inside(ior: f64, cos: f64) -> f64 {
    let sin_outside = ior * (1.0 - cos * cos).sqrt();
    if sin_outside >= 1.0 {
        return 1.0;
    }
    let cos_outside = (1.0 - sin_outside * sin_outside).sqrt();
    let perpendicular = (ior * cos - cos_outside) / (ior * cos + cos_outside);
    let parallel = (cos - ior * cos_outside) / (cos + ior * cos_outside);
    0.5 * (perpendicular.powi(2) + parallel.powi(2))
}

#[test]
fn radiance_grows_by_the_index_squared_up_to_total_reflection() {
    let (ior, emission) = (1.33, 1.0);
    let water = moved(cuboid(DVec3::new(4.0, 4.0, 2.0), false), DVec3::NEG_Z * 2.0);
    // A sky right above the surface, so wide that every ray that leaves meets it.
    let sky = quad(DVec3::new(-200.0, -200.0, 0.1), DVec3::Y * 400.0, DVec3::X * 400.0);
    // The eye is under water; its picture holds the rim where reflection becomes total, at 48.75 degrees.
    let eye = Eye { from: DVec3::NEG_Z, at: DVec3::new(0.8, 0.0, 0.0), up: DVec3::Y, fov: 0.9 };
    let scene = scene_of(vec![(water, glass(ior)), (sky, diffuse(0.0, emission))], Vec::new(), &eye, SIDE);
    let axes_to = |p: glam::DVec2| (eye.sees(p) - eye.from).normalize();
    let truth = plane_means(|p| {
        let reflectance = fresnel_from_inside(ior, axes_to(p).z);
        Rgb::splat(emission * ior * ior * (1.0 - reflectance))
    });
    let seen = [0.05, 0.95].map(|x| fresnel_from_inside(ior, axes_to(glam::DVec2::new(x, 0.5)).z));
    assert!(seen.contains(&1.0) && seen.iter().any(|r| *r < 0.1), "{seen:?}");
    check("under water", &scene, 2..=2, [64.0, 64.0, 1024.0], &truth, 0.01);
}

#[test]
fn light_into_water_is_the_same_from_either_end() {
    // The bed of a pool, its lamp and its eye: the eye is under water, the lamp is not.
    let water = moved(cuboid(DVec3::new(2.0, 2.0, 1.0), false), DVec3::NEG_Z);
    let bed = quad(DVec3::new(-1.5, -1.5, -1.8), DVec3::X * 3.0, DVec3::Y * 3.0);
    let lamp = quad(DVec3::new(-0.5, -0.5, 0.5), DVec3::Y, DVec3::X);
    let eye = Eye { from: DVec3::new(0.8, 0.3, -0.4), at: DVec3::new(0.0, 0.0, -1.8), up: DVec3::Z, fov: 0.6 };
    let things = vec![(water, glass(1.33)), (bed, diffuse(0.7, 0.0)), (lamp, diffuse(0.0, 5.0))];
    let scene = scene_of(things, Vec::new(), &eye, SIDE);
    let expected = means(&scene, &settings(Method::Path, &(3..=3), 512.0));
    check("the bed of a pool", &scene, 3..=3, [0.0, 128.0, 1024.0], &expected, 0.03);
}

/// A room whose walls emit 1 and reflect nothing: through clear solids everything looks as bright as without them.
fn furnace_with(solids: Vec<Thing>) -> ergodic_pathspace::Scene {
    let mut things = vec![(cuboid(DVec3::splat(3.0), true), diffuse(0.0, 1.0))];
    things.extend(solids);
    let eye = Eye { from: DVec3::new(0.4, -2.0, 0.5), at: DVec3::new(0.1, 0.0, 0.0), up: DVec3::Z, fov: 0.6 };
    scene_of(things, Vec::new(), &eye, SIDE)
}

#[test]
fn nested_touching_and_overlapping_solids_lose_and_gain_nothing() {
    let cube = |half: f64, x: f64| moved(cuboid(DVec3::splat(half), false), DVec3::X * x);
    let glass_and_water = |a: Mesh, b: Mesh| vec![(a, glass(1.5)), (b, glass(1.33))];
    // A slab with other edges than the cube's, so that faces touch without being the same triangles.
    let slab = moved(cuboid(DVec3::new(0.2, 0.7, 0.6), false), DVec3::X * 0.6);
    for (what, solids) in [
        ("nested", glass_and_water(cube(0.5, 0.0), cube(0.25, 0.0))),
        ("with a gap", glass_and_water(cube(0.4, -0.4), cube(0.4, 0.4 + 1e-6))),
        ("touching", glass_and_water(cube(0.4, -0.4), cube(0.4, 0.4))),
        ("touching with other edges", glass_and_water(cube(0.4, 0.0), slab)),
        ("overlapping", glass_and_water(cube(0.4, -0.3), cube(0.4, 0.3))),
        ("one filling another", glass_and_water(cube(0.5, 0.0), cube(0.5, 0.0))),
    ] {
        let scene = furnace_with(solids);
        // The gaps that are left between solids bend a ray by up to 1e-3 of itself at their rims.
        let one = [Estimate { mean: Rgb::ONE, error: Rgb::splat(1e-5) }; 2];
        check(what, &scene, 1..=128, [96.0, 0.0, 0.0], &one, 0.01);
    }
}

#[test]
fn a_solid_on_a_table_is_the_same_for_every_method() {
    // Glass that touches the table it stands on, all of it over one face of the table.
    let table = quad(DVec3::new(-2.0, -2.0, -0.4), DVec3::X * 4.0, DVec3::Y * 4.0);
    let lamp = quad(DVec3::new(-0.5, -0.5, 1.5), DVec3::Y, DVec3::X);
    let eye = Eye { from: DVec3::new(1.2, -1.5, 1.2), at: DVec3::ZERO, up: DVec3::Z, fov: 0.7 };
    let things = |gap: f64| {
        let cube = moved(cuboid(DVec3::splat(0.4), false), DVec3::Z * gap);
        vec![(cube, glass(1.5)), (table.clone(), diffuse(0.7, 0.0)), (lamp.clone(), diffuse(0.0, 4.0))]
    };
    let edges = 1..=7;
    let apart = scene_of(things(1e-5), Vec::new(), &eye, SIDE);
    let expected = means(&apart, &settings(Method::Path, &edges, 512.0));
    let touching = scene_of(things(0.0), Vec::new(), &eye, SIDE);
    check("glass on a table", &touching, edges, [512.0, 128.0, 1024.0], &expected, 0.03);
}

#[test]
fn light_is_absorbed_on_its_way_between_things_in_a_solid() {
    // Eye, floor and light all under water: no end of any edge lies on the water's surface.
    let absorption = Rgb::new(0.2, 0.5, 1.0);
    let water = || {
        let body = cuboid(DVec3::splat(3.0), false);
        (body, Material { absorption, ..glass(1.33) })
    };
    let (albedo, intensity) = (0.7, 2.0);
    let floor = || (quad(DVec3::new(-1.0, -1.0, 0.0), DVec3::X * 2.0, DVec3::Y * 2.0), diffuse(albedo, 0.0));
    let eye = Eye::over(DVec3::new(0.3, 0.0, 0.8), DVec3::new(0.3, 0.0, 0.0), DVec3::Y, 0.6);
    let radiance = |p: DVec3, cosines: i32| {
        let squared = p.distance_squared(DVec3::Z);
        let falloff = squared.sqrt().recip().powi(cosines) / squared;
        let way = squared.sqrt() + p.distance(eye.from);
        albedo / PI * intensity * falloff * (absorption * -way).exp()
    };
    let point = PunctualLight::Point { position: DVec3::Z, intensity: Rgb::splat(intensity) };
    let scene = scene_of(vec![water(), floor()], vec![point], &eye, SIDE);
    let truth = plane_means(|p| radiance(eye.sees(p), 1));
    check("a light under water", &scene, 2..=2, [32.0, 32.0, 512.0], &truth, 0.005);
    let side = 1e-3;
    let lamp = quad(DVec3::new(-0.5 * side, -0.5 * side, 1.0), DVec3::Y * side, DVec3::X * side);
    let lamp = (lamp, diffuse(0.0, intensity / (side * side)));
    let scene = scene_of(vec![water(), floor(), lamp], Vec::new(), &eye, SIDE);
    let truth = plane_means(|p| radiance(eye.sees(p), 2));
    check("a lamp under water", &scene, 2..=2, [32.0, 32.0, 512.0], &truth, 0.005);
    // What is absorbed shows: without it the truth would be another.
    assert!(truth[0].mean.x > 1.5 * truth[0].mean.z);
}
