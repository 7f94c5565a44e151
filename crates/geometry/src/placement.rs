//! How an instance puts its mesh into the world: points, directions and normals.

use glam::{DAffine3, DMat3, DVec3};

use crate::Instance;

/// An instance's transform with what follows from it.
#[derive(Clone, Debug)]
pub(crate) struct Placement {
    pub mesh: u32,
    pub transform: DAffine3,
    /// Turns normals: the inverse transpose times |det|. It is made of cofactors, so it exists for flattening transforms too.
    pub normals: DMat3,
    /// -1 where the transform mirrors, else 1.
    pub handedness: f64,
}

impl Placement {
    pub(crate) fn new(instance: &Instance) -> Self {
        let m = instance.transform.matrix3;
        let handedness = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
        let cofactors = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        Self { mesh: instance.mesh, transform: instance.transform, normals: cofactors * handedness, handedness }
    }

    /// A point in the world. Every world-space vertex of the crate comes from here, so all copies have the same bits.
    #[inline(always)]
    pub(crate) fn point(&self, p: DVec3) -> DVec3 {
        self.transform.transform_point3(p)
    }
}
