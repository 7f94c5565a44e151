//! Soups of triangles against a plain set of the places seen so far.

use std::collections::HashSet;

use glam::{DAffine3, DQuat, DVec3};
use rand_core::{Rng, SeedableRng};

use super::*;
use crate::{Instance, World};

struct Random(rand_pcg::Pcg64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        (self.0.next_u64() % n as u64) as usize
    }

    fn of<T: Copy>(&mut self, some: &[T]) -> T {
        some[self.below(some.len())]
    }
}

/// What can be hit, by instance and triangle, and how many triangles the meshes lose.
#[derive(Debug, Default, PartialEq)]
struct Answer {
    hit: Vec<Vec<bool>>,
    dropped: usize,
}

#[derive(Default)]
struct Places(HashSet<[[u64; 3]; 3]>);

impl Places {
    fn take(&mut self, triangle: &Triangle) -> bool {
        let mut place = triangle.map(|p| p.to_array().map(|x| (x + 0.0).to_bits()));
        place.sort_unstable();
        !is_degenerate(triangle) && self.0.insert(place)
    }
}

/// The definition: the triangles of a mesh in order, then those of the listed instances in order.
fn reference(meshes: &[Mesh], placements: &[Placement], baked: &[u32]) -> Answer {
    let mut solid: Vec<Vec<bool>> = Vec::new();
    for mesh in meshes {
        let mut places = Places::default();
        solid.push((0..mesh.triangles.len() as u32).map(|t| places.take(&mesh.corners(t))).collect());
    }
    let dropped = solid.iter().flatten().filter(|solid| !**solid).count();
    let mut places = Places::default();
    let mut transforms = HashSet::new();
    let mut hit = Vec::new();
    for (instance, placement) in (0u32..).zip(placements) {
        let mesh = placement.mesh as usize;
        let first = transforms.insert((mesh, placement.transform.to_cols_array().map(|x| (x + 0.0).to_bits())));
        let can_be_hit = |t: u32| {
            first
                && solid[mesh][t as usize]
                && (!baked.contains(&instance) || places.take(&meshes[mesh].corners(t).map(|p| placement.point(p))))
        };
        hit.push((0..meshes[mesh].triangles.len() as u32).map(can_be_hit).collect());
    }
    Answer { hit, dropped }
}

fn found(hash: impl PlaceHash, meshes: &[Mesh], placements: &[Placement], baked: &[u32]) -> Answer {
    let mut hidden = Hidden::hashed_by(hash, meshes, placements);
    let owners = hidden.bake_hashed_by(hash, meshes, placements, baked).unwrap();
    let hit: Vec<Vec<bool>> = (0u32..)
        .zip(placements)
        .map(|(instance, Placement { mesh, .. })| {
            let triangles = 0..meshes[*mesh as usize].triangles.len() as u32;
            triangles.map(|triangle| !hidden.has(*mesh, instance, triangle)).collect()
        })
        .collect();
    let left = |&instance: &u32| {
        let hit = hit[instance as usize].iter();
        (0u32..).zip(hit).filter(|(_, hit)| **hit).map(move |(triangle, _)| (instance, triangle))
    };
    assert_eq!(owners, baked.iter().flat_map(left).collect::<Vec<_>>());
    for (index, mesh) in meshes.iter().enumerate() {
        let solid = hidden.solid(index, mesh.triangles.len());
        let known = |t: &u32| hidden.of_meshes[index].binary_search(t).is_err();
        assert_eq!(solid, (0..mesh.triangles.len() as u32).filter(known).collect::<Vec<_>>());
    }
    Answer { hit, dropped: hidden.dropped_of_meshes() }
}

/// Few points, so that triangles meet, both zeros, and a point so near a line that its triangles have an area or none by
/// which corner comes first.
fn soup(random: &mut Random) -> Mesh {
    let mut point = || match random.below(6) {
        0 => DVec3::new(1.0, 2.0, 0.0) * random.of(&[0.5, 1.0, 3.0]) + DVec3::X * random.of(&[0.0, 1.2e-15, 2.5e-15]),
        _ => DVec3::from_array([0; 3].map(|_| random.of(&[-1.0, -0.0, 0.0, 0.0, 1.0]))),
    };
    let positions: Vec<DVec3> = (0..12).map(|_| point()).collect();
    let count = random.of(&[0, 1, 40, 150]);
    let triangles = (0..count).map(|_| [0; 3].map(|_| random.below(12) as u32)).collect();
    Mesh { positions, triangles, ..Mesh::default() }
}

/// Transforms that keep shapes apart.
fn tame(random: &mut Random) -> DAffine3 {
    let shift = DVec3::X * random.of(&[-0.0, 0.0, 0.5]);
    let scale = random.of(&[DVec3::ONE, DVec3::new(-1.0, 1.0, 1.0), DVec3::new(1.0, 2.0, 4.0)]);
    DAffine3::from_scale_rotation_translation(scale, DQuat::from_rotation_z(random.of(&[0.0, 0.7])), shift)
}

/// Transforms that flatten, give an area to what has none, or round points together.
fn wild(random: &mut Random, shifts: &[f64]) -> DAffine3 {
    let scale = random.of(&[DVec3::new(1.0, 1.0, 0.0), DVec3::ZERO, DVec3::new(1.0, 1e-3, 1.0), DVec3::ONE]);
    let shift = DVec3::Z * random.of(shifts);
    DAffine3::from_scale_rotation_translation(scale, DQuat::IDENTITY, shift)
}

/// Meshes and their instances. The last meshes occur once, some twice in one place.
fn scene(random: &mut Random, shifts: &[f64]) -> (Vec<Mesh>, Vec<Instance>) {
    let mut meshes: Vec<Mesh> = (0..8).map(|_| soup(random)).collect();
    // Two meshes alike, for places that are taken all over.
    meshes[7] = meshes[6].clone();
    let mut instances: Vec<Instance> =
        (0..8).map(|_| Instance { mesh: random.below(3) as u32, transform: tame(random) }).collect();
    for mesh in 4..8 {
        let transform = if random.below(2) == 0 { tame(random) } else { wild(random, shifts) };
        for _ in 0..random.of(&[1, 1, 2]) {
            instances.insert(random.below(instances.len()), Instance { mesh, transform });
        }
    }
    (meshes, instances)
}

fn once(meshes: &[Mesh], placements: &[Placement]) -> Vec<u32> {
    let hidden = Hidden::new(meshes, placements);
    let uses = hidden.uses(meshes.len(), placements);
    let shown = (0..placements.len() as u32).filter(|i| !hidden.has_instance(*i));
    shown.filter(|i| uses[placements[*i as usize].mesh as usize] == 1).collect()
}

/// Calls `check` with scenes and the instances that are searched in the world: those of meshes that occur once, and some
/// others.
fn scenes(mut check: impl FnMut(&[Mesh], &[Placement], &[u32])) {
    let mut random = Random(rand_pcg::Pcg64::seed_from_u64(5));
    for _ in 0..600 {
        let (meshes, instances) = scene(&mut random, &[0.0, 0.1, 1e16, 1e20]);
        let placements: Vec<Placement> = instances.iter().map(Placement::new).collect();
        let mut baked = once(&meshes, &placements);
        let hidden = repeated_instances(&placements);
        baked.extend((0..instances.len() as u32).filter(|i| !hidden.contains(i) && random.below(3) == 0));
        baked.sort_unstable();
        baked.dedup();
        check(&meshes, &placements, &baked);
    }
}

#[test]
fn soups_lose_what_a_set_of_places_would_drop() {
    let (mut by_mesh, mut by_world, mut hit) = (0, 0, 0);
    scenes(|meshes, placements, baked| {
        let expected = reference(meshes, placements, baked);
        let answer = found(place_hash, meshes, placements, baked);
        assert!(answer == expected);
        let alone = reference(meshes, placements, &[]);
        let count = |answer: &Answer| answer.hit.iter().flatten().filter(|hit| **hit).count();
        by_mesh += expected.dropped;
        by_world += count(&alone) - count(&expected);
        hit += count(&expected);
    });
    assert!(by_mesh > 10_000 && by_world > 1_000 && hit > 1_000, "the soups are too thin: {by_mesh} {by_world} {hit}");
}

#[test]
fn collisions_of_hashes_change_nothing() {
    scenes(|meshes, placements, baked| {
        let expected = reference(meshes, placements, baked);
        assert!(found(|_| 0, meshes, placements, baked) == expected);
        assert!(found(|t| place_hash(t) % 3, meshes, placements, baked) == expected);
    });
}

#[test]
fn a_hash_that_knows_the_first_corner_is_noticed() {
    let mut wrong = 0;
    scenes(|meshes, placements, baked| {
        let by_corner = |t: &Triangle| place_hash(&[t[0]; 3]);
        wrong += u32::from(found(by_corner, meshes, placements, baked) != reference(meshes, placements, baked));
    });
    assert!(wrong > 100, "{wrong}");
}

#[test]
fn whether_a_triangle_has_an_area_may_hang_on_its_first_corner() {
    // The soups must have such triangles: an earlier one without an area then hides none in its place.
    let mut odd = 0;
    scenes(|meshes, _, _| {
        for mesh in meshes {
            for t in 0..mesh.triangles.len() as u32 {
                let [a, b, c] = mesh.corners(t);
                odd += u32::from(is_degenerate(&[a, b, c]) != is_degenerate(&[b, c, a]));
            }
        }
    });
    assert!(odd > 10, "{odd}");
}

#[test]
fn worlds_answer_like_a_set_of_places() {
    let mut random = Random(rand_pcg::Pcg64::seed_from_u64(6));
    for _ in 0..200 {
        // No far shifts: all meshes with several instances shall be searched in their own space.
        let (meshes, instances) = scene(&mut random, &[0.0, 0.1]);
        let placements: Vec<Placement> = instances.iter().map(Placement::new).collect();
        let expected = reference(&meshes, &placements, &once(&meshes, &placements));
        let world = World::build(meshes, instances).unwrap();
        let hit = (0..placements.len() as u32)
            .map(|i| (0..world.triangle_count(i) as u32).map(|t| world.can_be_hit(i, t)).collect())
            .collect();
        assert!(Answer { hit, dropped: world.dropped_triangles() } == expected);
    }
}
