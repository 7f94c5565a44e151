//! Reflection off a GGX surface (Walter et al. 2007, eq. 20), without its Fresnel factor. Local directions, z > 0.

use glam::DVec3;

use crate::ggx;

/// D G2 / (4 |light.z| |eye.z|) in 1/sr; `h` is the unit half vector.
#[inline]
pub(crate) fn value(alpha: f64, light: DVec3, eye: DVec3, h: DVec3) -> f64 {
    ggx::distribution(alpha, h) * ggx::visibility(alpha, light, eye)
}

/// Density in 1/sr of [`sample`]: the visible normals' density times dh/dto = 1 / (4 from·h).
#[inline]
pub(crate) fn pdf(alpha: f64, from: DVec3, h: DVec3) -> f64 {
    0.25 * ggx::visible_over_cosine(alpha, from, h)
}

/// `from` mirrored by a visible microfacet; may come out below the surface.
#[inline]
pub(crate) fn sample(alpha: f64, from: DVec3, u: [f64; 2]) -> DVec3 {
    let h = ggx::sample_visible(alpha, from, u);
    h * (2.0 * from.dot(h)) - from
}
