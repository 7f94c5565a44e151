//! Rays leave the surface they start on, at any angle, scale and offset, and stay on the side they point to.

use ergodic_geometry::{Anchor, Frame, Ray, World};
use glam::DVec3;

use crate::support::{Random, cube, moved, sphere, world_of};

/// A point of a mesh and a direction at grazing angles down to 1e-6, out of the front.
fn grazing_start(random: &mut Random, world: &World) -> (Anchor, DVec3) {
    let (u, v) = random.barycentrics();
    let surface = world.surface_at(0, random.below(world.triangle_count(0)) as u32, u, v);
    let cos = 10f64.powf(-6.0 * random.next());
    let (sin, phi) = ((1.0 - cos * cos).sqrt(), std::f64::consts::TAU * random.next());
    let direction = Frame::from_normal(surface.ng).to_world(DVec3::new(sin * phi.cos(), sin * phi.sin(), cos));
    (Anchor { position: surface.position, normal: surface.ng }, direction.normalize())
}

const SETTINGS: [(f64, f64); 9] =
    [(1e-3, 0.0), (1.0, 0.0), (1e3, 0.0), (1e-3, 1e3), (1.0, 1e3), (1e3, 1e4), (1e-2, 1e4), (1.0, 1e6), (1e4, 1e6)];

#[test]
fn no_ray_off_a_convex_body_hits_it_and_none_into_it_escapes() {
    for (scale, offset) in SETTINGS {
        for mesh in [sphere(3), cube(3)] {
            let world = world_of(vec![moved(mesh, scale, DVec3::new(offset, -offset, 0.3 * offset))]);
            let mut random = Random::new(1);
            for _ in 0..10_000 {
                let (anchor, direction) = grazing_start(&mut random, &world);
                let out = world.spawn(&anchor, direction);
                assert_eq!(world.intersect(&out), None, "scale {scale}, offset {offset}");
                assert!(world.escapes(&anchor, direction));
                // The normal's side does not matter, only where the direction points.
                let flipped = Anchor { normal: -anchor.normal, ..anchor };
                assert_eq!(world.spawn(&flipped, direction), out);
                let hit = world.intersect(&world.spawn(&anchor, -direction));
                assert!(hit.is_some(), "scale {scale}, offset {offset}");
            }
        }
    }
}

#[test]
fn planted_fault_without_the_offset_rays_hit_their_own_surface() {
    let world = world_of(vec![sphere(3)]);
    let mut random = Random::new(1);
    let hits = (0..10_000)
        .filter(|_| {
            let (anchor, direction) = grazing_start(&mut random, &world);
            world.intersect(&Ray { origin: anchor.position, direction }).is_some()
        })
        .count();
    assert!(hits > 100, "{hits}");
}

#[test]
fn points_in_free_space_are_not_moved() {
    let world = world_of(vec![cube(1)]);
    let position = DVec3::new(0.1, 0.2, 0.3);
    let ray = world.spawn(&Anchor { position, normal: DVec3::ZERO }, DVec3::Y);
    assert_eq!(ray, Ray { origin: position, direction: DVec3::Y });
}
