//! Refraction through a GGX surface (Walter et al. 2007, eq. 21), without its Fresnel factor.
//!
//! Local directions on opposite sides of the surface, each with the index of the medium it lies in. Masking above and
//! shadowing below are independent: the product of two G1 (Walter's eq. 23).

use glam::DVec3;

use crate::fresnel;
use crate::ggx::{self, Roughness};

/// The microfacet that refracts one direction into the other.
pub(crate) struct Facet {
    /// Its unit normal, on the side z > 0.
    h: DVec3,
    /// |a·h|.
    pub cos_a: f64,
    /// |b·h|.
    pub cos_b: f64,
    /// |n_a a + n_b b|^2 = (n_a a·h + n_b b·h)^2, the denominator of dh/dw.
    stretch: f64,
}

/// The facet between `a` and `b`; `None` where either would see it from behind.
#[inline]
pub(crate) fn facet(a: DVec3, n_a: f64, b: DVec3, n_b: f64) -> Option<Facet> {
    let sum = a * n_a + b * n_b;
    let stretch = sum.length_squared();
    let h = sum * (stretch.sqrt().recip().copysign(sum.z));
    let (dot_a, dot_b) = (a.dot(h), b.dot(h));
    let faces = dot_a * a.z > 0.0 && dot_b * b.z > 0.0;
    faces.then_some(Facet { h, cos_a: dot_a.abs(), cos_b: dot_b.abs(), stretch })
}

/// The symmetric part in 1/sr: the scattering function for radiance divided by the square of the index on the eye's side.
#[inline]
pub(crate) fn value(alpha: impl Roughness, a: DVec3, b: DVec3, facet: &Facet) -> f64 {
    let masking = ggx::masking_over_cosine(alpha, a) * ggx::masking_over_cosine(alpha, b);
    masking * alpha.distribution(facet.h) * facet.cos_a * facet.cos_b / facet.stretch
}

/// Density in 1/sr of [`sample`] for a facet between `a` = from and `b` = to, in the medium `n_to`: the visible normals'
/// density times dh/dto (eq. 17).
#[inline]
pub(crate) fn pdf(alpha: impl Roughness, from: DVec3, n_to: f64, facet: &Facet) -> f64 {
    let visible = ggx::visible_over_cosine(alpha, from, facet.h) * facet.cos_a;
    visible * n_to * n_to * facet.cos_b / facet.stretch
}

/// `from` (z > 0) refracted by a visible microfacet; `eta` = n_from / n_to. `None` where the facet reflects totally.
#[inline]
pub(crate) fn sample(alpha: impl Roughness, eta: f64, from: DVec3, u: [f64; 2]) -> Option<DVec3> {
    let h = ggx::sample_visible(alpha, from, u);
    let cos = from.dot(h);
    let cos2 = fresnel::cos_refracted_squared(cos, eta);
    (cos2 > 0.0).then(|| h * (eta * cos - cos2.sqrt()) - from * eta)
}
