//! The two levels of the search.
//!
//! Meshes with one instance are baked: their world-space triangles share one static tree. Meshes with several have a tree
//! of their own, and one more tree finds the instances. A world that has none of these never looks for them.

use std::fmt;

use glam::DVec3;
use rayon::prelude::*;

use crate::{
    GeometryError, Hit, Isa, Mesh, Ray,
    hidden::Hidden,
    placement::Placement,
    tree::{Block, Child, Cube, CubeMap, Owner, Pages, Place, Tree, TreeRay},
    triangle::{Crossing, Shear, Triangle},
};

/// The closest hit so far.
pub(crate) struct Nearest {
    crossing: Crossing,
    owner: Owner,
}

impl Nearest {
    pub(crate) const NONE: Self = Self { crossing: Crossing { t: f64::MAX, u: 0.0, v: 0.0 }, owner: [u32::MAX; 2] };

    /// Takes a crossing that is nearer than all before, or as near and owned by a lower number.
    #[inline(always)]
    fn take(&mut self, crossing: Crossing, owner: Owner) -> Option<f64> {
        if crossing.t < self.crossing.t || owner < self.owner {
            *self = Self { crossing, owner };
            Some(crossing.t)
        } else {
            None
        }
    }

    pub(crate) fn hit(&self) -> Option<Hit> {
        let Crossing { t, u, v } = self.crossing;
        let [instance, triangle] = self.owner;
        (t < f64::MAX).then_some(Hit { instance, triangle, u, v, t })
    }
}

/// Triangles with the tree over them.
struct TriangleTree {
    cube: Cube,
    tree: Tree,
    /// In the order of the tree.
    blocks: Pages<Block>,
    count: usize,
}

impl TriangleTree {
    /// Builds the tree over the triangles `0 .. count`, of which there is at least one.
    fn build(
        count: usize,
        owner: impl Fn(usize) -> Owner + Sync,
        triangle: impl Fn(usize) -> Triangle + Sync,
    ) -> Result<Self, GeometryError> {
        check_count("triangles", count)?;
        let box_of = |i: usize| {
            let [a, b, c] = triangle(i);
            (a.min(b).min(c), a.max(b).max(c))
        };
        let (min, max) = (0..count)
            .into_par_iter()
            .map(box_of)
            .reduce(|| (DVec3::INFINITY, DVec3::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
        let cube = Cube::around(min, max);
        let boxes = (0..count).into_par_iter().map(|i| {
            let (min, max) = box_of(i);
            cube.padded_box(min, max)
        });
        let (tree, leaves) = Tree::build(boxes.collect(), Place::Leaf);
        let mut blocks = Pages::<Block>::zeroed(leaves.len());
        blocks.par_iter_mut().enumerate().for_each(|(leaf, block)| {
            for (lane, &number) in leaves.of(leaf).iter().enumerate() {
                block.set(lane, &triangle(number as usize), owner(number as usize));
            }
        });
        Ok(Self { cube, tree, blocks, count })
    }
}

/// Whether a tree can number its primitives.
fn check_count(what: &'static str, count: usize) -> Result<(), GeometryError> {
    if count > Child::LIMIT { Err(GeometryError::TooMany { what, count }) } else { Ok(()) }
}

/// The meshes with one instance, in the world's space.
pub(crate) struct Baked(TriangleTree);

impl Baked {
    /// Bakes the listed instances, in ascending order; `None` if they have no triangles.
    fn build(
        meshes: &[Mesh],
        placements: &[Placement],
        instances: &[u32],
        hidden: &mut Hidden,
    ) -> Result<Option<Self>, GeometryError> {
        let owners = hidden.bake(meshes, placements, instances)?;
        let corners_of = |(instance, number): (u32, u32)| {
            let placement = &placements[instance as usize];
            meshes[placement.mesh as usize].corners(number).map(|p| placement.point(p))
        };
        if owners.is_empty() {
            return Ok(None);
        }
        let triangles = TriangleTree::build(owners.len(), |i| owners[i].into(), |i| corners_of(owners[i]))?;
        Ok(Some(Self(triangles)))
    }

    #[inline]
    pub(crate) fn closest(&self, isa: Isa, shear: &Shear, ray: &Ray, nearest: &mut Nearest) {
        let TriangleTree { cube, tree, blocks, .. } = &self.0;
        let Some(tree_ray) = TreeRay::new(cube.point(ray.origin), cube.vector(ray.direction), f64::MAX) else { return };
        let take = |crossing: Crossing, owner: Owner| nearest.take(crossing, owner);
        isa.closest(&tree.nodes, &tree_ray, shear, f64::MAX, blocks, |block| block, take);
    }

    #[inline]
    pub(crate) fn any(&self, isa: Isa, shear: &Shear, ray: &Ray, t_max: f64) -> bool {
        let TriangleTree { cube, tree, blocks, .. } = &self.0;
        TreeRay::new(cube.point(ray.origin), cube.vector(ray.direction), t_max)
            .is_some_and(|tree_ray| isa.any(&tree.nodes, &tree_ray, shear, t_max, blocks, |block| block))
    }
}

/// A mesh with several instances, in its own space.
struct Prototype {
    min: DVec3,
    max: DVec3,
    triangles: TriangleTree,
}

impl Prototype {
    /// `None` if the mesh has no triangles.
    fn build(mesh: &Mesh, solid: &[u32]) -> Result<Option<Self>, GeometryError> {
        if solid.is_empty() {
            return Ok(None);
        }
        let (min, max) = bounds(solid.iter().flat_map(|&number| mesh.corners(number)));
        // Which instance is known only in a search.
        let triangles = TriangleTree::build(solid.len(), |i| [0, solid[i]], |i| mesh.corners(solid[i]))?;
        Ok(Some(Self { min, max, triangles }))
    }

    /// The corners of its box in the world, as a box. It holds the world-space vertices up to rounding, which the tree's
    /// padding covers.
    fn world_box(&self, placement: &Placement) -> (DVec3, DVec3) {
        bounds((0..8).map(|corner| {
            let pick = |axis: usize| if corner >> axis & 1 == 0 { self.min[axis] } else { self.max[axis] };
            placement.point(DVec3::new(pick(0), pick(1), pick(2)))
        }))
    }
}

/// One instance of a [`Prototype`].
struct Member {
    to_cube: CubeMap,
    prototype: usize,
    instance: u32,
}

/// All meshes with several instances.
pub(crate) struct Shared {
    cube: Cube,
    tree: Tree,
    /// In the order of the tree.
    members: Vec<Member>,
    prototypes: Vec<Prototype>,
}

impl Shared {
    #[inline]
    pub(crate) fn closest(&self, isa: Isa, placements: &[Placement], shear: &Shear, ray: &Ray, nearest: &mut Nearest) {
        let t_max = nearest.crossing.t;
        let Some(tree_ray) = TreeRay::new(self.cube.point(ray.origin), self.cube.vector(ray.direction), t_max) else {
            return;
        };
        isa.members(&self.tree.nodes, &tree_ray, |i, far| {
            let member = &self.members[i];
            let (origin, direction) = (member.to_cube.point(ray.origin), member.to_cube.vector(ray.direction));
            let t_max = nearest.crossing.t;
            let Some(member_ray) = TreeRay::new(origin, direction, t_max) else { return false };
            let placement = &placements[member.instance as usize];
            let TriangleTree { tree, blocks, .. } = &self.prototypes[member.prototype].triangles;
            let take = |crossing, [_, number]: Owner| {
                let t = nearest.take(crossing, [member.instance, number])?;
                *far = tree_ray.above(t);
                Some(t)
            };
            isa.closest(&tree.nodes, &member_ray, shear, t_max, blocks, |block| block.placed(placement), take);
            false
        });
    }

    #[inline]
    pub(crate) fn any(&self, isa: Isa, placements: &[Placement], shear: &Shear, ray: &Ray, t_max: f64) -> bool {
        let Some(tree_ray) = TreeRay::new(self.cube.point(ray.origin), self.cube.vector(ray.direction), t_max) else {
            return false;
        };
        isa.members(&self.tree.nodes, &tree_ray, |i, _| {
            let member = &self.members[i];
            let (origin, direction) = (member.to_cube.point(ray.origin), member.to_cube.vector(ray.direction));
            let placement = &placements[member.instance as usize];
            let TriangleTree { tree, blocks, .. } = &self.prototypes[member.prototype].triangles;
            TreeRay::new(origin, direction, t_max).is_some_and(|member_ray| {
                isa.any(&tree.nodes, &member_ray, shear, t_max, blocks, |block| block.placed(placement))
            })
        })
    }
}

/// Builds both levels.
pub(crate) fn split(
    meshes: &[Mesh],
    placements: &[Placement],
    world_bounds: (DVec3, DVec3),
    hidden: &mut Hidden,
) -> Result<(Option<Baked>, Option<Shared>), GeometryError> {
    let uses = hidden.uses(meshes.len(), placements);
    let prototypes: Vec<Option<Prototype>> = meshes
        .par_iter()
        .enumerate()
        .map(|(index, mesh)| match uses[index] {
            0 | 1 => Ok(None),
            _ => Prototype::build(mesh, &hidden.solid(index, mesh.triangles.len())),
        })
        .collect::<Result<_, _>>()?;

    let (min, max) = world_bounds;
    let reach = min.abs().max(max.abs()).max_element() + (max - min).length();
    let mut baked = Vec::new();
    let mut members = Vec::new();
    let mut boxes = Vec::new();
    for (instance, placement) in (0u32..).zip(placements) {
        if hidden.has_instance(instance) {
            continue;
        }
        let mesh = placement.mesh as usize;
        let to_cube = prototypes[mesh].as_ref().map(|prototype| {
            CubeMap::new(&prototype.triangles.cube, &placement.transform, reach).map(|map| (prototype, map))
        });
        match to_cube {
            Some(Some((prototype, to_cube))) => {
                boxes.push(prototype.world_box(placement));
                members.push(Member { to_cube, prototype: mesh, instance });
            }
            // Its transform cannot be inverted well enough, or it is its mesh's only instance.
            Some(None) | None => baked.push(instance),
        }
    }
    let baked = Baked::build(meshes, placements, &baked, hidden)?;
    if members.is_empty() {
        return Ok((baked, None));
    }

    let (min, max) = bounds(boxes.iter().flat_map(|(min, max)| [*min, *max]));
    let cube = Cube::around(min, max);
    check_count("instances", members.len())?;
    let boxes = boxes.iter().map(|(min, max)| cube.padded_box(*min, *max)).collect();
    let (tree, leaves) = Tree::build(boxes, Place::First);
    // Number the prototypes that are there.
    let mut numbers = vec![0; prototypes.len()];
    let mut kept = Vec::new();
    for (mesh, prototype) in prototypes.into_iter().enumerate() {
        if let Some(prototype) = prototype {
            numbers[mesh] = kept.len();
            kept.push(prototype);
        }
    }
    let members = leaves
        .all()
        .iter()
        .map(|&i| {
            let Member { to_cube, prototype, instance } = members[i as usize];
            Member { to_cube, prototype: numbers[prototype], instance }
        })
        .collect();
    Ok((baked, Some(Shared { cube, tree, members, prototypes: kept })))
}

fn bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)))
}

impl fmt::Debug for Baked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Baked").field("triangles", &self.0.count).finish_non_exhaustive()
    }
}

impl fmt::Debug for Shared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Shared")
            .field("instances", &self.members.len())
            .field("meshes", &self.prototypes.len())
            .finish_non_exhaustive()
    }
}
