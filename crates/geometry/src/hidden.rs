//! Triangles that can never be hit: those without area, and those in the very place of an earlier one, which is hit
//! instead. Whatever chooses points on triangles must know them, or light sampling and hits would not agree.
//!
//! Thousands in one place would also make the search tree as deep as they are many.

use rayon::prelude::*;

use crate::{
    GeometryError, Mesh,
    placement::Placement,
    places::{PlaceHash, in_one_place, place_hash, same_places},
    triangle::{Triangle, is_degenerate},
};

/// Which instance, and which of its triangles.
type Owner = (u32, u32);

/// What is left out of the search trees. All lists ascend.
///
/// A mesh with several instances is looked through in its own space, before its tree is built. One that occurs once is not:
/// what is in one place in its space is in one place in the world, so [`Hidden::bake`] finds it there, once for both.
#[derive(Debug, Default)]
pub(crate) struct Hidden {
    /// Of each mesh, in any instance.
    of_meshes: Vec<Vec<u32>>,
    /// Whole instances, in the very place of an earlier instance of the same mesh.
    instances: Vec<u32>,
    /// Single triangles of instances.
    triangles: Vec<Owner>,
}

/// Where a triangle is seen to be hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Space {
    Mesh,
    World,
}

impl Hidden {
    /// What is known before the trees are built.
    pub(crate) fn new(meshes: &[Mesh], placements: &[Placement]) -> Self {
        Self::hashed_by(place_hash, meshes, placements)
    }

    fn hashed_by(hash: impl PlaceHash, meshes: &[Mesh], placements: &[Placement]) -> Self {
        let mut hidden = Self { instances: repeated_instances(placements), ..Self::default() };
        let uses = hidden.uses(meshes.len(), placements);
        let of_mesh = |(mesh, uses): (&Mesh, &u32)| if *uses == 1 { Vec::new() } else { hidden_in(mesh, hash) };
        hidden.of_meshes = meshes.par_iter().zip(&uses).map(of_mesh).collect();
        hidden
    }

    /// How many instances of each mesh are not hidden.
    pub(crate) fn uses(&self, meshes: usize, placements: &[Placement]) -> Vec<u32> {
        let mut uses = vec![0; meshes];
        for (_, placement) in (0u32..).zip(placements).filter(|(instance, _)| !self.has_instance(*instance)) {
            uses[placement.mesh as usize] += 1;
        }
        uses
    }

    /// The triangles of a mesh with several instances that are not hidden in all of them, in ascending order.
    pub(crate) fn solid(&self, mesh: usize, triangles: usize) -> Vec<u32> {
        without(0..triangles as u32, &self.of_meshes[mesh]).collect()
    }

    /// Looks through the triangles of some instances in the world, in the order of the list. It must have the instances of
    /// all meshes that occur once, and may have others. Returns the triangles that are not hidden, in the same order.
    pub(crate) fn bake(
        &mut self,
        meshes: &[Mesh],
        placements: &[Placement],
        instances: &[u32],
    ) -> Result<Vec<Owner>, GeometryError> {
        self.bake_hashed_by(place_hash, meshes, placements, instances)
    }

    fn bake_hashed_by(
        &mut self,
        hash: impl PlaceHash,
        meshes: &[Mesh],
        placements: &[Placement],
        instances: &[u32],
    ) -> Result<Vec<Owner>, GeometryError> {
        let owners = self.owners(meshes, placements, instances)?;
        let count = owners.len() as u32;
        let mesh_of = |instance: u32| placements[instance as usize].mesh as usize;
        let in_mesh = |i: u32| {
            let (instance, number) = owners[i as usize];
            meshes[mesh_of(instance)].corners(number)
        };
        let in_world = |i: u32| {
            let placement = &placements[owners[i as usize].0 as usize];
            in_mesh(i).map(|p| placement.point(p))
        };
        let without_area = |i: u32| {
            if is_degenerate(&in_mesh(i)) {
                Some(Space::Mesh)
            } else {
                // The transform may have flattened it.
                is_degenerate(&in_world(i)).then_some(Space::World)
            }
        };

        let mut found: Vec<(u32, Space)> =
            (0..count).into_par_iter().filter_map(|i| Some((i, without_area(i)?))).collect();
        let in_place_of_another = |same: &[u32], found: &mut Vec<(u32, Space)>| {
            // What the transform brought together is apart in the mesh: only some are hidden there.
            let mut of_mesh: Vec<u32> = same
                .chunk_by(|a, b| owners[*a as usize].0 == owners[*b as usize].0)
                .flat_map(|of_instance| later_of(of_instance, in_mesh, hash))
                .collect();
            of_mesh.sort_unstable();
            let solid = without(same.iter().copied(), &of_mesh).filter(|i| without_area(*i).is_none());
            found.extend(solid.skip(1).map(|i| (i, Space::World)));
            found.extend(of_mesh.into_iter().map(|i| (i, Space::Mesh)));
        };
        found.append(&mut same_places(count, in_world, hash, in_place_of_another));
        // One that is hidden in both spaces counts in the mesh's.
        found.par_sort_unstable();
        found.dedup_by_key(|(i, _)| *i);

        for &(i, space) in &found {
            let (instance, number) = owners[i as usize];
            match space {
                Space::Mesh => self.of_meshes[mesh_of(instance)].push(number),
                Space::World => self.triangles.push((instance, number)),
            }
        }
        let found: Vec<u32> = found.into_iter().map(|(i, _)| i).collect();
        Ok(without(0..count, &found).map(|i| owners[i as usize]).collect())
    }

    /// The triangles of instances that are not hidden in their meshes, as far as that is known.
    fn owners(
        &self,
        meshes: &[Mesh],
        placements: &[Placement],
        instances: &[u32],
    ) -> Result<Vec<Owner>, GeometryError> {
        let mesh_of = |instance: u32| placements[instance as usize].mesh as usize;
        let left = |mesh: usize| meshes[mesh].triangles.len() - self.of_meshes[mesh].len();
        let count = instances.iter().map(|instance| left(mesh_of(*instance))).sum();
        if count > u32::MAX as usize {
            return Err(GeometryError::TooMany { what: "triangles", count });
        }
        let mut owners = Vec::with_capacity(count);
        for &instance in instances {
            let mesh = mesh_of(instance);
            let solid = without(0..meshes[mesh].triangles.len() as u32, &self.of_meshes[mesh]);
            owners.extend(solid.map(|number| (instance, number)));
        }
        Ok(owners)
    }

    pub(crate) fn has_instance(&self, instance: u32) -> bool {
        self.instances.binary_search(&instance).is_ok()
    }

    pub(crate) fn has(&self, mesh: u32, instance: u32, triangle: u32) -> bool {
        self.has_instance(instance)
            || self.triangles.binary_search(&(instance, triangle)).is_ok()
            || self.of_meshes[mesh as usize].binary_search(&triangle).is_ok()
    }

    /// How many triangles of the meshes are left out of all instances.
    pub(crate) fn dropped_of_meshes(&self) -> usize {
        self.of_meshes.iter().map(Vec::len).sum()
    }
}

/// The instances in the very place of an earlier one of the same mesh, in ascending order.
fn repeated_instances(placements: &[Placement]) -> Vec<u32> {
    let place = |instance: &u32| {
        let Placement { mesh, transform, .. } = &placements[*instance as usize];
        // An addition of 0 makes one zero of the two.
        (*mesh, transform.to_cols_array().map(|x| (x + 0.0).to_bits()))
    };
    let mut order: Vec<u32> = (0..placements.len() as u32).collect();
    order.par_sort_unstable_by_key(|instance| (place(instance), *instance));
    let same = order.chunk_by(|a, b| place(a) == place(b));
    let mut repeated: Vec<u32> = same.flat_map(|same| same[1..].iter().copied()).collect();
    repeated.sort_unstable();
    repeated
}

/// What can not be hit in any instance of a mesh, in ascending order.
fn hidden_in(mesh: &Mesh, hash: impl PlaceHash) -> Vec<u32> {
    let corners = |number: u32| mesh.corners(number);
    let count = mesh.triangles.len() as u32;
    let without_area = (0..count).into_par_iter().filter(|number| is_degenerate(&corners(*number)));
    let mut hidden: Vec<u32> = without_area.collect();
    hidden.append(&mut same_places(count, corners, hash, |same, found| found.extend(later(same, corners))));
    hidden.par_sort_unstable();
    hidden
}

/// Of triangles in one place, in ascending order, those with an area after the first of them.
fn later<'a>(same: &'a [u32], triangle: impl Fn(u32) -> Triangle + 'a) -> impl Iterator<Item = u32> + 'a {
    same.iter().copied().filter(move |i| !is_degenerate(&triangle(*i))).skip(1)
}

/// Of triangles in ascending order, those with an area in the place of an earlier one that has an area.
fn later_of(some: &[u32], triangle: impl Fn(u32) -> Triangle + Sync, hash: impl PlaceHash) -> Vec<u32> {
    // Mostly they are few and in one place, which is quickly seen.
    if in_one_place(some.iter().map(|i| triangle(*i))) {
        return later(some, triangle).collect();
    }
    same_places(
        some.len() as u32,
        |i| triangle(some[i as usize]),
        hash,
        |same, found| {
            let same: Vec<u32> = same.iter().map(|i| some[*i as usize]).collect();
            found.extend(later(&same, &triangle));
        },
    )
}

/// The ascending numbers that are not on an ascending list of some of them.
fn without(numbers: impl Iterator<Item = u32>, listed: &[u32]) -> impl Iterator<Item = u32> {
    let mut listed = listed.iter().copied().peekable();
    numbers.filter(move |number| listed.next_if_eq(number).is_none())
}

#[cfg(test)]
mod tests;
