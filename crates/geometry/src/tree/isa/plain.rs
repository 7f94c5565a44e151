//! Plain Rust, for every processor.

use super::super::{
    Block,
    node::{Node, WIDTH},
    ray::TreeRay,
};
use super::search::search;
use crate::triangle::Shear;

/// What a search keeps of its ray.
#[derive(Clone, Copy)]
pub(super) struct Slabs {
    ray: TreeRay,
}

impl Slabs {
    #[inline]
    pub(super) fn new(ray: &TreeRay) -> Self {
        Self { ray: *ray }
    }

    /// Which children's boxes the ray meets before `t_max`, and where it enters them.
    #[inline]
    pub(super) fn meets(&self, node: &Node, t_max: f32) -> (u32, [f32; WIDTH]) {
        let mut near = [0f32; WIDTH];
        let mut far = [t_max; WIDTH];
        for axis in 0..3 {
            let side = self.ray.near[axis] & 1;
            let (origin, inverse) = (self.ray.origin[axis], self.ray.inverse[axis]);
            let (first, second) = (&node.planes[axis][side], &node.planes[axis][side ^ 1]);
            for i in 0..WIDTH {
                near[i] = near[i].max((first[i] - origin) * inverse);
                far[i] = far[i].min((second[i] - origin) * inverse);
            }
        }
        let mut mask = 0;
        for i in 0..WIDTH {
            mask |= u32::from(near[i] <= far[i]) << i;
        }
        (mask, near)
    }
}

/// The ray of [`Shear`] for a block at a time.
#[derive(Clone, Copy)]
pub(super) struct Edges {
    pub(super) shear: Shear,
}

impl Edges {
    #[inline]
    pub(super) fn new(shear: &Shear) -> Self {
        Self { shear: *shear }
    }

    /// Which triangles the line may cross; where, is left to [`Shear::cross`].
    #[inline]
    pub(super) fn cross(&self, block: &Block, _t_max: f64) -> Crossings {
        let Shear { origin: [ox, oy, oz], axes: [x, y, z], slope: [sx, sy], .. } = self.shear;
        let mut sheared = [[[0.0; LANES]; 2]; 3];
        for (corner, out) in block.vertices.iter().zip(&mut sheared) {
            for i in 0..LANES {
                let depth = corner[z][i] - oz;
                out[0][i] = (corner[x][i] - ox) - sx * depth;
                out[1][i] = (corner[y][i] - oy) - sy * depth;
            }
        }
        let [[ax, ay], [bx, by], [cx, cy]] = sheared;
        let mut mask = 0;
        for i in 0..LANES {
            let wa = cx[i] * by[i] - cy[i] * bx[i];
            let wb = ax[i] * cy[i] - ay[i] * cx[i];
            let wc = bx[i] * ay[i] - by[i] * ax[i];
            let below = wa < 0.0 || wb < 0.0 || wc < 0.0;
            let above = wa > 0.0 || wb > 0.0 || wc > 0.0;
            mask |= u32::from(!(below && above)) << i;
        }
        Crossings::possible(mask)
    }
}

/// There is no portable way to ask for memory that will be needed soon.
#[inline(always)]
fn fetch(_nodes: &[Node], _blocks: &[Block], _child: Child) {}

search!();
