//! Random numbers and meshes shared by the tests.

use std::collections::HashMap;
use std::f64::consts::TAU;

use ergodic_geometry::{Instance, Mesh, World};
use glam::{DAffine3, DVec3};
use rand_core::{Rng, SeedableRng};

/// Numbers uniform on [0, 1).
pub struct Random(rand_pcg::Pcg64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(rand_pcg::Pcg64::seed_from_u64(seed))
    }

    pub fn next(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.0.next_u64() % n as u64) as usize
    }

    /// A point of the cube [-1, 1]³.
    pub fn cube(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
    }

    /// A direction uniform over the sphere.
    pub fn direction(&mut self) -> DVec3 {
        let z = 1.0 - 2.0 * self.next();
        let (sin, cos) = (TAU * self.next()).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * cos, radius * sin, z)
    }

    /// Barycentrics (u, v) uniform over a triangle.
    pub fn barycentrics(&mut self) -> (f64, f64) {
        let (r, v) = (self.next().sqrt(), self.next());
        (r * (1.0 - v), r * v)
    }
}

/// An icosahedron whose faces are cut in four `levels` times, on the unit sphere, counter-clockwise from outside.
pub fn sphere(levels: usize) -> Mesh {
    let g = 0.5 * (1.0 + 5f64.sqrt());
    let mut positions: Vec<DVec3> = [
        [-1.0, g, 0.0],
        [1.0, g, 0.0],
        [-1.0, -g, 0.0],
        [1.0, -g, 0.0],
        [0.0, -1.0, g],
        [0.0, 1.0, g],
        [0.0, -1.0, -g],
        [0.0, 1.0, -g],
        [g, 0.0, -1.0],
        [g, 0.0, 1.0],
        [-g, 0.0, -1.0],
        [-g, 0.0, 1.0],
    ]
    .map(|p| DVec3::from_array(p).normalize())
    .to_vec();
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    Mesh { positions, triangles, ..Mesh::default() }
}

/// A closed bumpy surface around the origin, with radius between 0.75 and 1.25.
pub fn bumpy_sphere(levels: usize, seed: u64) -> Mesh {
    let mut random = Random::new(seed);
    let mut mesh = sphere(levels);
    for p in &mut mesh.positions {
        *p *= 0.75 + 0.5 * random.next();
    }
    mesh
}

/// The cube [-1, 1]³ with faces cut into n × n squares, counter-clockwise from outside.
pub fn cube(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let first = mesh.positions.len() as u32;
            for i in 0..=n {
                for j in 0..=n {
                    // Odd in its argument, so that the faces meet in the same bits.
                    let place = |i: u32| (2.0 * f64::from(i) - f64::from(n)) / f64::from(n);
                    let (s, t) = (place(i), place(j));
                    let mut p = DVec3::ZERO;
                    p[axis] = side;
                    p[(axis + 1) % 3] = s * side;
                    p[(axis + 2) % 3] = t;
                    mesh.positions.push(p);
                }
            }
            for i in 0..n {
                for j in 0..n {
                    let a = first + i * (n + 1) + j;
                    let b = a + n + 1;
                    mesh.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
                }
            }
        }
    }
    mesh
}

pub fn moved(mut mesh: Mesh, scale: f64, offset: DVec3) -> Mesh {
    for p in &mut mesh.positions {
        *p = *p * scale + offset;
    }
    mesh
}

pub fn world_of(meshes: Vec<Mesh>) -> World {
    let instances =
        (0..meshes.len()).map(|mesh| Instance { mesh: mesh as u32, transform: DAffine3::IDENTITY }).collect();
    World::build(meshes, instances).expect("a valid world")
}

/// Every triangle of a world as (instance, triangle, vertices).
pub fn all_triangles(world: &World) -> Vec<(u32, u32, [DVec3; 3])> {
    (0..world.instances().len() as u32)
        .flat_map(|instance| (0..world.triangle_count(instance) as u32).map(move |triangle| (instance, triangle)))
        .map(|(instance, triangle)| (instance, triangle, world.triangle(instance, triangle)))
        .collect()
}

/// Where the line `origin + t direction` meets a triangle's plane and whether it is inside by `margin` (in
/// barycentrics; negative to enlarge it). Plain Cramer's rule, unlike the library's test.
pub fn cramer(origin: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3], margin: f64) -> Option<f64> {
    let (ab, ac, ao) = (b - a, c - a, origin - a);
    let n = ab.cross(ac);
    let det = -direction.dot(n);
    let t = ao.dot(n) / det;
    let m = ao.cross(direction);
    let (u, v) = (ac.dot(m) / det, -ab.dot(m) / det);
    (u > margin && v > margin && 1.0 - u - v > margin && t.is_finite()).then_some(t)
}
