//! Reflection off a GGX surface (Walter et al. 2007, eq. 20), without its Fresnel factor. Local directions, z > 0.

use glam::DVec3;

use crate::ggx::{self, Roughness};

/// D G2 / (4 |light.z| |eye.z|) in 1/sr; `h` is the unit half vector.
#[inline]
pub(crate) fn value(alpha: impl Roughness, light: DVec3, eye: DVec3, h: DVec3) -> f64 {
    alpha.distribution(h) * ggx::visibility(alpha, light, eye)
}

/// Density in 1/sr of [`sample`]: the visible normals' density times dh/dto = 1 / (4 from·h).
#[inline]
pub(crate) fn pdf(alpha: impl Roughness, from: DVec3, h: DVec3) -> f64 {
    0.25 * ggx::visible_over_cosine(alpha, from, h)
}

/// `from` mirrored by a visible microfacet; may come out below the surface.
#[inline]
pub(crate) fn sample(alpha: impl Roughness, from: DVec3, u: [f64; 2]) -> DVec3 {
    let h = ggx::sample_visible(alpha, from, u);
    h * (2.0 * from.dot(h)) - from
}
