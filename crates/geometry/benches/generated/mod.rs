//! A scene of any number of triangles and rays through it, from code, the same on every machine: a room of five walls, open
//! towards the camera, in which bumpy balls float. The number of balls and the triangles of each grow alike.
//!
//! All coordinates of the flat scene and of the rays are `f32` values, so that single-precision tracers can be given the same.

use ergodic_geometry::{Anchor, Instance, Mesh, Ray, World};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use rand_core::Rng;
use rand_pcg::Pcg64;

/// Meshes and where they are put.
pub type Placed = (Vec<Mesh>, Vec<Instance>);

/// Where rays come from, by the name that tables and files give them.
pub const KINDS: [&str; 3] = ["camera", "surface", "box"];

/// Points on surfaces are moved off them by this much, which is far beyond the rounding of `f32`.
const LIFT: f64 = 1e-4;

/// The room is the cube [-1, 1]³; the camera stands before its open side, off the axis so that no ray runs along a seam of walls.
const EYE: DVec3 = DVec3::new(0.1, 0.05, 3.0);

/// Half the width of what the camera sees at a distance of 1: a little less than the open side.
const HALF_WIDTH: f64 = 0.44;

fn uniform(rng: &mut Pcg64) -> f64 {
    (rng.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

fn uniform_direction(rng: &mut Pcg64) -> DVec3 {
    let z = 2.0 * uniform(rng) - 1.0;
    let (sin, cos) = (std::f64::consts::TAU * uniform(rng)).sin_cos();
    let radius = (1.0 - z * z).sqrt();
    DVec3::new(radius * cos, radius * sin, z)
}

fn uniform_point(rng: &mut Pcg64) -> DVec3 {
    DVec3::new(uniform(rng), uniform(rng), uniform(rng)) * 2.0 - DVec3::ONE
}

/// The nearest point whose coordinates are `f32` values.
fn single(p: DVec3) -> DVec3 {
    p.as_vec3().as_dvec3()
}

/// The six sides of a cube, each cut into `cuts` by `cuts` squares and pressed into a bumpy ball of radius 1 or so.
fn ball(cuts: usize) -> Mesh {
    let mut mesh = Mesh::default();
    for side in 0..6 {
        let (axis, sign) = (side / 2, if side % 2 == 0 { 1.0 } else { -1.0 });
        let first = mesh.positions.len() as u32;
        for (i, j) in (0..=cuts).flat_map(|i| (0..=cuts).map(move |j| (i, j))) {
            let at = |i: usize| 2.0 * i as f64 / cuts as f64 - 1.0;
            let mut p = [0.0; 3];
            p[axis] = sign;
            p[(axis + 1) % 3] = at(i) * sign;
            p[(axis + 2) % 3] = at(j);
            let p = DVec3::from_array(p).normalize();
            let bumps = (7.0 * p.x).sin() * (7.0 * p.y).sin() * (7.0 * p.z).sin();
            mesh.positions.push(p * (1.0 + 0.15 * bumps));
        }
        for (i, j) in (0..cuts as u32).flat_map(|i| (0..cuts as u32).map(move |j| (i, j))) {
            let corner = |i: u32, j: u32| first + i * (cuts as u32 + 1) + j;
            let (a, b, c, d) = (corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// The five walls, seen from within.
fn room() -> Mesh {
    let corner = |i: u32| DVec3::from_array([0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 }));
    let sides = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2]];
    Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..Mesh::default()
    }
}

/// The scene of about `triangles` triangles, as one ball with many instances and the room.
pub fn instanced(triangles: usize) -> Placed {
    let cuts = ((triangles as f64).sqrt() / 12.0).sqrt().round().max(1.0) as usize;
    let count = (triangles / (12 * cuts * cuts)).max(1);
    let radius = 0.5 / (count as f64).cbrt();
    let mut rng = Pcg64::new(1, 1);
    let mut instances = vec![Instance { mesh: 0, transform: DAffine3::IDENTITY }];
    instances.extend((0..count).map(|_| {
        let rotation = DQuat::from_axis_angle(uniform_direction(&mut rng), std::f64::consts::TAU * uniform(&mut rng));
        let scale = radius * (0.5 + uniform(&mut rng));
        let matrix3 = DMat3::from_quat(rotation) * scale;
        let transform = DAffine3 { matrix3, translation: uniform_point(&mut rng) * 0.95 };
        Instance { mesh: 1, transform }
    }));
    (vec![room(), ball(cuts)], instances)
}

/// The same scene as a single mesh, with vertices rounded to `f32`.
pub fn flat(triangles: usize) -> Placed {
    let (meshes, instances) = instanced(triangles);
    let mut all = Mesh::default();
    for instance in instances {
        let mesh = &meshes[instance.mesh as usize];
        let first = all.positions.len() as u32;
        all.positions.extend(mesh.positions.iter().map(|&p| single(instance.transform.transform_point3(p))));
        all.triangles.extend(mesh.triangles.iter().map(|corners| corners.map(|vertex| first + vertex)));
    }
    (vec![all], vec![Instance { mesh: 0, transform: DAffine3::IDENTITY }])
}

/// Points of a flat scene's surfaces, uniform by area.
struct Surfaces<'a> {
    world: &'a World,
    /// Running sums of the triangles' areas.
    areas: Vec<f64>,
}

impl<'a> Surfaces<'a> {
    fn new(world: &'a World) -> Self {
        let mut sum = 0.0;
        let areas = (0..world.triangle_count(0) as u32)
            .map(|triangle| {
                let [a, b, c] = world.triangle(0, triangle);
                sum += (b - a).cross(c - a).length() * 0.5;
                sum
            })
            .collect();
        Self { world, areas }
    }

    /// A point a little off the front of a surface, and the normal there.
    fn sample(&self, rng: &mut Pcg64) -> (DVec3, DVec3) {
        let at = uniform(rng) * self.areas[self.areas.len() - 1];
        let triangle = self.areas.partition_point(|sum| *sum <= at).min(self.areas.len() - 1);
        let root = uniform(rng).sqrt();
        let (u, v) = (1.0 - root, uniform(rng) * root);
        let surface = self.world.surface_at(0, triangle as u32, u, v);
        (surface.position + surface.ng * LIFT, surface.ng)
    }
}

/// Rays for the closest hit: of a camera, row by row; from surfaces into the half space before them; from points of the room
/// in all directions. `world` is the flat scene.
pub fn rays(world: &World, kind: &str, count: usize) -> Vec<Ray> {
    let mut rng = Pcg64::new(2, 1);
    let ray = |origin: DVec3, direction: DVec3| Ray { origin: single(origin), direction: single(direction) };
    match kind {
        "camera" => {
            let width = (count as f64).sqrt().ceil() as usize;
            let at = |i: usize| (2.0 * (i as f64 + 0.5) / width as f64 - 1.0) * HALF_WIDTH;
            (0..count).map(|i| ray(EYE, DVec3::new(at(i % width), -at(i / width), -1.0).normalize())).collect()
        }
        "surface" => {
            let surfaces = Surfaces::new(world);
            let mut sample = || {
                let (origin, normal) = surfaces.sample(&mut rng);
                let direction = uniform_direction(&mut rng);
                ray(origin, if direction.dot(normal) < 0.0 { -direction } else { direction })
            };
            (0..count).map(|_| sample()).collect()
        }
        _ => (0..count).map(|_| ray(uniform_point(&mut rng), uniform_direction(&mut rng))).collect(),
    }
}

/// Segments for visibility, from the end that [`World::visible`] starts at to the other: from what a camera sees to a lamp under
/// the ceiling; between points of surfaces; between points of the room. `world` is the flat scene.
pub fn segments(world: &World, kind: &str, count: usize) -> Vec<[Anchor; 2]> {
    let mut rng = Pcg64::new(3, 1);
    let segment = |a: DVec3, b: DVec3| {
        let mut ends = [single(a), single(b)];
        if ends[0].to_array() > ends[1].to_array() {
            ends.swap(0, 1);
        }
        // In free space, so that the ends are not moved.
        ends.map(|position| Anchor { position, normal: DVec3::ZERO })
    };
    match kind {
        "camera" => rays(world, kind, count)
            .iter()
            .map(|ray| {
                let lamp = DVec3::new(0.4 * uniform(&mut rng) - 0.2, 0.99, 0.4 * uniform(&mut rng) - 0.2);
                let seen = world.intersect(ray).map_or(DVec3::ZERO, |hit| {
                    let surface = world.surface(&hit);
                    surface.position + surface.ng * LIFT.copysign(-surface.ng.dot(ray.direction))
                });
                segment(seen, lamp)
            })
            .collect(),
        "surface" => {
            let surfaces = Surfaces::new(world);
            (0..count).map(|_| segment(surfaces.sample(&mut rng).0, surfaces.sample(&mut rng).0)).collect()
        }
        _ => (0..count).map(|_| segment(uniform_point(&mut rng), uniform_point(&mut rng))).collect(),
    }
}
