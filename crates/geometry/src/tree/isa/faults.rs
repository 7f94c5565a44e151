//! Planted faults: sets of instructions that are wrong in one thing, which the tests must notice.

use super::super::{
    Block,
    node::{Node, WIDTH},
    ray::TreeRay,
};
use super::search::search;
use crate::triangle::Shear;

/// The edge functions are fused, so that some signs are not those of the whole test.
pub(super) mod fused {
    use super::super::plain::Slabs;
    use super::*;

    struct Edges(Shear);

    impl Edges {
        fn new(shear: &Shear) -> Self {
            Self(*shear)
        }

        fn cross(&self, block: &Block, _t_max: f64) -> Crossings {
            let Shear { origin: [ox, oy, oz], axes: [x, y, z], slope: [sx, sy], .. } = self.0;
            let lanes = (0..LANES).fold(0, |mask, lane| {
                let [[ax, ay], [bx, by], [cx, cy]] = block.triangle(lane).map(|p| {
                    let depth = p[z] - oz;
                    [(p[x] - ox) - sx * depth, (p[y] - oy) - sy * depth]
                });
                let edges = [cx.mul_add(by, -(cy * bx)), ax.mul_add(cy, -(ay * cx)), bx.mul_add(ay, -(by * ax))];
                let both = edges.iter().any(|w| *w < 0.0) && edges.iter().any(|w| *w > 0.0);
                mask | u32::from(!both) << lane
            });
            Crossings::possible(lanes)
        }
    }

    fn fetch(_nodes: &[Node], _blocks: &[Block], _child: Child) {}

    search!();
}

/// Where an edge function is zero, a crossing is taken for certain all the same.
pub(super) mod hasty {
    use super::super::plain::Slabs;
    use super::*;

    struct Edges(Shear);

    impl Edges {
        fn new(shear: &Shear) -> Self {
            Self(*shear)
        }

        fn cross(&self, block: &Block, t_max: f64) -> Crossings {
            let Shear { origin: [ox, oy, oz], axes: [x, y, z], slope: [sx, sy], per_z } = self.0;
            let mut crossings = Crossings::possible(0);
            for lane in 0..LANES {
                let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = block.triangle(lane).map(|p| {
                    let depth = p[z] - oz;
                    [(p[x] - ox) - sx * depth, (p[y] - oy) - sy * depth, depth]
                });
                let edges = [cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax];
                let both = edges.iter().any(|w| *w < 0.0) && edges.iter().any(|w| *w > 0.0);
                let [wa, wb, wc] = edges;
                let inverse = 1.0 / (wa + wb + wc);
                let t = (wa * az + wb * bz + wc * cz) * per_z * inverse;
                if !both && t > 0.0 && t <= t_max {
                    crossings.possible |= 1 << lane;
                    crossings.certain |= 1 << lane;
                    (crossings.t[lane], crossings.u[lane], crossings.v[lane]) = (t, wb * inverse, wc * inverse);
                }
            }
            crossings
        }
    }

    fn fetch(_nodes: &[Node], _blocks: &[Block], _child: Child) {}

    search!();
}

/// The padding is taken off the boxes.
pub(super) mod unpadded {
    use super::super::plain::{self, Edges};
    use super::*;
    use crate::epsilon::TREE_PADDING;

    struct Slabs(plain::Slabs);

    impl Slabs {
        fn new(ray: &TreeRay) -> Self {
            Self(plain::Slabs::new(ray))
        }

        fn meets(&self, node: &Node, t_max: f32) -> (u32, [f32; WIDTH]) {
            let mut node = *node;
            for [lower, upper] in &mut node.planes {
                lower.iter_mut().for_each(|plane| *plane += TREE_PADDING as f32);
                upper.iter_mut().for_each(|plane| *plane -= TREE_PADDING as f32);
            }
            self.0.meets(&node, t_max)
        }
    }

    fn fetch(_nodes: &[Node], _blocks: &[Block], _child: Child) {}

    search!();
}
