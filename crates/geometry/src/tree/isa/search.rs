//! The search itself, written once and compiled for each set of instructions.
//!
//! A module that calls the macro has `Slabs`, which asks a node, and `Edges`, which asks a block.

/// Defines `closest` and `any` over triangles and `members` over the boxes of instances.
macro_rules! search {
    ($($(#[$features:meta])+)?) => {
        use std::borrow::Borrow;

        use crate::tree::{
            blocks::{Crossings, LANES, Owner},
            node::Child,
            stack::{Stack, child_of, enters_at, entry},
        };
        use crate::triangle::Crossing;

        /// Calls `look` for the leaves that the ray meets before `t_max`, the nearer first if they are `ORDERED`, until it returns
        /// true. It is given the place of the leaf's first primitive and their number, and returns the new `t_max`, or `None` to
        /// end the search.
        $($(#[$features])+)?
        #[inline]
        fn walk<const ORDERED: bool>(
            nodes: &[Node],
            blocks: &[Block],
            ray: &TreeRay,
            mut look: impl FnMut(usize, usize, f32) -> Option<f32>,
        ) -> bool {
            let slabs = Slabs::new(ray);
            let mut t_max = ray.t_max;
            let mut stack = Stack::new();
            let mut child = Child::node(0);
            loop {
                if child.is_leaf() {
                    let (first, count) = child.primitives();
                    let Some(t) = look(first, count, t_max) else { return true };
                    t_max = t;
                } else {
                    let node = &nodes[child.0 as usize];
                    let (mut mask, enters) = slabs.meets(node, t_max);
                    if mask != 0 {
                        // First of all, also for the only child, whose lines would else be asked for one by one.
                        let mut left = mask;
                        while left != 0 {
                            fetch(nodes, blocks, node.children[left.trailing_zeros() as usize & 7]);
                            left &= left - 1;
                        }
                        let i = mask.trailing_zeros() as usize;
                        mask &= mask - 1;
                        child = node.children[i & 7];
                        if mask == 0 {
                            continue;
                        }
                        let mut nearest = entry(enters[i & 7], child);
                        if ORDERED {
                            let base = stack.len();
                            while mask != 0 {
                                let i = mask.trailing_zeros() as usize & 7;
                                mask &= mask - 1;
                                let next = entry(enters[i], node.children[i]);
                                stack.insert(base, nearest.max(next));
                                nearest = nearest.min(next);
                            }
                        } else {
                            while mask != 0 {
                                let i = mask.trailing_zeros() as usize & 7;
                                mask &= mask - 1;
                                stack.push(nearest);
                                nearest = entry(enters[i], node.children[i]);
                            }
                        }
                        child = child_of(nearest);
                        continue;
                    }
                }
                loop {
                    let Some(next) = stack.pop() else { return false };
                    if enters_at(next) <= t_max {
                        child = child_of(next);
                        break;
                    }
                }
            }
        }

        /// Calls `take` for every crossing with a triangle nearer than `t_max`, and with its owner; it returns the new `t_max`.
        $($(#[$features])+)?
        #[inline]
        pub(crate) fn closest<'b, B: Borrow<Block>>(
            nodes: &[Node],
            ray: &TreeRay,
            shear: &Shear,
            mut t_max: f64,
            blocks: &'b [Block],
            view: impl Fn(&'b Block) -> B,
            mut take: impl FnMut(Crossing, Owner) -> Option<f64>,
        ) {
            let edges = Edges::new(shear);
            walk::<true>(nodes, blocks, ray, |first, count, mut far| {
                let block = view(&blocks[first]);
                let block = block.borrow();
                let crossings: Crossings = edges.cross(block, t_max);
                let mut mask = crossings.possible & ((1 << count) - 1);
                while mask != 0 {
                    let lane = mask.trailing_zeros() as usize & (LANES - 1);
                    mask &= mask - 1;
                    let crossing = if crossings.certain >> lane & 1 == 1 {
                        // It was certain for the t_max before.
                        Some(crossings.at(lane)).filter(|crossing| crossing.t <= t_max)
                    } else {
                        shear.cross(&block.triangle(lane), t_max)
                    };
                    if let Some(crossing) = crossing
                        && let Some(t) = take(crossing, block.owners[lane])
                    {
                        t_max = t;
                        far = ray.above(t);
                    }
                }
                Some(far)
            });
        }

        /// Whether any triangle is crossed nearer than `t_max`.
        $($(#[$features])+)?
        #[inline]
        pub(crate) fn any<'b, B: Borrow<Block>>(
            nodes: &[Node],
            ray: &TreeRay,
            shear: &Shear,
            t_max: f64,
            blocks: &'b [Block],
            view: impl Fn(&'b Block) -> B,
        ) -> bool {
            let edges = Edges::new(shear);
            walk::<false>(nodes, blocks, ray, |first, count, far| {
                let block = view(&blocks[first]);
                let block = block.borrow();
                let lanes = (1 << count) - 1;
                let crossings: Crossings = edges.cross(block, t_max);
                if crossings.certain & lanes != 0 {
                    return None;
                }
                let mut mask = crossings.possible & lanes;
                while mask != 0 {
                    let lane = mask.trailing_zeros() as usize & (LANES - 1);
                    mask &= mask - 1;
                    if shear.cross(&block.triangle(lane), t_max).is_some() {
                        return None;
                    }
                }
                Some(far)
            })
        }

        /// Calls `look` for the primitives whose boxes the ray meets, until it returns true; it may lower the greatest parameter.
        $($(#[$features])+)?
        #[inline]
        pub(crate) fn members(
            nodes: &[Node],
            ray: &TreeRay,
            mut look: impl FnMut(usize, &mut f32) -> bool,
        ) -> bool {
            walk::<true>(nodes, &[], ray, |first, count, mut far| {
                (first..first + count).all(|i| !look(i, &mut far)).then_some(far)
            })
        }
    };
}

pub(super) use search;
