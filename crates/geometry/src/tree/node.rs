//! The nodes of a tree: up to eight children, with their boxes side by side for SIMD.

use bytemuck::{Pod, Zeroable};
use obvhs::aabb::Aabb;

/// Children of a node.
pub(crate) const WIDTH: usize = 8;

/// A child of a node: another node, or a leaf.
///
/// Bit 31 marks leaves; they hold the place of their first primitive in the order of the tree, and their number less one in
/// the lowest three bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub(crate) struct Child(pub(crate) u32);

impl Child {
    /// Stands where there is no child. Its box is empty, so it is never asked.
    pub(crate) const NONE: Self = Self(u32::MAX);

    /// Nodes and places of leaves are below this: a tree has no more primitives.
    pub(crate) const LIMIT: usize = 1 << 28;

    pub(crate) fn node(index: usize) -> Self {
        Self(index as u32)
    }

    pub(crate) fn leaf(first: usize, count: usize) -> Self {
        Self(1 << 31 | (first as u32) << 3 | (count as u32 - 1))
    }

    #[inline(always)]
    pub(crate) fn is_leaf(self) -> bool {
        self.0 >> 31 != 0
    }

    /// Place of the first primitive and number of primitives of a leaf.
    #[inline(always)]
    pub(crate) fn primitives(self) -> (usize, usize) {
        ((self.0 >> 3 & (Self::LIMIT as u32 - 1)) as usize, (self.0 & 7) as usize + 1)
    }
}

/// A node: four cache lines.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Node {
    /// For each axis the lower and the upper planes of the children's boxes.
    pub(crate) planes: [[[f32; WIDTH]; 2]; 3],
    pub(crate) children: [Child; WIDTH],
    /// Fills the last cache line.
    unused: [u32; WIDTH],
}

impl Node {
    /// A node without children: every box is inside out.
    pub(crate) const EMPTY: Self = Self {
        planes: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3],
        children: [Child::NONE; WIDTH],
        unused: [0; WIDTH],
    };

    pub(crate) fn set(&mut self, index: usize, bounds: &Aabb, child: Child) {
        for axis in 0..3 {
            self.planes[axis][0][index] = bounds.min[axis];
            self.planes[axis][1][index] = bounds.max[axis];
        }
        self.children[index] = child;
    }
}
