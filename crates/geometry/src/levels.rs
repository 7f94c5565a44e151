//! The two levels of the search.
//!
//! Meshes with one instance are baked: their world-space triangles share one static tree. Meshes with several have a tree
//! of their own, and one more tree finds the instances. A world that has none of these never looks for them.

use std::fmt;

use glam::DVec3;
use rayon::prelude::*;

use crate::{
    GeometryError, Hit, Mesh, Ray,
    bvh::{Cube, CubeMap, InstanceTree, TreeRay, TriangleTree},
    hidden::Hidden,
    placement::Placement,
    triangle::{Crossing, Shear, Triangle},
};

/// Which instance, and which of its triangles. The order breaks ties between hits at the same t, so that the answer does
/// not depend on the order of the search.
type Owner = (u32, u32);

/// The closest hit so far.
pub(crate) struct Nearest {
    crossing: Crossing,
    owner: Owner,
}

impl Nearest {
    pub(crate) const NONE: Self =
        Self { crossing: Crossing { t: f64::MAX, u: 0.0, v: 0.0 }, owner: (u32::MAX, u32::MAX) };

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
        let (instance, triangle) = self.owner;
        (t < f64::MAX).then_some(Hit { instance, triangle, u, v, t })
    }
}

/// The meshes with one instance, in the world's space.
pub(crate) struct Baked {
    cube: Cube,
    tree: TriangleTree,
    /// In the order of the tree.
    triangles: Vec<Triangle>,
    owners: Vec<Owner>,
}

impl Baked {
    /// Bakes the listed instances, in ascending order; `None` if they have no triangles.
    fn build(
        meshes: &[Mesh],
        placements: &[Placement],
        instances: &[u32],
        hidden: &mut Hidden,
    ) -> Result<Option<Self>, GeometryError> {
        let owners = hidden.bake(meshes, placements, instances)?;
        let corners = |&(instance, number): &Owner| {
            let placement = &placements[instance as usize];
            meshes[placement.mesh as usize].corners(number).map(|p| placement.point(p))
        };
        let triangles: Vec<Triangle> = owners.par_iter().map(corners).collect();
        if triangles.is_empty() {
            return Ok(None);
        }
        let (cube, tree, order) = tree_over(&triangles)?;
        let owners = order.iter().map(|&i| owners[i as usize]).collect();
        let triangles = order.iter().map(|&i| triangles[i as usize]).collect();
        Ok(Some(Self { cube, tree, triangles, owners }))
    }

    #[inline(always)]
    pub(crate) fn closest<const AXIS: usize>(&self, shear: &Shear<AXIS>, ray: &Ray, nearest: &mut Nearest) {
        let Some(tree_ray) = TreeRay::new(self.cube.point(ray.origin), self.cube.vector(ray.direction), f64::MAX)
        else {
            return;
        };
        self.tree.closest(&tree_ray, |i| {
            let crossing = shear.cross(&self.triangles[i], nearest.crossing.t)?;
            nearest.take(crossing, self.owners[i])
        });
    }

    #[inline(always)]
    pub(crate) fn any<const AXIS: usize>(&self, shear: &Shear<AXIS>, ray: &Ray, t_max: f64) -> bool {
        TreeRay::new(self.cube.point(ray.origin), self.cube.vector(ray.direction), t_max)
            .is_some_and(|tree_ray| self.tree.any(&tree_ray, |i| shear.cross(&self.triangles[i], t_max).is_some()))
    }
}

/// A mesh with several instances, in its own space.
struct Prototype {
    cube: Cube,
    min: DVec3,
    max: DVec3,
    tree: TriangleTree,
    /// In the order of the tree.
    triangles: Vec<Triangle>,
    numbers: Vec<u32>,
}

impl Prototype {
    /// `None` if the mesh has no triangles.
    fn build(mesh: &Mesh, solid: &[u32]) -> Result<Option<Self>, GeometryError> {
        if solid.is_empty() {
            return Ok(None);
        }
        let triangles: Vec<Triangle> = solid.iter().map(|&number| mesh.corners(number)).collect();
        let (min, max) = bounds(triangles.iter().flatten().copied());
        let (cube, tree, order) = tree_over(&triangles)?;
        let numbers = order.iter().map(|&i| solid[i as usize]).collect();
        let triangles = order.iter().map(|&i| triangles[i as usize]).collect();
        Ok(Some(Self { cube, min, max, tree, triangles, numbers }))
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
    tree: InstanceTree,
    /// In the order of the tree.
    members: Vec<Member>,
    prototypes: Vec<Prototype>,
}

impl Shared {
    #[inline(always)]
    pub(crate) fn closest<const AXIS: usize>(
        &self,
        placements: &[Placement],
        shear: &Shear<AXIS>,
        ray: &Ray,
        nearest: &mut Nearest,
    ) {
        let t_max = nearest.crossing.t;
        let Some(tree_ray) = TreeRay::new(self.cube.point(ray.origin), self.cube.vector(ray.direction), t_max) else {
            return;
        };
        self.tree.closest(&tree_ray, |i| {
            let member = &self.members[i];
            let (origin, direction) = (member.to_cube.point(ray.origin), member.to_cube.vector(ray.direction));
            let before = nearest.owner;
            let member_ray = TreeRay::new(origin, direction, nearest.crossing.t)?;
            let placement = &placements[member.instance as usize];
            let prototype = &self.prototypes[member.prototype];
            prototype.tree.closest(&member_ray, |i| {
                let triangle = prototype.triangles[i].map(|p| placement.point(p));
                let crossing = shear.cross(&triangle, nearest.crossing.t)?;
                nearest.take(crossing, (member.instance, prototype.numbers[i]))
            });
            (nearest.owner != before).then_some(nearest.crossing.t)
        });
    }

    #[inline(always)]
    pub(crate) fn any<const AXIS: usize>(
        &self,
        placements: &[Placement],
        shear: &Shear<AXIS>,
        ray: &Ray,
        t_max: f64,
    ) -> bool {
        let Some(tree_ray) = TreeRay::new(self.cube.point(ray.origin), self.cube.vector(ray.direction), t_max) else {
            return false;
        };
        self.tree.any(&tree_ray, |i| {
            let member = &self.members[i];
            let (origin, direction) = (member.to_cube.point(ray.origin), member.to_cube.vector(ray.direction));
            let placement = &placements[member.instance as usize];
            let prototype = &self.prototypes[member.prototype];
            TreeRay::new(origin, direction, t_max).is_some_and(|member_ray| {
                prototype.tree.any(&member_ray, |i| {
                    let triangle = prototype.triangles[i].map(|p| placement.point(p));
                    shear.cross(&triangle, t_max).is_some()
                })
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
        let to_cube = prototypes[mesh]
            .as_ref()
            .map(|prototype| CubeMap::new(&prototype.cube, &placement.transform, reach).map(|map| (prototype, map)));
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
    let (tree, order) = InstanceTree::build(&cube, &boxes);
    // Number the prototypes that are there.
    let mut numbers = vec![0; prototypes.len()];
    let mut kept = Vec::new();
    for (mesh, prototype) in prototypes.into_iter().enumerate() {
        if let Some(prototype) = prototype {
            numbers[mesh] = kept.len();
            kept.push(prototype);
        }
    }
    let members = order
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

fn tree_over(triangles: &[Triangle]) -> Result<(Cube, TriangleTree, Vec<u32>), GeometryError> {
    if triangles.len() > u32::MAX as usize {
        return Err(GeometryError::TooMany { what: "triangles", count: triangles.len() });
    }
    let boxes: Vec<_> = triangles.iter().map(|t| (t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2]))).collect();
    let (min, max) = bounds(boxes.iter().flat_map(|(min, max)| [*min, *max]));
    let cube = Cube::around(min, max);
    let (tree, order) = TriangleTree::build(&cube, &boxes)?;
    Ok((cube, tree, order))
}

impl fmt::Debug for Baked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Baked").field("triangles", &self.triangles.len()).finish_non_exhaustive()
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
