//! Triangle meshes as they come from a file, before anything is built over them.

use glam::{DVec2, DVec3, DVec4};

use crate::triangle::Triangle;

/// A triangle mesh in its own space. All present attributes have one entry a vertex.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Vertex indices, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Unit vertex normals; `None` means flat shading.
    pub normals: Option<Vec<DVec3>>,
    /// Unit tangents with the sign of the bitangent in `w`.
    pub tangents: Option<Vec<DVec4>>,
    /// Two sets of texture coordinates.
    pub texcoords: [Option<Vec<DVec2>>; 2],
    /// Linear vertex colours with alpha.
    pub colors: Option<Vec<DVec4>>,
}

impl Mesh {
    /// The corners of a triangle. Panics if there is no such triangle.
    #[inline(always)]
    pub(crate) fn corners(&self, triangle: u32) -> Triangle {
        self.triangles[triangle as usize].map(|vertex| self.positions[vertex as usize])
    }
}
