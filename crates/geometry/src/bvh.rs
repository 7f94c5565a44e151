//! The search trees: the only file that knows `f32` and obvhs.
//!
//! A tree lives in a cube [-1, 1]³ of its own, so its tolerances are the same for every unit and offset. Its answers only
//! choose which triangles are tested; what is hit, and where, is decided in `f64` by the caller's closure.

use std::time::Duration;

use glam::{DAffine3, DMat3, DVec3, Vec3A};
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2},
    cwbvh::{CwBvh, builder::build_cwbvh},
    ray::{Ray, RayHit},
};

use crate::{
    GeometryError,
    epsilon::{MAX_TRANSFORM_ERROR, TREE_DIRECTION, TREE_MIN_COMPONENT, TREE_PADDING, f32_above},
};

/// Levels of a CWBVH that a traversal can follow (the fixed stack of obvhs).
const MAX_DEPTH: usize = 32;

/// The map from the space of the primitives to the cube [-1, 1]³ of the tree: the same scale along all axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cube {
    center: DVec3,
    scale: f64,
}

impl Cube {
    /// The cube around a box.
    pub(crate) fn around(min: DVec3, max: DVec3) -> Self {
        let half = 0.5 * (max - min).max_element();
        Self { center: 0.5 * (min + max), scale: if half > 0.0 { 1.0 / half } else { 1.0 } }
    }

    #[inline]
    pub(crate) fn point(&self, p: DVec3) -> DVec3 {
        (p - self.center) * self.scale
    }

    #[inline]
    pub(crate) fn vector(&self, v: DVec3) -> DVec3 {
        v * self.scale
    }

    /// The padded `f32` box of points of the cube's outer space.
    fn padded_box(&self, min: DVec3, max: DVec3) -> Aabb {
        let padding = DVec3::splat(TREE_PADDING);
        Aabb::new((self.point(min) - padding).as_vec3a(), (self.point(max) + padding).as_vec3a())
    }
}

/// The map from the world to the cube of an instanced mesh's tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CubeMap {
    /// The cube's centre, in the world.
    center: DVec3,
    linear: DMat3,
}

impl CubeMap {
    /// The map for a mesh whose own cube is `cube`; `None` if a ray from within `reach` of the origin and the mesh
    /// could be off by more than the padding forgives.
    pub(crate) fn new(cube: &Cube, transform: &DAffine3, reach: f64) -> Option<Self> {
        let norm = |m: &DMat3| (m.x_axis.abs() + m.y_axis.abs() + m.z_axis.abs()).max_element();
        let inverse = transform.matrix3.try_inverse()?;
        let linear = inverse * cube.scale;
        let condition = norm(&transform.matrix3) * norm(&inverse);
        let error = f64::EPSILON * condition * norm(&linear) * reach;
        (error < MAX_TRANSFORM_ERROR).then(|| Self { center: transform.transform_point3(cube.center), linear })
    }

    #[inline]
    pub(crate) fn point(&self, p: DVec3) -> DVec3 {
        self.linear * (p - self.center)
    }

    #[inline]
    pub(crate) fn vector(&self, v: DVec3) -> DVec3 {
        self.linear * v
    }
}

/// A ray in a tree's cube, in `f32`, with the map from its parameter to the caller's.
pub(crate) struct TreeRay {
    ray: Ray,
    /// The caller's t at the `f32` origin.
    entry: f64,
    /// `f32` parameter per caller's t.
    scale: f64,
}

impl TreeRay {
    /// The part 0 <= t <= `t_max` of a ray given in the cube's coordinates; `None` if it misses the cube.
    #[inline]
    pub(crate) fn new(mut origin: DVec3, direction: DVec3, t_max: f64) -> Option<Self> {
        let largest = direction.abs().max_element();
        // A zero direction and NaN hit nothing.
        if !(largest > 0.0 && largest < f64::INFINITY) {
            return None;
        }
        let mut entry = 0.0;
        if origin.abs().max_element() > 1.0 {
            // Rounding a far origin to f32 would undo the padding: start where the ray enters the cube.
            entry = enter_cube(origin, direction, t_max)?;
            origin += direction * entry;
        }
        let scale = largest / TREE_DIRECTION;
        let d = direction / scale;
        let least = DVec3::splat(TREE_MIN_COMPONENT * TREE_DIRECTION);
        let d = d.abs().max(least).copysign(direction).as_vec3a();
        Some(Self {
            ray: Ray {
                origin: origin.as_vec3a(),
                direction: d,
                inv_direction: Vec3A::ONE / d,
                tmin: 0.0,
                tmax: f32_above((t_max - entry) * scale),
            },
            entry,
            scale,
        })
    }

    #[inline]
    fn above(&self, t: f64) -> f32 {
        f32_above((t - self.entry) * self.scale)
    }
}

/// Where a ray that starts outside enters the slightly enlarged cube.
#[cold]
fn enter_cube(origin: DVec3, direction: DVec3, t_max: f64) -> Option<f64> {
    let edge = DVec3::splat(1.0 + 2.0 * TREE_PADDING);
    let (mut near, mut far) = (0f64, t_max);
    for axis in 0..3 {
        let (o, d) = (origin[axis], direction[axis]);
        if d == 0.0 {
            if o.abs() > edge[axis] {
                return None;
            }
        } else {
            let (a, b) = ((-edge[axis] - o) / d, (edge[axis] - o) / d);
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
    }
    (near <= far).then_some(near)
}

/// A tree over triangles.
pub(crate) struct TriangleTree(CwBvh);

impl TriangleTree {
    /// Builds the tree over boxes `(min, max)` and returns it with the order in which its primitives are numbered: number
    /// `i` of the tree is box `order[i]`. There is at least one box.
    pub(crate) fn build(cube: &Cube, boxes: &[(DVec3, DVec3)]) -> Result<(Self, Vec<u32>), GeometryError> {
        let boxes: Vec<Aabb> = boxes.iter().map(|(min, max)| cube.padded_box(*min, *max)).collect();
        let mut tree = build_cwbvh(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        let depth = depth(&tree);
        if depth > MAX_DEPTH {
            return Err(GeometryError::TreeDepth { depth, limit: MAX_DEPTH });
        }
        let order = std::mem::take(&mut tree.primitive_indices);
        Ok((Self(tree), order))
    }

    /// Calls `test` for primitives that the ray may hit, near ones first. It returns the t of a hit nearer than
    /// all before, which cuts the ray there.
    #[inline(always)]
    pub(crate) fn closest(&self, ray: &TreeRay, mut test: impl FnMut(usize) -> Option<f64>) {
        self.0.ray_traverse(ray.ray, &mut RayHit::none(), |_, i| test(i).map_or(f32::INFINITY, |t| ray.above(t)));
    }

    /// Whether `test` is true for any primitive that the ray may hit.
    #[inline(always)]
    pub(crate) fn any(&self, ray: &TreeRay, mut test: impl FnMut(usize) -> bool) -> bool {
        !self.0.ray_traverse_miss(ray.ray, |_, i| if test(i) { f32::NEG_INFINITY } else { f32::INFINITY })
    }
}

/// Levels of the tree.
fn depth(tree: &CwBvh) -> usize {
    let mut deepest = 0;
    let mut stack = vec![(0usize, 1usize)];
    while let Some((index, level)) = stack.pop() {
        deepest = deepest.max(level);
        let node = &tree.nodes[index];
        let children = node.imask.count_ones() as usize;
        stack.extend((0..children).map(|i| (node.child_base_idx as usize + i, level + 1)));
    }
    deepest
}

/// A tree over the boxes of instances.
pub(crate) struct InstanceTree(Bvh2);

impl InstanceTree {
    /// Builds the tree over boxes `(min, max)` and returns it with the order of its primitives. There is at least one box.
    pub(crate) fn build(cube: &Cube, boxes: &[(DVec3, DVec3)]) -> (Self, Vec<u32>) {
        let boxes: Vec<Aabb> = boxes.iter().map(|(min, max)| cube.padded_box(*min, *max)).collect();
        let mut tree = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        let order = std::mem::take(&mut tree.primitive_indices);
        (Self(tree), order)
    }

    /// As [`TriangleTree::closest`].
    #[inline(always)]
    pub(crate) fn closest(&self, ray: &TreeRay, mut test: impl FnMut(usize) -> Option<f64>) {
        self.0.ray_traverse(ray.ray, &mut RayHit::none(), |_, i| test(i).map_or(f32::INFINITY, |t| ray.above(t)));
    }

    /// As [`TriangleTree::any`].
    #[inline(always)]
    pub(crate) fn any(&self, ray: &TreeRay, mut test: impl FnMut(usize) -> bool) -> bool {
        !self.0.ray_traverse_miss(ray.ray, |_, i| if test(i) { f32::NEG_INFINITY } else { f32::INFINITY })
    }
}
