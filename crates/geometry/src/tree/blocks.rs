//! The triangles of a tree, in its order, four side by side for SIMD.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use crate::placement::Placement;
use crate::triangle::{Crossing, Triangle};

/// Triangles of a block.
pub(crate) const LANES: usize = 4;

/// The same number of four triangles.
pub(crate) type Quad = [f64; LANES];

/// Four triangles: five cache lines.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Block {
    /// For each vertex, for each axis.
    pub(crate) vertices: [[Quad; 3]; 3],
    /// Which instance, and which of its triangles.
    pub(crate) owners: [Owner; LANES],
}

/// Which instance, and which of its triangles. The order breaks ties between hits at the same t, so that the answer does not
/// depend on the order of the search.
pub(crate) type Owner = [u32; 2];

/// What a set of instructions finds out about a ray and the triangles of a block at once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossings {
    /// The lanes whose triangles may be crossed: none that the whole test would find is missing.
    pub(crate) possible: u32,
    /// Those of them that are crossed, with the bits of the whole test below.
    pub(crate) certain: u32,
    pub(crate) t: Quad,
    pub(crate) u: Quad,
    pub(crate) v: Quad,
}

impl Crossings {
    /// Lanes that only the whole test can tell about.
    #[inline(always)]
    pub(crate) fn possible(lanes: u32) -> Self {
        Self { possible: lanes, certain: 0, t: [0.0; LANES], u: [0.0; LANES], v: [0.0; LANES] }
    }

    /// What is known of a certain lane.
    #[inline(always)]
    pub(crate) fn at(&self, lane: usize) -> Crossing {
        Crossing { t: self.t[lane], u: self.u[lane], v: self.v[lane] }
    }
}

impl Block {
    pub(crate) fn set(&mut self, lane: usize, triangle: &Triangle, owner: Owner) {
        self.owners[lane] = owner;
        for (corner, vertex) in self.vertices.iter_mut().zip(triangle) {
            for axis in 0..3 {
                corner[axis][lane] = vertex[axis];
            }
        }
    }

    #[inline(always)]
    pub(crate) fn triangle(&self, lane: usize) -> Triangle {
        self.vertices.map(|corner| DVec3::new(corner[0][lane], corner[1][lane], corner[2][lane]))
    }

    /// The triangles of an instance of the mesh, with the bits that [`Placement::point`] gives.
    #[inline(always)]
    pub(crate) fn placed(&self, placement: &Placement) -> Self {
        let (m, t) = (placement.transform.matrix3, placement.transform.translation);
        let mut placed = Self { vertices: [[[0.0; LANES]; 3]; 3], owners: self.owners };
        for (corner, out) in self.vertices.iter().zip(&mut placed.vertices) {
            for axis in 0..3 {
                for lane in 0..LANES {
                    let [x, y, z] = corner.map(|quad| quad[lane]);
                    out[axis][lane] = m.x_axis[axis] * x + m.y_axis[axis] * y + m.z_axis[axis] * z + t[axis];
                }
            }
        }
        placed
    }
}
