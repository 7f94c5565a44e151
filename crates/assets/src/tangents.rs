//! Tangents for meshes that have a normal map and no tangents, by the MikkTSpace algorithm, as glTF asks for
//! (section 3.7.2.1).

use std::collections::HashMap;

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use ergodic_geometry::Mesh;
use glam::{DVec2, DVec3, DVec4};

struct Corners<'a> {
    mesh: &'a Mesh,
    normals: &'a [DVec3],
    texcoords: &'a [DVec2],
    tangents: Vec<DVec4>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[face][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)].as_vec3().to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.normals[self.vertex(face, corner)].as_vec3().to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        // MikkTSpace has v upwards, glTF downwards.
        let uv = self.texcoords[self.vertex(face, corner)];
        [uv.x as f32, 1.0 - uv.y as f32]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let [x, y, z, sign] = space.unwrap_or_default().tangent_encoded();
        self.tangents[3 * face + corner] =
            DVec4::new(f64::from(x), f64::from(y), f64::from(z), if sign < 0.0 { -1.0 } else { 1.0 });
    }
}

/// A mesh in which no two triangles share a vertex.
fn split(mesh: &Mesh) -> Mesh {
    let order: Vec<usize> = mesh.triangles.iter().flatten().map(|&i| i as usize).collect();
    Mesh {
        positions: pick(&mesh.positions, &order),
        triangles: (0..mesh.triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        normals: mesh.normals.as_ref().map(|list| pick(list, &order)),
        tangents: mesh.tangents.as_ref().map(|list| pick(list, &order)),
        texcoords: [0, 1].map(|set| mesh.texcoords[set].as_ref().map(|list| pick(list, &order))),
        colors: mesh.colors.as_ref().map(|list| pick(list, &order)),
    }
}

fn pick<T: Copy>(list: &[T], order: &[usize]) -> Vec<T> {
    order.iter().map(|&i| list[i]).collect()
}

/// Gives a mesh without normals those of its triangles.
fn flat(mesh: &mut Mesh) {
    *mesh = split(mesh);
    let normal = |&[a, b, c]: &[u32; 3]| {
        let [a, b, c] = [a, b, c].map(|i| mesh.positions[i as usize]);
        (b - a).cross(c - a).normalize_or_zero()
    };
    mesh.normals = Some(mesh.triangles.iter().flat_map(|t| [normal(t); 3]).collect());
}

/// Gives the mesh tangents along the texture coordinates `set`. Vertices at which the tangent jumps are doubled. Does
/// nothing for a mesh without these coordinates.
pub(crate) fn generate(mesh: &mut Mesh, set: usize) {
    if mesh.texcoords[set].is_none() || mesh.triangles.is_empty() {
        return;
    }
    if mesh.normals.is_none() {
        flat(mesh);
    }
    let (Some(normals), Some(texcoords)) = (&mesh.normals, &mesh.texcoords[set]) else { return };
    let tangents = vec![DVec4::ZERO; 3 * mesh.triangles.len()];
    let mut corners = Corners { mesh, normals, texcoords, tangents };
    if generate_tangents(&mut corners).is_err() {
        return;
    }
    let tangents = corners.tangents;

    // One vertex for each pair of an old vertex and a tangent.
    let mut known: HashMap<(u32, [u64; 4]), u32> = HashMap::new();
    let mut order = Vec::new();
    let mut kept = Vec::new();
    let mut triangles = mesh.triangles.clone();
    for (corner, &tangent) in triangles.as_flattened_mut().iter_mut().zip(&tangents) {
        let key = (*corner, tangent.to_array().map(f64::to_bits));
        let old = *corner;
        *corner = *known.entry(key).or_insert_with(|| {
            order.push(old as usize);
            kept.push(tangent);
            kept.len() as u32 - 1
        });
    }
    *mesh = Mesh {
        positions: pick(&mesh.positions, &order),
        triangles,
        normals: mesh.normals.as_ref().map(|list| pick(list, &order)),
        tangents: Some(kept),
        texcoords: [0, 1].map(|set| mesh.texcoords[set].as_ref().map(|list| pick(list, &order))),
        colors: mesh.colors.as_ref().map(|list| pick(list, &order)),
    };
}
