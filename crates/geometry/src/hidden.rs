//! Triangles that can never be hit: those without area, and those in the very place of an earlier one, which is hit
//! instead. Whatever chooses points on triangles must know them, or light sampling and hits would not agree.
//!
//! Thousands in one place would also make the search tree as deep as they are many.

use std::collections::HashSet;

use glam::DVec3;

use crate::triangle::{Triangle, is_degenerate};
use crate::{Mesh, placement::Placement};

/// Places that triangles were seen in, whichever corner comes first and whichever way they face.
#[derive(Default)]
pub(crate) struct Places(HashSet<[[u64; 3]; 3]>);

impl Places {
    /// Whether the triangle has an area and no earlier one was in its place.
    pub(crate) fn take(&mut self, triangle: &Triangle) -> bool {
        // An addition of 0 makes one zero of the two.
        let mut place = triangle.map(|p| (p + DVec3::ZERO).to_array().map(f64::to_bits));
        place.sort_unstable();
        !is_degenerate(triangle) && self.0.insert(place)
    }
}

/// What is left out of the search trees.
#[derive(Debug, Default)]
pub(crate) struct Hidden {
    /// Of each mesh, in any instance, in ascending order.
    of_meshes: Vec<Vec<u32>>,
    /// Whole instances, in the very place of an earlier instance of the same mesh.
    instances: HashSet<u32>,
    /// Single triangles of instances.
    triangles: HashSet<(u32, u32)>,
}

impl Hidden {
    /// What is known before the trees are built, with the triangles of each mesh that are left.
    pub(crate) fn new(meshes: &[Mesh], placements: &[Placement]) -> (Self, Vec<Vec<u32>>) {
        let mut hidden = Self::default();
        let mut solid = Vec::with_capacity(meshes.len());
        for mesh in meshes {
            let mut places = Places(HashSet::with_capacity(mesh.triangles.len()));
            let (kept, dropped) = (0u32..)
                .zip(&mesh.triangles)
                .partition(|(_, t)| places.take(&t.map(|vertex| mesh.positions[vertex as usize])));
            let numbers = |triangles: Vec<(u32, &[u32; 3])>| triangles.into_iter().map(|(number, _)| number).collect();
            hidden.of_meshes.push(numbers(dropped));
            solid.push(numbers(kept));
        }
        let mut seen = HashSet::new();
        for (number, placement) in (0u32..).zip(placements) {
            if !seen.insert((placement.mesh, placement.transform.to_cols_array().map(|x| (x + 0.0).to_bits()))) {
                hidden.instances.insert(number);
            }
        }
        (hidden, solid)
    }

    pub(crate) fn hide(&mut self, instance: u32, triangle: u32) {
        self.triangles.insert((instance, triangle));
    }

    pub(crate) fn has_instance(&self, instance: u32) -> bool {
        self.instances.contains(&instance)
    }

    pub(crate) fn has(&self, mesh: u32, instance: u32, triangle: u32) -> bool {
        self.instances.contains(&instance)
            || self.triangles.contains(&(instance, triangle))
            || self.of_meshes[mesh as usize].binary_search(&triangle).is_ok()
    }

    /// How many triangles of the meshes are left out of all instances.
    pub(crate) fn dropped_of_meshes(&self) -> usize {
        self.of_meshes.iter().map(Vec::len).sum()
    }
}
