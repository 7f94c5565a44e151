//! The triangles of a tree, in its order, four side by side for SIMD.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use crate::{placement::Placement, triangle::Triangle};

/// Triangles of a block.
pub(crate) const LANES: usize = 4;

/// The same number of four triangles.
pub(crate) type Quad = [f64; LANES];

/// Vertices of four triangles: for each vertex, for each axis.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(32))]
pub(crate) struct Block(pub(crate) [[Quad; 3]; 3]);

impl Block {
    pub(crate) const EMPTY: Self = Self([[[0.0; LANES]; 3]; 3]);

    pub(crate) fn set(&mut self, lane: usize, triangle: &Triangle) {
        for (corner, vertex) in self.0.iter_mut().zip(triangle) {
            for axis in 0..3 {
                corner[axis][lane] = vertex[axis];
            }
        }
    }

    #[inline(always)]
    pub(crate) fn triangle(&self, lane: usize) -> Triangle {
        self.0.map(|corner| DVec3::new(corner[0][lane], corner[1][lane], corner[2][lane]))
    }

    /// The triangles of an instance of the mesh, with the bits that [`Placement::point`] gives.
    #[inline(always)]
    pub(crate) fn placed(&self, placement: &Placement) -> Self {
        let (m, t) = (placement.transform.matrix3, placement.transform.translation);
        let mut placed = Self::EMPTY;
        for (corner, out) in self.0.iter().zip(&mut placed.0) {
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
