//! Smooth surfaces: the one direction of mirror reflection, refraction and straight transmission. Local directions, z > 0.

use glam::DVec3;

use crate::fresnel;

/// The mirror direction.
#[inline]
pub(crate) fn reflected(w: DVec3) -> DVec3 {
    DVec3::new(-w.x, -w.y, w.z)
}

/// The refracted direction, z < 0; `eta` = n_from / n_to. `None` under total internal reflection.
#[inline]
pub(crate) fn refracted(w: DVec3, eta: f64) -> Option<DVec3> {
    let cos2 = fresnel::cos_refracted_squared(w.z, eta);
    (cos2 > 0.0).then(|| DVec3::new(-eta * w.x, -eta * w.y, -cos2.sqrt()))
}
