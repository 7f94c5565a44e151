//! From boxes to a tree: obvhs builds a binary one (PLOC, Meister and Bittner 2018, with reinsertion), which is made wide here
//! by opening the largest child until a node is full (Wald, Benthin and Boulos 2008).

use std::time::Duration;

use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2},
};

use super::node::{Child, LEAF, Node, WIDTH};

/// Nodes over primitives.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    pub(crate) nodes: Vec<Node>,
}

/// A leaf takes this many primitives wherever it can: they are tested together.
const TOGETHER: usize = 4;

impl Tree {
    /// Builds the tree over padded boxes; there is at least one. For each leaf, `place` is given the numbers of its boxes and
    /// returns the place of the first in the caller's own order of primitives.
    pub(crate) fn build(boxes: Vec<Aabb>, mut place: impl FnMut(&[u32]) -> usize) -> Self {
        let parameters = BvhBuildParams { max_prims_per_leaf: TOGETHER as u32, ..BvhBuildParams::medium_build() };
        let binary = build_bvh2(&boxes, parameters, &mut Duration::default());
        drop(boxes);
        let counts = counts(&binary);
        let mut nodes = Vec::with_capacity(binary.nodes.len() / 8 + 1);
        nodes.push(Node::EMPTY);
        let mut numbers = Vec::with_capacity(LEAF);
        // Depth first, so that what lies together in space lies together in memory.
        let mut open = vec![(0usize, 0u32)];
        while let Some((index, root)) = open.pop() {
            let children = children(&binary, &counts, root);
            let inner = children.iter().filter(|&&child| !is_leaf(&binary, &counts, child)).count();
            let first = nodes.len();
            nodes.resize(first + inner, Node::EMPTY);
            let mut next = first;
            for (i, &child) in children.iter().enumerate() {
                let reference = if is_leaf(&binary, &counts, child) {
                    numbers.clear();
                    gather(&binary, child, &mut numbers);
                    Child::leaf(place(&numbers), numbers.len())
                } else {
                    open.push((next, child));
                    next += 1;
                    Child::node(next - 1)
                };
                nodes[index].set(i, binary.nodes[child as usize].aabb(), reference);
            }
        }
        nodes.shrink_to_fit();
        Self { nodes }
    }
}

/// How many primitives lie below each node.
fn counts(binary: &Bvh2) -> Vec<u32> {
    let mut counts: Vec<u32> = binary.nodes.iter().map(|node| node.prim_count).collect();
    // Children first, by a stack of its own: the tree may be as deep as it has leaves.
    let mut stack = vec![(0u32, false)];
    while let Some((index, children_known)) = stack.pop() {
        let node = &binary.nodes[index as usize];
        if node.is_leaf() {
            continue;
        }
        let (left, right) = (node.first_index, node.first_index + 1);
        if children_known {
            counts[index as usize] = counts[left as usize] + counts[right as usize];
        } else {
            stack.extend([(index, true), (left, false), (right, false)]);
        }
    }
    counts
}

fn is_leaf(binary: &Bvh2, counts: &[u32], index: u32) -> bool {
    binary.nodes[index as usize].is_leaf() || counts[index as usize] as usize <= TOGETHER
}

/// The children of the wide node that stands for a binary one; itself, if it is a leaf.
fn children(binary: &Bvh2, counts: &[u32], root: u32) -> Vec<u32> {
    let mut children = vec![root];
    let area = |index: u32| binary.nodes[index as usize].aabb().half_area();
    while children.len() < WIDTH {
        let largest = (0..children.len())
            .filter(|&i| !is_leaf(binary, counts, children[i]))
            .max_by(|&a, &b| area(children[a]).total_cmp(&area(children[b])));
        let Some(largest) = largest else { break };
        let first = binary.nodes[children[largest] as usize].first_index;
        children[largest] = first;
        children.push(first + 1);
    }
    children
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
