//! The surface at a point of a triangle: position, normals, tangent and the other vertex attributes, in world space.

use glam::{DVec2, DVec3, DVec4};

use crate::{Hit, World};

/// A point of a surface, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// The point, from the barycentrics.
    pub position: DVec3,
    /// Unit geometric normal on the triangle's front: the side from which the vertices run counter-clockwise in the mesh's own
    /// space, also where the instance mirrors it.
    pub ng: DVec3,
    /// Unit shading normal, on the side of `ng`.
    pub ns: DVec3,
    /// Unit tangent along the first texture coordinate; zero if the mesh has none.
    pub tangent: DVec3,
    /// The bitangent is `ns × tangent` times this, 1 or -1; zero if the mesh has no tangents.
    pub bitangent_sign: f64,
    /// Both sets of texture coordinates; zero if the mesh has none.
    pub texcoords: [DVec2; 2],
    /// Linear colour and alpha; one if the mesh has none.
    pub color: DVec4,
    /// Which instance.
    pub instance: u32,
    /// Which triangle of its mesh.
    pub triangle: u32,
}

impl World {
    /// The surface at a hit.
    #[inline]
    pub fn surface(&self, hit: &Hit) -> Surface {
        self.surface_at(hit.instance, hit.triangle, hit.u, hit.v)
    }

    /// The surface at the point with barycentrics `u`, `v` of the vertices 1 and 2 of a triangle. Panics if there is no
    /// such triangle.
    #[inline]
    pub fn surface_at(&self, instance: u32, triangle: u32, u: f64, v: f64) -> Surface {
        let placement = self.placement(instance);
        let mesh = self.mesh(placement.mesh);
        let [a, b, c] = mesh.triangles[triangle as usize];
        let corners = [a as usize, b as usize, c as usize];
        let vertex = |corner: usize| placement.point(mesh.positions[corner]);
        let (a, b, c) = (vertex(corners[0]), vertex(corners[1]), vertex(corners[2]));
        let w = 1.0 - u - v;
        let position = a * w + b * u + c * v;
        let ng = unit_normal(a, b, c) * placement.handedness;

        let mut ns = ng;
        let mut flipped = 1.0;
        if let Some(normals) = &mesh.normals {
            let [a, b, c] = corners.map(|i| normals[i]);
            if let Some(n) = (placement.normals * (a * w + b * u + c * v)).try_normalize() {
                if n.dot(ng) < 0.0 {
                    flipped = -1.0;
                }
                ns = n * flipped;
            }
        }
        let mut tangent = DVec3::ZERO;
        let mut bitangent_sign = 0.0;
        if let Some(tangents) = &mesh.tangents {
            let [a, b, c] = corners.map(|i| tangents[i]);
            let t = placement.transform.matrix3 * (a * w + b * u + c * v).truncate();
            if let Some(t) = t.try_normalize() {
                tangent = t;
                // Mirroring turns n × t around against the transformed bitangent, and so does flipping n.
                bitangent_sign = 1f64.copysign(a.w) * placement.handedness * flipped;
            }
        }
        // Written out: few meshes have either, and none of the others should pay for it.
        let at = |uv: &Vec<DVec2>| uv[corners[0]] * w + uv[corners[1]] * u + uv[corners[2]] * v;
        let mut texcoords = [DVec2::ZERO; 2];
        if let Some(uv) = &mesh.texcoords[0] {
            texcoords[0] = at(uv);
        }
        if let Some(uv) = &mesh.texcoords[1] {
            texcoords[1] = at(uv);
        }
        let mut color = DVec4::ONE;
        if let Some(colors) = &mesh.colors {
            color = colors[corners[0]] * w + colors[corners[1]] * u + colors[corners[2]] * v;
        }
        Surface { position, ng, ns, tangent, bitangent_sign, texcoords, color, instance, triangle }
    }
}

/// The unit normal of a triangle. A triangle that has none gets a unit vector anyway, across its longer side where it
/// has one.
#[inline]
fn unit_normal(a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    let (ab, ac) = (b - a, c - a);
    if let Some(n) = ab.cross(ac).try_normalize() {
        return n;
    }
    let longest = ab.abs().max(ac.abs()).max_element();
    let (ab, ac) = (ab / longest, ac / longest);
    let side = if ab.length_squared() > ac.length_squared() { ab } else { ac };
    ab.cross(ac).try_normalize().or(side.try_normalize().map(DVec3::any_orthonormal_vector)).unwrap_or(DVec3::Z)
}
