//! Shadow segments: symmetric to the bit, and right.

use ergodic_geometry::{Anchor, Mesh, World};
use glam::DVec3;

use crate::support::{Random, all_triangles, bumpy_sphere, cramer, cube, moved, world_of};

/// A room with two bumpy things in it.
fn room() -> World {
    world_of(vec![
        moved(cube(3), 4.0, DVec3::ZERO),
        moved(bumpy_sphere(2, 1), 1.0, DVec3::new(1.5, 0.0, 1.0)),
        moved(bumpy_sphere(2, 2), 1.2, DVec3::new(-1.5, -1.0, 0.0)),
    ])
}

/// A point on a surface, or now and then in free space.
fn anchor(random: &mut Random, world: &World) -> Anchor {
    if random.below(8) == 0 {
        return Anchor { position: random.cube() * 4.0, normal: DVec3::ZERO };
    }
    let instance = random.below(world.instances().len()) as u32;
    let triangle = random.below(world.triangle_count(instance)) as u32;
    let (u, v) = match random.below(3) {
        // On an edge or a vertex too.
        0 => (random.next(), 0.0),
        1 => (0.0, 1.0),
        _ => random.barycentrics(),
    };
    let surface = world.surface_at(instance, triangle, u, v);
    Anchor { position: surface.position, normal: if random.below(2) == 0 { surface.ng } else { -surface.ng } }
}

#[test]
fn swapping_the_ends_changes_nothing() {
    let world = room();
    let mut random = Random::new(1);
    let mut seen = 0;
    for _ in 0..100_000 {
        let (a, b) = (anchor(&mut random, &world), anchor(&mut random, &world));
        let visible = world.visible(&a, &b);
        assert_eq!(visible, world.visible(&b, &a), "{a:?} {b:?}");
        seen += u32::from(visible);
    }
    assert!((10_000..90_000).contains(&seen), "{seen}");
}

/// Pairs whose segment passes exactly, up to rounding, through the rim of a square.
fn pairs_through_a_rim(count: usize) -> (World, Vec<(Anchor, Anchor)>) {
    let mesh = Mesh {
        positions: [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[x, y]| DVec3::new(x, y, 0.1 * x))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let corners = mesh.positions.clone();
    let world = world_of(vec![mesh]);
    let mut random = Random::new(5);
    let free = |position| Anchor { position, normal: DVec3::ZERO };
    let pairs = (0..count)
        .map(|_| {
            let side = random.below(4);
            let rim = corners[side].lerp(corners[(side + 1) % 4], random.next());
            let w = random.direction();
            (free(rim + w * (0.1 + random.next())), free(rim - w * (0.1 + random.next())))
        })
        .collect();
    (world, pairs)
}

#[test]
fn swapping_the_ends_changes_nothing_at_a_rim() {
    let (world, pairs) = pairs_through_a_rim(100_000);
    for (a, b) in &pairs {
        assert_eq!(world.visible(a, b), world.visible(b, a));
    }
}

#[test]
fn planted_fault_tracing_from_the_first_end_is_not_symmetric() {
    let (world, pairs) = pairs_through_a_rim(20_000);
    let naive = |a: &Anchor, b: &Anchor| {
        let across = b.position - a.position;
        world.intersect(&world.spawn(a, across.normalize())).is_none_or(|hit| hit.t >= across.length())
    };
    let differences = pairs.iter().filter(|(a, b)| naive(a, b) != naive(b, a)).count();
    assert!(differences > 100, "{differences}");
}

#[test]
fn shadows_are_those_of_brute_force() {
    let world = room();
    let triangles = all_triangles(&world);
    let mut random = Random::new(9);
    let mut counts = [0; 3];
    for _ in 0..10_000 {
        // Well inside triangles: at an edge it depends on the normal what the segment starts behind.
        let [a, b] = [0; 2].map(|_| {
            let instance = random.below(world.instances().len()) as u32;
            let triangle = random.below(world.triangle_count(instance)) as u32;
            let (u, v) = random.barycentrics();
            let surface = world.surface_at(instance, triangle, 0.1 + 0.7 * u, 0.1 + 0.7 * v);
            Anchor { position: surface.position, normal: if random.below(2) == 0 { surface.ng } else { -surface.ng } }
        });
        let across = b.position - a.position;
        let crosses = |margin: f64| {
            triangles.iter().any(|(_, _, corners)| {
                cramer(a.position, across, *corners, margin).is_some_and(|t| t > 1e-6 && t < 1.0 - 1e-6)
            })
        };
        // Decided only if neither a little more nor a little less triangle changes the answer.
        let (surely, maybe) = (crosses(1e-6), crosses(-1e-6));
        let grazes = |end: &Anchor| end.normal.dot(across.normalize()).abs() < 1e-4;
        if grazes(&a) || grazes(&b) || surely != maybe {
            counts[2] += 1;
        } else {
            counts[usize::from(surely)] += 1;
            assert_eq!(world.visible(&a, &b), !surely, "{a:?} {b:?}");
        }
    }
    assert!(counts[0] > 1000 && counts[1] > 1000 && counts[2] < 1000, "{counts:?}");
}

#[test]
fn ends_on_surfaces_do_not_shadow_themselves() {
    // From inside, every pair of points on different faces of a box sees each other; from outside, nothing does.
    for (scale, offset) in [(1.0, 0.0), (1e-3, 0.0), (1e4, 0.0), (1.0, 1e4), (1e-3, 1e3)] {
        let world = world_of(vec![moved(cube(2), scale, DVec3::splat(offset))]);
        let mut random = Random::new(6);
        for _ in 0..20_000 {
            let [a, b] = [0; 2].map(|_| {
                let (u, v) = random.barycentrics();
                world.surface_at(0, random.below(48) as u32, u, v)
            });
            if a.ng == b.ng || a.ng.dot(b.ng).abs() < 1e-3 && a.position.distance(b.position) < 1e-3 * scale {
                continue;
            }
            let [a, b] = [a, b].map(|s| Anchor { position: s.position, normal: s.ng });
            assert!(world.visible(&a, &b), "scale {scale}, offset {offset}");
            let outside = Anchor { position: a.position + a.normal * scale, normal: DVec3::ZERO };
            assert!(!world.visible(&outside, &b));
            assert!(world.visible(&outside, &a));
        }
    }
}

#[test]
fn points_nearer_than_the_offsets_do_not_see_each_other() {
    let world = room();
    let at = |x: f64| Anchor { position: DVec3::new(x, 0.2, 0.3), normal: DVec3::ZERO };
    assert!(!world.visible(&at(0.1), &at(0.1)));
    assert!(!world.visible(&at(0.1), &at(0.1 + 1e-11)));
    assert!(world.visible(&at(0.1), &at(0.1 + 1e-7)));
}
