//! Every set of instructions finds what brute force finds, to the bit, and faulty sets do not.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use rand_core::{Rng, SeedableRng};

use super::*;
use crate::tree::{Child, Cube, blocks::LANES, node::WIDTH};
use crate::{Anchor, Instance, Mesh, Ray, World};

struct Random(rand_pcg::Pcg64);

impl Random {
    fn next(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        (self.0.next_u64() % n as u64) as usize
    }

    fn cube(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
    }
}

/// Two sheets of triangles that share vertices, and triangles that join any three of them.
fn sheets(random: &mut Random) -> Mesh {
    const SIDE: usize = 12;
    let mut mesh = Mesh::default();
    for height in [-0.5, 0.5] {
        let first = mesh.positions.len();
        for i in 0..SIDE * SIDE {
            let at = |i: usize| 2.0 * i as f64 / (SIDE - 1) as f64 - 1.0;
            mesh.positions.push(DVec3::new(at(i / SIDE), at(i % SIDE), height) + random.cube() * 0.07);
        }
        for (i, j) in (1..SIDE).flat_map(|i| (1..SIDE).map(move |j| (i, j))) {
            let [a, b, c, d] = [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[k, l]| (first + (i - k) * SIDE + j - l) as u32);
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    let vertices = mesh.positions.len();
    mesh.triangles.extend((0..300).map(|_| [0; 3].map(|_| random.below(vertices) as u32)));
    mesh
}

/// A fan of large triangles around a point near zero: rays at its edges pass them by less than the products of the edge functions
/// are rounded by.
fn fan(random: &mut Random) -> Mesh {
    const RIM: u32 = 11;
    let mut rim = |i: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(RIM)).sin_cos();
        DVec3::new(cos, sin, 0.0) + random.cube() * 0.2
    };
    Mesh {
        positions: [DVec3::splat(1e-3)].into_iter().chain((0..RIM).map(&mut rim)).collect(),
        triangles: (0..RIM).map(|i| [0, 1 + i, 1 + (i + 1) % RIM]).collect(),
        ..Mesh::default()
    }
}

/// Worlds, and how many times as many rays they get as the others.
fn worlds(random: &mut Random) -> Vec<(World, usize)> {
    let mesh = sheets(random);
    let turn = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.7);
    let instance = |transform: DAffine3| Instance { mesh: 0, transform };
    let mut several = vec![
        instance(DAffine3::IDENTITY),
        instance(DAffine3::from_scale_rotation_translation(DVec3::new(0.3, -2.0, 1.0), turn, DVec3::Y)),
        instance(DAffine3::from_mat3_translation(
            DMat3::from_cols(DVec3::X, DVec3::new(0.9, 1.0, 0.0), DVec3::new(0.3, -0.4, 0.5)),
            DVec3::new(0.3, -0.2, 1.0),
        )),
    ];
    several.extend(
        (0..5).map(|_| instance(DAffine3::from_scale_rotation_translation(DVec3::splat(0.5), turn, random.cube()))),
    );
    let mut worlds: Vec<(World, usize)> = [(1.0, 0.0), (1e-60, 0.0), (1e60, 3.0), (1.0, 1e3)]
        .map(|(scale, offset)| {
            let place = DAffine3::from_scale_rotation_translation(
                DVec3::splat(scale),
                DQuat::IDENTITY,
                DVec3::new(1.0, -0.7, 0.4) * (scale * offset),
            );
            (World::build(vec![mesh.clone()], vec![instance(place)]).unwrap(), 1)
        })
        .into();
    worlds.push((World::build(vec![mesh], several).unwrap(), 1));
    worlds.push((World::build(vec![fan(random)], vec![instance(DAffine3::IDENTITY)]).unwrap(), 10));
    worlds
}

/// Most rays aim at vertices or edges: there the least error shows.
fn rays(random: &mut Random, world: &World, count: usize) -> Vec<Ray> {
    let (min, max) = world.bounds();
    let size = (max - min).max_element();
    let mut ray = |i: usize| {
        let instance = random.below(world.instances().len()) as u32;
        let [a, b, c] = world.triangle(instance, random.below(world.triangle_count(instance)) as u32);
        let origin = min + (max - min) * (random.cube() * if i.is_multiple_of(5) { 100.0 } else { 1.5 });
        let target = match i % 4 {
            0 => a,
            1 => a.lerp(b, random.next()),
            _ => a.lerp(b, random.next()).lerp(c, random.next()),
        };
        // Where nothing is sheared off, a ray meets an edge most exactly.
        if i.is_multiple_of(3) {
            let axis = [DVec3::X, DVec3::NEG_Y, DVec3::Z][i / 3 % 3];
            return Ray { origin: target - axis * size * random.next(), direction: axis };
        }
        Ray { origin, direction: ((target - origin) / size).try_normalize().unwrap_or(DVec3::X) }
    };
    (0..count).map(&mut ray).collect()
}

type Bits = Option<([u32; 2], [u64; 3])>;

/// The closest hit, by the whole test of every triangle.
fn brute_force(world: &World, ray: &Ray) -> Bits {
    let shear = Shear::new(ray.origin, ray.direction);
    let mut nearest: Option<(Crossing, [u32; 2])> = None;
    for instance in 0..world.instances().len() as u32 {
        for number in (0..world.triangle_count(instance) as u32).filter(|i| world.can_be_hit(instance, *i)) {
            let limit = nearest.map_or(f64::MAX, |(crossing, _)| crossing.t);
            // Numbers ascend, so that only what is strictly nearer replaces what there is.
            if let Some(crossing) = shear.cross(&world.triangle(instance, number), limit)
                && nearest.is_none_or(|(other, _)| crossing.t < other.t)
            {
                nearest = Some((crossing, [instance, number]));
            }
        }
    }
    nearest.map(|(Crossing { t, u, v }, owner)| (owner, [u, v, t].map(f64::to_bits)))
}

fn searched(world: &World, ray: &Ray) -> (Bits, bool) {
    let hit = world.intersect(ray);
    let start = Anchor { position: ray.origin, normal: DVec3::ZERO };
    (
        hit.map(|hit| ([hit.instance, hit.triangle], [hit.u, hit.v, hit.t].map(f64::to_bits))),
        world.escapes(&start, ray.direction),
    )
}

/// Of how many rays a set of instructions gives the closest hit or the blocking wrong, and of how many there is a hit.
fn errors(isas: &[Isa], count: usize) -> (Vec<usize>, usize) {
    let mut random = Random(rand_pcg::Pcg64::seed_from_u64(1));
    let mut errors = vec![0; isas.len()];
    let mut hits = 0;
    for (mut world, times) in worlds(&mut random) {
        let rays = rays(&mut random, &world, times * count);
        let truths: Vec<Bits> = rays.iter().map(|ray| brute_force(&world, ray)).collect();
        hits += truths.iter().flatten().count();
        for (isa, errors) in isas.iter().zip(&mut errors) {
            world = world.with_isa(*isa);
            let wrong = |(ray, truth): &(&Ray, &Bits)| searched(&world, ray) != (**truth, truth.is_none());
            *errors += rays.iter().zip(&truths).filter(wrong).count();
        }
    }
    (errors, hits)
}

#[test]
fn closest_hits_and_blocking_are_those_of_brute_force() {
    let isas = Isa::available();
    let count = 4000;
    let (errors, hits) = errors(&isas, count);
    assert_eq!(errors, vec![0; isas.len()], "{isas:?}");
    assert!((5 * count..15 * count).contains(&hits), "{hits}");
}

/// Small and made without threads, so that an interpreter can look at the searches and at nothing else.
#[test]
fn all_search_a_tree_made_by_hand_alike() {
    let mut random = Random(rand_pcg::Pcg64::seed_from_u64(2));
    let cube = Cube::around(DVec3::splat(-1.0), DVec3::ONE);
    let (mut nodes, mut blocks) = ([Node::EMPTY; 1 + WIDTH], [<Block as bytemuck::Zeroable>::zeroed(); WIDTH * WIDTH]);
    for (inner, i) in (0..WIDTH).flat_map(|inner| (0..WIDTH).map(move |i| (inner, i))) {
        let leaf = inner * WIDTH + i;
        let (at, mut min, mut max) = (random.cube() * 0.7, DVec3::INFINITY, DVec3::NEG_INFINITY);
        for lane in 0..LANES {
            let triangle = [0; 3].map(|_| at + random.cube() * 0.3);
            blocks[leaf].set(lane, &triangle, [leaf as u32, lane as u32]);
            (min, max) = triangle.iter().fold((min, max), |(min, max), p| (min.min(*p), max.max(*p)));
        }
        nodes[1 + inner].set(i, &cube.padded_box(min, max), Child::leaf(leaf, LANES));
        nodes[0].set(inner, &cube.padded_box(DVec3::splat(-1.0), DVec3::ONE), Child::node(1 + inner));
    }
    let rays = if cfg!(miri) { 8 } else { 200 };
    let mut hits = 0;
    for _ in 0..rays {
        let (origin, direction) = (random.cube(), random.cube().normalize());
        let (ray, shear) = (TreeRay::new(origin, direction, f64::MAX).unwrap(), Shear::new(origin, direction));
        let crossings = blocks.iter().flat_map(|block| (0..LANES).map(move |lane| (block, lane)));
        let crossed = crossings
            .filter_map(|(block, lane)| Some((shear.cross(&block.triangle(lane), f64::MAX)?.t, block.owners[lane])));
        let truth = crossed.min_by(|a, b| a.0.total_cmp(&b.0));
        hits += usize::from(truth.is_some());
        for isa in Isa::available() {
            let mut nearest = None;
            isa.closest(
                &nodes,
                &ray,
                &shear,
                f64::MAX,
                &blocks,
                |block| block,
                |crossing, owner| {
                    nearest = Some((crossing.t, owner));
                    Some(crossing.t)
                },
            );
            assert_eq!(nearest, truth, "{isa:?}");
            let found = isa.any(&nodes, &ray, &shear, f64::MAX, &blocks, |block| block);
            assert_eq!(found, truth.is_some(), "{isa:?}");
            let mut looked_at = Vec::new();
            isa.members(&nodes, &ray, |place, _| {
                looked_at.push(place as u32);
                false
            });
            assert!(truth.is_none_or(|(_, [leaf, _])| looked_at.contains(&leaf)), "{isa:?}");
        }
    }
    assert!((rays / 4..rays).contains(&hits), "{hits}");
}

#[test]
fn planted_faults_fused_or_hasty_edges_and_boxes_without_padding_are_noticed() {
    let (errors, _) = errors(&[Isa(Kind::Fused), Isa(Kind::Hasty), Isa(Kind::Unpadded)], 4000);
    assert!(errors.iter().all(|count| *count > 5), "{errors:?}");
}

#[test]
fn names_are_those_of_what_there_is() {
    for isa in Isa::available() {
        assert_eq!(Isa::named(isa.name()), Ok(isa));
    }
    assert_eq!(Isa::named(""), Ok(Isa::best()));
    assert_eq!(Isa::named("plain"), Ok(Isa(Kind::Plain)));
    for wrong in ["AVX2", "avx3", "best", "fused", "hasty", "unpadded", " plain"] {
        let error = Isa::named(wrong).unwrap_err();
        assert!(error.to_string().contains(wrong) && error.to_string().contains("plain"), "{error}");
    }
}
