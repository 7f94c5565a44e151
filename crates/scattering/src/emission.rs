//! Emission of area lights: the same radiance in every direction of the front, or of both sides.

use std::f64::consts::FRAC_1_PI;

use ergodic_geometry::Frame;
use glam::DVec3;

use crate::{Rgb, warp};

/// Radiance emitted into `w` (away from the surface) by a point that emits `radiance` from its front.
#[inline]
pub fn emitted(radiance: Rgb, double_sided: bool, ng: DVec3, w: DVec3) -> Rgb {
    let cos = ng.dot(w);
    if cos > 0.0 || (double_sided && cos < 0.0) { radiance } else { Rgb::ZERO }
}

/// Density in 1/sr of [`sample_direction`]: proportional to the cosine, over one side or over both.
#[inline]
pub fn pdf_direction(double_sided: bool, ng: DVec3, w: DVec3) -> f64 {
    let cos = ng.dot(w);
    if double_sided { 0.5 * FRAC_1_PI * cos.abs() } else { warp::cosine_hemisphere_pdf(cos) }
}

/// A direction in which the surface emits, with the density [`pdf_direction`].
#[inline]
pub fn sample_direction(double_sided: bool, ng: DVec3, u: [f64; 2]) -> DVec3 {
    let frame = Frame::from_normal(ng);
    if !double_sided {
        return frame.to_world(warp::cosine_hemisphere(u));
    }
    // The first number also chooses the side; what is left of it is uniform again.
    let front = u[0] < 0.5;
    let first = if front { 2.0 * u[0] } else { 2.0 * u[0] - 1.0 };
    let local = warp::cosine_hemisphere([first, u[1]]);
    frame.to_world(if front { local } else { -local })
}
