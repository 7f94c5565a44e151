//! Maps from the world to the cube [-1, 1]³ that a tree lives in, so that its tolerances are the same for every unit and
//! offset.

use glam::{DAffine3, DMat3, DVec3};
use obvhs::aabb::Aabb;

use crate::epsilon::{MAX_TRANSFORM_ERROR, TREE_PADDING};

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
    pub(crate) fn padded_box(&self, min: DVec3, max: DVec3) -> Aabb {
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
