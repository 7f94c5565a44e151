//! From boxes to a tree: obvhs builds a binary one (PLOC, Meister and Bittner 2018, with reinsertion), which is made wide here
//! at the least cost (Ylitie, Karras and Laine 2017).

use std::time::Duration;

use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2},
};

use super::{
    node::{Child, Node, WIDTH},
    pages::Pages,
};

/// Nodes over primitives.
#[derive(Debug)]
pub(crate) struct Tree {
    pub(crate) nodes: Pages<Node>,
}

/// A leaf takes at most this many primitives: they are tested together.
const TOGETHER: usize = 4;

/// What it costs to look into a leaf, of which a node costs 1.
const LEAF_COST: f32 = 1.0;

/// What obvhs takes a node of its binary tree to cost where it decides about leaves, of which a primitive costs 1. Few are left
/// to wide nodes, which decide by [`LEAF_COST`].
const COLLAPSE_COST: f32 = 1.0;

/// Passes of obvhs that look only at the next boxes for a neighbour (search distance 1). Most searches are faster by 2 % than
/// with 3; with 1 they are faster in large worlds and slower in small ones.
const NEAR_PASSES: usize = 2;

/// The share of a binary tree's nodes that obvhs tries to put elsewhere (Meister and Bittner 2018): the greater, the fewer they are, as
/// it takes a tenth of a second for 20 000 of them and makes rays cheaper by up to 4 %. Of more than a million primitives as many nodes are
/// tried as of a million: the gain is among the largest nodes, which are tried first, and the time would be longer than that of all
/// the rest of the build.
fn reinserted(primitives: usize) -> f32 {
    let primitives = primitives as f32;
    (2e4 / primitives).clamp(0.05, 0.3) * (1e6 / primitives).min(1.0)
}

/// The primitives of a tree, leaf by leaf.
pub(crate) struct Leaves {
    numbers: Vec<u32>,
    /// Where each leaf begins, and the end.
    starts: Vec<u32>,
}

impl Leaves {
    pub(crate) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The numbers of a leaf's primitives.
    pub(crate) fn of(&self, leaf: usize) -> &[u32] {
        &self.numbers[self.starts[leaf] as usize..self.starts[leaf + 1] as usize]
    }

    /// The numbers of all primitives.
    pub(crate) fn all(&self) -> &[u32] {
        &self.numbers
    }
}

/// What a node says of a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// Its number among the leaves.
    Leaf,
    /// The place of its first primitive among all.
    First,
}

impl Tree {
    /// Builds the tree over padded boxes; there is at least one, and no more than [`Child::LIMIT`].
    pub(crate) fn build(boxes: Vec<Aabb>, place: Place) -> (Self, Leaves) {
        let parameters = BvhBuildParams {
            max_prims_per_leaf: TOGETHER as u32,
            collapse_traversal_cost: COLLAPSE_COST,
            search_depth_threshold: NEAR_PASSES,
            reinsertion_batch_ratio: reinserted(boxes.len()),
            ..BvhBuildParams::medium_build()
        };
        let mut leaves = Leaves { numbers: Vec::with_capacity(boxes.len()), starts: vec![0] };
        let binary = build_bvh2(&boxes, parameters, &mut Duration::default());
        drop(boxes);
        let costs = Costs::new(&binary);
        let mut nodes = vec![Node::EMPTY];
        let mut children = Vec::with_capacity(WIDTH);
        // Depth first, so that what lies together in space lies together in memory.
        let mut open = vec![(0usize, 0u32)];
        while let Some((index, root)) = open.pop() {
            children.clear();
            costs.children(root, &mut children);
            let inner = children.iter().filter(|&&child| !costs.is_leaf(child)).count();
            let first = nodes.len();
            nodes.resize(first + inner, Node::EMPTY);
            let mut next = first;
            for (i, &child) in children.iter().enumerate() {
                let reference = if costs.is_leaf(child) {
                    let first = leaves.numbers.len();
                    gather(&binary, child, &mut leaves.numbers);
                    let reference = match place {
                        Place::Leaf => leaves.len(),
                        Place::First => first,
                    };
                    leaves.starts.push(leaves.numbers.len() as u32);
                    Child::leaf(reference, leaves.numbers.len() - first)
                } else {
                    open.push((next, child));
                    next += 1;
                    Child::node(next - 1)
                };
                nodes[index].set(i, binary.nodes[child as usize].aabb(), reference);
            }
        }
        (Self { nodes: Pages::copy_of(&nodes) }, leaves)
    }
}

/// What each subtree of the binary tree costs at least when it is made of wide nodes and leaves, by the number of children
/// of a wide node that it may take up (Ylitie, Karras and Laine 2017, section 3.1).
struct Costs<'a> {
    binary: &'a Bvh2,
    /// Of each binary node, for 1 ..= 7 children.
    costs: Vec<[f32; WIDTH - 1]>,
}

impl<'a> Costs<'a> {
    fn new(binary: &'a Bvh2) -> Self {
        let mut parents_first = Vec::with_capacity(binary.nodes.len());
        let mut stack = vec![0u32];
        while let Some(index) = stack.pop() {
            parents_first.push(index);
            let node = &binary.nodes[index as usize];
            if !node.is_leaf() {
                stack.extend([node.first_index, node.first_index + 1]);
            }
        }
        let mut costs = Self { binary, costs: vec![[0.0; WIDTH - 1]; binary.nodes.len()] };
        let mut counts = vec![0u8; binary.nodes.len()];
        for &index in parents_first.iter().rev() {
            let node = &binary.nodes[index as usize];
            let area = node.aabb().half_area();
            let (left, right) = (node.first_index as usize, node.first_index as usize + 1);
            let count = if node.is_leaf() {
                node.prim_count as usize
            } else {
                usize::from(counts[left]) + usize::from(counts[right])
            };
            // More than a leaf holds is all that matters of greater numbers.
            counts[index as usize] = count.min(TOGETHER + 1) as u8;
            let as_leaf = if count <= TOGETHER { area * LEAF_COST } else { f32::INFINITY };
            let of = &mut [as_leaf; WIDTH - 1];
            if !node.is_leaf() {
                of[0] = as_leaf.min(area + costs.shared_out(index, WIDTH).0);
                for most in 2..WIDTH {
                    of[most - 1] = of[most - 2].min(costs.shared_out(index, most).0);
                }
            }
            costs.costs[index as usize] = *of;
        }
        costs
    }

    /// The least cost of the two children of an inner binary node if both together take up `most` children of a wide node,
    /// and how many of these the first gets.
    fn shared_out(&self, index: u32, most: usize) -> (f32, usize) {
        let first = self.binary.nodes[index as usize].first_index as usize;
        let (left, right) = (&self.costs[first], &self.costs[first + 1]);
        let mut best = (f32::INFINITY, 1);
        for k in 1..most {
            let cost = left[k - 1] + right[most - k - 1];
            if cost < best.0 {
                best = (cost, k);
            }
        }
        best
    }

    /// Whether a child of a wide node is a leaf.
    fn is_leaf(&self, index: u32) -> bool {
        let node = &self.binary.nodes[index as usize];
        node.is_leaf() || self.costs[index as usize][0] < node.aabb().half_area() + self.shared_out(index, WIDTH).0
    }

    /// The children of the wide node that stands for a binary one; itself, if it is a leaf.
    fn children(&self, root: u32, children: &mut Vec<u32>) {
        if self.is_leaf(root) {
            children.push(root);
            return;
        }
        let mut stack = vec![(root, WIDTH)];
        while let Some((index, mut most)) = stack.pop() {
            let mut split = if most == WIDTH { Some(self.shared_out(index, most).1) } else { None };
            let costs = &self.costs[index as usize];
            while most > 1 && split.is_none() {
                if costs[most - 1] < costs[most - 2] {
                    split = Some(self.shared_out(index, most).1);
                } else {
                    most -= 1;
                }
            }
            match split {
                Some(k) => {
                    let first = self.binary.nodes[index as usize].first_index;
                    stack.extend([(first + 1, most - k), (first, k)]);
                }
                None => children.push(index),
            }
        }
    }
}

/// The numbers of the boxes below a node.
fn gather(binary: &Bvh2, root: u32, numbers: &mut Vec<u32>) {
    let mut stack = vec![root];
    while let Some(index) = stack.pop() {
        let node = &binary.nodes[index as usize];
        if node.is_leaf() {
            let first = node.first_index as usize;
            numbers.extend_from_slice(&binary.primitive_indices[first..first + node.prim_count as usize]);
        } else {
            stack.extend([node.first_index + 1, node.first_index]);
        }
    }
}
