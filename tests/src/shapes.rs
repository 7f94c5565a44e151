//! Meshes and materials that tests build scenes of.

use std::f64::consts::PI;

use ergodic_geometry::Mesh;
use ergodic_pathspace::{Placement, Scene, SceneDescription};
use ergodic_scattering::{Material, PunctualLight, Rgb};
use glam::{DAffine3, DVec3};

use crate::{Eye, view_of};

/// A parallelogram; its front is where `u`, `v` run counter-clockwise.
pub fn quad(origin: DVec3, u: DVec3, v: DVec3) -> Mesh {
    Mesh {
        positions: vec![origin, origin + u, origin + u + v, origin + v],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// A box about the origin whose front is its outside, or its inside.
pub fn cuboid(half: DVec3, inward: bool) -> Mesh {
    let corner = |i: u32| DVec3::from_array(std::array::from_fn(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 }));
    let mut triangles = Vec::new();
    for axis in 0..3 {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        for side in [0, 1] {
            let [a, b, c, d] = [0, u, u | v, v].map(|i| i | side << axis);
            triangles.extend(if (side == 1) != inward { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
        }
    }
    Mesh { positions: (0..8).map(|i| half * corner(i)).collect(), triangles, ..Mesh::default() }
}

/// A sphere of `slices` by half as many stacks, its poles on the z axis; its front is its outside, or its inside.
pub fn sphere(centre: DVec3, radius: f64, slices: u32, inward: bool) -> Mesh {
    let stacks = slices / 2;
    let position = |i: u32, j: u32| {
        let (theta, phi) = (PI * f64::from(i) / f64::from(stacks), 2.0 * PI * f64::from(j) / f64::from(slices));
        centre + radius * DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    };
    let positions = (0..=stacks).flat_map(|i| (0..slices).map(move |j| position(i, j))).collect();
    let mut triangles = Vec::new();
    for i in 0..stacks {
        for j in 0..slices {
            let [a, b] = [i, i + 1].map(|i| i * slices + j);
            let [d, c] = [i, i + 1].map(|i| i * slices + (j + 1) % slices);
            // At a pole one triangle of the two is a point.
            let both = [(i + 1 < stacks, [a, b, c]), (i > 0, [a, c, d])];
            triangles.extend(both.iter().filter(|(is_triangle, _)| *is_triangle).map(|(_, triangle)| *triangle));
        }
    }
    if inward {
        triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    Mesh { positions, triangles, ..Mesh::default() }
}

/// Lambert's surface, which may emit from its front.
pub fn diffuse(albedo: f64, emission: f64) -> Material {
    Material {
        metallic: 0.0,
        specular: 0.0,
        base_color: Rgb::splat(albedo),
        emission: Rgb::splat(emission),
        ..Material::default()
    }
}

/// A perfect mirror.
pub fn mirror() -> Material {
    Material { metallic: 1.0, roughness: 0.0, ..Material::default() }
}

/// Clear, perfectly smooth glass.
pub fn glass(ior: f64) -> Material {
    Material { metallic: 0.0, roughness: 0.0, transmission: 1.0, solid: true, ior, ..Material::default() }
}

/// A thing: its mesh and what it is made of.
pub type Thing = (Mesh, Material);

/// Things and lights, each in its own place, seen by an eye.
pub fn description_of(things: Vec<Thing>, lights: Vec<PunctualLight>, eye: &Eye) -> SceneDescription {
    let (meshes, materials): (Vec<_>, Vec<_>) = things.into_iter().unzip();
    let placements =
        (0..meshes.len()).map(|i| Placement { mesh: i, material: i, transform: DAffine3::IDENTITY }).collect();
    let cameras = vec![eye.description()];
    SceneDescription { meshes, placements, materials, lights, cameras, ..SceneDescription::default() }
}

/// The same as a scene, for a square picture with the box filter.
pub fn scene_of(things: Vec<Thing>, lights: Vec<PunctualLight>, eye: &Eye, side: u32) -> Scene {
    view_of(description_of(things, lights, eye), (side, side))
}
