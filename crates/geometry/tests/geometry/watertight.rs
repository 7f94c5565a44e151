//! No ray leaves a closed surface, and the closest hit is the closest.

use ergodic_geometry::{Anchor, Mesh, Ray, World};
use glam::{DVec3, Vec3};

use crate::support::{Random, all_triangles, bumpy_sphere, cramer, cube, moved, world_of};

const OFFSETS: [f64; 3] = [0.0, 100.0, 1000.0];
const SCALES: [f64; 3] = [1e-4, 1.0, 1e4];

/// What a ray aims at.
#[derive(Clone, Copy, Debug)]
enum Aim {
    Anywhere,
    Edge,
    Vertex,
}

/// A ray from inside the mesh, whose centre and scale are given.
fn ray_inside(random: &mut Random, mesh: &Mesh, aim: Aim, scale: f64, center: DVec3) -> Ray {
    let origin = center + random.cube() * (0.35 * scale);
    let corners = mesh.triangles[random.below(mesh.triangles.len())].map(|v| mesh.positions[v as usize]);
    let target = match aim {
        Aim::Anywhere => origin + random.direction(),
        Aim::Edge => corners[0].lerp(corners[1], random.next()),
        Aim::Vertex => corners[0],
    };
    Ray { origin, direction: (target - origin).normalize() }
}

fn leaks(world: &World, mesh: &Mesh, aim: Aim, scale: f64, center: DVec3, rays: usize) -> usize {
    let mut random = Random::new(7);
    (0..rays)
        .filter(|i| {
            let ray = ray_inside(&mut random, mesh, aim, scale, center);
            let missed = world.intersect(&ray).is_none();
            // The shadow query is a different traversal: it must agree.
            let free = Anchor { position: ray.origin, normal: DVec3::ZERO };
            missed || (i % 4 == 0 && world.escapes(&free, ray.direction))
        })
        .count()
}

#[test]
fn no_ray_leaves_a_closed_mesh() {
    for scale in SCALES {
        for offset in OFFSETS {
            let center = DVec3::new(offset, -offset, 0.7 * offset);
            let mesh = moved(bumpy_sphere(3, 1), scale, center);
            let world = world_of(vec![mesh.clone()]);
            for aim in [Aim::Anywhere, Aim::Edge, Aim::Vertex] {
                let count = leaks(&world, &mesh, aim, scale, center, 200_000);
                assert_eq!(count, 0, "{aim:?} at scale {scale}, offset {offset}");
            }
        }
    }
}

#[test]
fn no_ray_leaves_a_box_of_axis_aligned_squares() {
    // Flat boxes in the tree, and rays along the axes, within coordinate planes and through corners.
    for n in [1, 2, 7] {
        let mesh = cube(n);
        let world = world_of(vec![mesh.clone()]);
        for aim in [Aim::Anywhere, Aim::Edge, Aim::Vertex] {
            assert_eq!(leaks(&world, &mesh, aim, 1.0, DVec3::ZERO, 20_000), 0, "{aim:?}, {n}");
        }
        for x in -1..=1 {
            for y in -1..=1 {
                for z in -1..=1 {
                    let direction = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
                    if let Some(direction) = direction.try_normalize() {
                        let hit = world.intersect(&Ray { origin: DVec3::ZERO, direction });
                        assert!(hit.is_some(), "{direction}");
                    }
                }
            }
        }
    }
}

/// Möller and Trumbore's test in f32.
fn moller_trumbore(origin: Vec3, direction: Vec3, [a, b, c]: [Vec3; 3]) -> bool {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let inverse = 1.0 / ab.dot(p);
    let s = origin - a;
    let u = s.dot(p) * inverse;
    let q = s.cross(ab);
    let v = direction.dot(q) * inverse;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && ac.dot(q) * inverse > 0.0
}

#[test]
fn planted_fault_a_test_that_is_not_watertight_leaks() {
    let mesh = bumpy_sphere(2, 1);
    let triangles: Vec<_> = mesh.triangles.iter().map(|t| t.map(|v| mesh.positions[v as usize].as_vec3())).collect();
    let mut random = Random::new(7);
    let count = (0..2000)
        .filter(|_| {
            let ray = ray_inside(&mut random, &mesh, Aim::Vertex, 1.0, DVec3::ZERO);
            let (origin, direction) = (ray.origin.as_vec3(), ray.direction.as_vec3());
            !triangles.iter().any(|t| moller_trumbore(origin, direction, *t))
        })
        .count();
    assert!(count > 0);
}

#[test]
fn closest_hits_are_those_of_brute_force() {
    for scale in SCALES {
        for offset in OFFSETS {
            let center = DVec3::new(offset, -offset, 0.7 * offset);
            // Two shells and origins outside too, so that rays cross several surfaces or none.
            let shells = vec![
                moved(bumpy_sphere(2, 2), scale, center),
                moved(bumpy_sphere(2, 3), 0.6 * scale, center + 0.1 * scale),
            ];
            let world = world_of(shells);
            let triangles = all_triangles(&world);
            let mut random = Random::new(11);
            let mut hits = 0;
            for _ in 0..2000 {
                let origin = center + random.cube() * (2.0 * scale);
                let ray = Ray { origin, direction: (center + random.cube() * scale - origin).normalize() };
                let hit = world.intersect(&ray);
                // Strictly inside a triangle, nothing may be nearer than the hit.
                let nearest = triangles
                    .iter()
                    .filter_map(|(_, _, corners)| cramer(ray.origin, ray.direction, *corners, 1e-6))
                    .filter(|t| *t > 0.0)
                    .fold(f64::INFINITY, f64::min);
                let t = hit.map_or(f64::INFINITY, |hit| hit.t);
                let slack = 1e-9 * (scale + 1e-4 * offset);
                assert!(t <= nearest + slack, "{t} is beyond {nearest}");
                if let Some(hit) = hit {
                    hits += 1;
                    // And the hit is on the triangle it names, at the point its barycentrics name.
                    let corners = world.triangle(hit.instance, hit.triangle);
                    let t = cramer(ray.origin, ray.direction, corners, -1e-6).unwrap();
                    assert!((t - hit.t).abs() <= slack);
                    let surface = world.surface(&hit);
                    assert!(surface.position.distance(ray.origin + ray.direction * hit.t) <= slack);
                }
            }
            assert!((500..1900).contains(&hits), "{hits} hits");
        }
    }
}

#[test]
fn rays_from_far_away_do_not_leak() {
    let mesh = bumpy_sphere(3, 1);
    let world = world_of(vec![mesh.clone()]);
    let mut random = Random::new(3);
    for distance in [1e2, 1e4, 1e6] {
        for _ in 0..20_000 {
            let inside = random.direction() * 0.5;
            let direction = random.direction();
            assert!(world.intersect(&Ray { origin: inside - direction * distance, direction }).is_some());
        }
    }
}

#[test]
fn hits_very_near_the_origin_are_found() {
    // obvhs drops boxes that end before 1e-4 along the ray.
    let world = world_of(vec![cube(1)]);
    for distance in [1e-2, 1e-4, 1e-5, 1e-8] {
        let origin = DVec3::new(1.0 - distance, 0.3, 0.2);
        let hit = world.intersect(&Ray { origin, direction: DVec3::X }).unwrap();
        assert!((hit.t - distance).abs() < 1e-15);
        let ends = [0.5, 2.0].map(|k| Anchor { position: origin + DVec3::X * (k * distance), normal: DVec3::ZERO });
        let start = Anchor { position: origin, normal: DVec3::ZERO };
        assert!(world.visible(&start, &ends[0]));
        assert!(!world.visible(&start, &ends[1]));
    }
}

#[test]
fn thousands_of_coincident_triangles_are_searched() {
    let mut mesh = cube(1);
    mesh.triangles = mesh.triangles.iter().flat_map(|t| [*t; 3000]).collect();
    let world = world_of(vec![mesh]);
    let hit = world.intersect(&Ray { origin: DVec3::ZERO, direction: DVec3::new(0.6, 0.0, 0.8) }).unwrap();
    // Of equal hits the first triangle counts.
    assert_eq!(hit.triangle % 3000, 0);
}

#[test]
fn rays_that_are_no_rays_hit_nothing() {
    let world = world_of(vec![cube(1)]);
    for bad in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
        assert_eq!(world.intersect(&Ray { origin: DVec3::ZERO, direction: bad }), None);
    }
    for bad in [DVec3::NAN, DVec3::INFINITY] {
        assert_eq!(world.intersect(&Ray { origin: bad, direction: DVec3::X }), None);
    }
    let empty = World::build(vec![], vec![]).unwrap();
    assert_eq!(empty.intersect(&Ray { origin: DVec3::ZERO, direction: DVec3::X }), None);
    assert_eq!(empty.bounds(), (DVec3::ZERO, DVec3::ZERO));
}
