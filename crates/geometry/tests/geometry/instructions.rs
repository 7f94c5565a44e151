//! Every set of instructions of this processor gives the same hits and the same visibility as plain Rust, to the bit.
//!
//! That these are the right ones is tested by brute force in `src/tree/isa/tests.rs`, where faulty sets of instructions show
//! that such a comparison can fail.

use ergodic_geometry::{Anchor, Instance, Isa, Mesh, Ray, World};
use glam::{DAffine3, DQuat, DVec3};

use crate::instancing::transforms;
use crate::support::{Random, bumpy_sphere, cube, moved, world_of};

/// What a search may answer, in bits.
type Answers = (Vec<Option<(u32, u32, [u64; 3])>>, Vec<bool>);

/// Rays and segments of all kinds through a world.
struct Questions {
    rays: Vec<Ray>,
    segments: Vec<[Anchor; 2]>,
}

impl Questions {
    fn new(world: &World, seed: u64, count: usize) -> Self {
        let mut random = Random::new(seed);
        let rays: Vec<Ray> = (0..count).map(|i| ray(&mut random, world, i)).collect();
        let segments = (0..count).map(|_| [0; 2].map(|_| anchor(&mut random, world))).collect();
        Self { rays, segments }
    }

    fn answers(&self, world: &World) -> Answers {
        let hits = self.rays.iter().map(|ray| {
            let hit = world.intersect(ray)?;
            Some((hit.instance, hit.triangle, [hit.u, hit.v, hit.t].map(f64::to_bits)))
        });
        let escapes = self.rays.iter().map(|ray| {
            let start = Anchor { position: ray.origin, normal: DVec3::ZERO };
            world.escapes(&start, ray.direction)
        });
        let visible = self.segments.iter().map(|[a, b]| world.visible(a, b));
        (hits.collect(), escapes.chain(visible).collect())
    }
}

fn corners(random: &mut Random, world: &World) -> [DVec3; 3] {
    let instance = random.below(world.instances().len()) as u32;
    world.triangle(instance, random.below(world.triangle_count(instance)) as u32)
}

/// A ray of the kind `i % 7`.
fn ray(random: &mut Random, world: &World, i: usize) -> Ray {
    let (min, max) = world.bounds();
    let (center, reach) = (0.5 * (min + max), 0.5 * (max - min).max_element());
    let [a, b, c] = corners(random, world);
    let near = center + random.cube() * reach * 1.5;
    let towards = |origin: DVec3, target: DVec3| {
        // Differences may be too small to be squared.
        let across = (target - origin) / reach;
        Ray { origin, direction: across.try_normalize().unwrap_or(DVec3::X) }
    };
    match i % 7 {
        0 => Ray { origin: near, direction: random.direction() },
        1 => towards(near, a),
        2 => towards(near, a.lerp(b, random.next())),
        // Along an axis, through a vertex or past it.
        3 => {
            let axis = [DVec3::X, DVec3::Y, DVec3::Z][random.below(3)] * if random.below(2) == 0 { 1.0 } else { -1.0 };
            let at = if random.below(2) == 0 { a } else { a.lerp(b, random.next()).lerp(c, random.next()) };
            Ray { origin: at - axis * reach * (2.0 * random.next() + 0.5), direction: axis }
        }
        // From far outside.
        4 => towards(center + random.direction() * reach * 10f64.powf(6.0 * random.next()), a.lerp(c, random.next())),
        // In the plane of a triangle, up to rounding.
        5 => {
            let along = (b - a) * (random.next() - 0.5) + (c - a) * (random.next() - 0.5);
            let inside = a.lerp(b, random.next()).lerp(c, random.next());
            towards(inside - along * (10.0 * random.next()), inside)
        }
        // From the surface itself.
        _ => Ray { origin: a.lerp(b, random.next()).lerp(c, random.next()), direction: random.direction() },
    }
}

fn anchor(random: &mut Random, world: &World) -> Anchor {
    let (min, max) = world.bounds();
    if random.below(4) == 0 {
        return Anchor { position: min + (max - min) * (random.cube() + 0.5), normal: DVec3::ZERO };
    }
    let instance = random.below(world.instances().len()) as u32;
    let triangle = random.below(world.triangle_count(instance)) as u32;
    let (u, v) = if random.below(3) == 0 { (random.next(), 0.0) } else { random.barycentrics() };
    let surface = world.surface_at(instance, triangle, u, v);
    Anchor { position: surface.position, normal: if random.below(2) == 0 { surface.ng } else { -surface.ng } }
}

/// Asks every set of instructions and plain Rust the same. Returns the shares of hits and of blocked lines.
fn all_agree(what: &str, mut world: World, seed: u64, count: usize) -> [f64; 2] {
    let questions = Questions::new(&world, seed, count);
    let all = Isa::available();
    assert_eq!(all[0].name(), "plain");
    world = world.with_isa(all[0]);
    let (hits, free) = questions.answers(&world);
    for isa in &all[1..] {
        world = world.with_isa(*isa);
        let (other_hits, other_free) = questions.answers(&world);
        let wrong = hits.iter().zip(&other_hits).position(|(a, b)| a != b);
        assert_eq!(wrong.map(|i| (questions.rays[i], hits[i], other_hits[i])), None, "{what}, {isa:?}");
        let wrong = free.iter().zip(&other_free).position(|(a, b)| a != b);
        assert_eq!(wrong, None, "{what}, {isa:?}");
    }
    let share = |of: usize, all: usize| of as f64 / all as f64;
    [share(hits.iter().flatten().count(), hits.len()), share(free.iter().filter(|free| !**free).count(), free.len())]
}

/// That hits and misses occur, so that agreement means something.
fn expect_both([hits, blocked]: [f64; 2]) {
    assert!((0.2..0.995).contains(&hits) && (0.2..0.995).contains(&blocked), "{hits} {blocked}");
}

#[test]
fn bumpy_spheres_of_any_size_anywhere() {
    for (i, scale) in [1e-60, 1e-20, 1e-3, 1.0, 1e4, 1e20, 1e60].into_iter().enumerate() {
        for offset in [0.0, 10.0, 1e5] {
            let center = DVec3::new(1.0, -0.8, 0.3) * offset * scale;
            let shells = [(2, 0.6), (3, 1.0)].map(|(seed, size)| moved(bumpy_sphere(2, seed), size * scale, center));
            expect_both(all_agree(&format!("{scale} {offset}"), world_of(shells.to_vec()), i as u64, 3000));
        }
    }
}

#[test]
fn boxes_of_axis_parallel_squares() {
    for n in [1, 3, 8] {
        expect_both(all_agree("cube", world_of(vec![cube(n)]), u64::from(n), 10_000));
    }
}

#[test]
fn instances_with_all_kinds_of_transforms() {
    let mesh = bumpy_sphere(2, 5);
    for shared in [false, true] {
        let instances: Vec<Instance> = (0..)
            .zip(transforms())
            .map(|(i, transform)| Instance { mesh: if shared { 0 } else { i }, transform })
            .collect();
        let meshes = vec![mesh.clone(); if shared { 1 } else { instances.len() }];
        let world = World::build(meshes, instances).expect("a valid world");
        expect_both(all_agree(&format!("shared: {shared}"), world, 3, 20_000));
    }
}

#[test]
fn many_instances_of_several_meshes() {
    let mut random = Random::new(8);
    let meshes = vec![bumpy_sphere(1, 1), bumpy_sphere(0, 2), cube(2), cube(1)];
    let mut instances = vec![Instance { mesh: 3, transform: DAffine3::from_scale(DVec3::splat(12.0)) }];
    instances.extend((0..3000).map(|i| {
        let turn = DQuat::from_axis_angle(random.direction(), 6.0 * random.next());
        let scale = DVec3::new(1.0, 0.2 + random.next(), 0.1 + random.next()) * 0.6;
        let transform = DAffine3::from_scale_rotation_translation(scale, turn, random.cube() * 10.0);
        Instance { mesh: i % 3, transform }
    }));
    let shares = all_agree("many instances", World::build(meshes, instances).expect("a valid world"), 4, 20_000);
    expect_both(shares);
}

/// Triangles with corners from a function.
fn soup(count: usize, mut triangle: impl FnMut(usize) -> [DVec3; 3]) -> Mesh {
    Mesh {
        positions: (0..count).flat_map(&mut triangle).collect(),
        triangles: (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Mesh::default()
    }
}

#[test]
fn soups_of_triangles_of_all_sizes() {
    for (seed, spread) in [(1, 0.02), (2, 0.3), (3, 3.0)] {
        let mut random = Random::new(seed);
        let mesh = soup(3000, |_| {
            let (at, size) = (random.cube(), spread * random.next().powi(4));
            [0; 3].map(|_| at + random.cube() * size)
        });
        all_agree(&format!("soup {spread}"), world_of(vec![mesh]), seed, 10_000);
    }
}

#[test]
fn soups_of_slivers() {
    for thickness in [1e-3, 1e-7, 1e-13] {
        let mut random = Random::new(9);
        let mesh = soup(2000, |_| {
            let (at, along) = (random.cube(), random.direction() * random.next());
            [at, at + along, at + along * random.next() + random.direction() * thickness * random.next()]
        });
        all_agree(&format!("slivers {thickness}"), world_of(vec![mesh]), 5, 10_000);
    }
}

#[test]
fn thousands_of_triangles_over_each_other_in_one_plane() {
    let mut random = Random::new(10);
    for tilt in [DVec3::ZERO, DVec3::new(0.1, -0.7, 0.0)] {
        let mesh = soup(4000, |_| {
            [0.0, 2.1, 4.2].map(|angle| {
                let (sin, cos) = (angle + random.next()).sin_cos();
                let p = DVec3::new(cos, sin, 0.0) * (0.2 + random.next());
                p + DVec3::Z * p.dot(tilt)
            })
        });
        let [hits, _] = all_agree(&format!("one plane, tilted by {tilt}"), world_of(vec![mesh]), 6, 3000);
        assert!(hits > 0.2, "{hits}");
    }
}

#[test]
fn trees_far_deeper_than_their_triangles_are_many() {
    // Each is a little larger than all before, so that the tree is a list, and all are around the middle, so that a ray from
    // there has to remember more than the stack has room for.
    let mut random = Random::new(11);
    let mesh = soup(2500, |i| {
        let size = 1.02f64.powi(i as i32 - 2400);
        [0.0, 2.1, 4.2].map(|angle: f64| {
            let (sin, cos) = (angle + random.next()).sin_cos();
            (DVec3::new(cos, sin, 0.0) + random.cube() * 0.6) * size
        })
    });
    all_agree("nested", world_of(vec![mesh]), 7, 6000);
}

#[test]
fn the_best_is_one_of_those_that_there_are() {
    assert!(Isa::available().contains(&Isa::best()));
}
