//! Maps from the unit square to distributions of directions and points, each with its density.

use std::f64::consts::{FRAC_1_PI, TAU};

use ergodic_geometry::{sin_cos_eighth, sin_cos_turns};
use glam::{DVec2, DVec3};

/// Density of [`uniform_sphere`] in 1/sr.
pub const UNIFORM_SPHERE_PDF: f64 = 0.25 * FRAC_1_PI;

/// Density of [`concentric_disk`] over the unit disk's area.
pub const CONCENTRIC_DISK_PDF: f64 = FRAC_1_PI;

/// The unit vector at height `z` over the xy-plane and an azimuth in turns; `one_minus_z` is given apart because it is exact
/// where `1 - z` is not.
#[inline]
fn spherical(z: f64, one_minus_z: f64, azimuth: f64) -> DVec3 {
    let radius = (one_minus_z * (1.0 + z)).max(0.0).sqrt();
    let (sin, cos) = sin_cos_turns(azimuth);
    DVec3::new(radius * cos, radius * sin, z)
}

/// A point uniform over the unit disk (Shirley and Chiu 1997): concentric squares become concentric circles.
#[inline(always)]
pub fn concentric_disk(u: [f64; 2]) -> DVec2 {
    let (x, y) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    if x == 0.0 && y == 0.0 {
        return DVec2::ZERO;
    }
    // Half of all points lie in either pair of wedges, so they are told apart by selection, not by a branch.
    let beside = x.abs() > y.abs();
    let (radius, across) = if beside { (x, y) } else { (y, x) };
    let (sin, cos) = sin_cos_eighth(0.125 * (across / radius));
    let (x, y) = if beside { (cos, sin) } else { (sin, cos) };
    DVec2::new(radius * x, radius * y)
}

/// A direction about +z with density cos/pi (Malley's method).
#[inline]
pub fn cosine_hemisphere(u: [f64; 2]) -> DVec3 {
    let disk = concentric_disk(u);
    DVec3::new(disk.x, disk.y, (1.0 - disk.length_squared()).max(0.0).sqrt())
}

/// Density of [`cosine_hemisphere`] in 1/sr for a direction whose cosine with +z is `cos`.
#[inline]
pub fn cosine_hemisphere_pdf(cos: f64) -> f64 {
    cos.max(0.0) * FRAC_1_PI
}

/// A direction uniform over the sphere, with density [`UNIFORM_SPHERE_PDF`].
#[inline]
pub fn uniform_sphere(u: [f64; 2]) -> DVec3 {
    spherical(1.0 - 2.0 * u[0], 2.0 * u[0], u[1])
}

/// A direction uniform over the cone about +z whose half angle has the cosine `cos_max`.
#[inline]
pub fn uniform_cone(u: [f64; 2], cos_max: f64) -> DVec3 {
    let one_minus_z = u[0] * (1.0 - cos_max);
    spherical(1.0 - one_minus_z, one_minus_z, u[1])
}

/// Density of [`uniform_cone`] in 1/sr for a direction inside the cone.
#[inline]
pub fn uniform_cone_pdf(cos_max: f64) -> f64 {
    1.0 / (TAU * (1.0 - cos_max))
}

/// Barycentric coordinates of vertices 1 and 2 of a point uniform over a triangle; the density is 1/area.
///
/// The square is folded along its diagonal towards the corner, which is continuous and keeps strata whole (Heitz 2019).
#[inline]
pub fn uniform_triangle(u: [f64; 2]) -> (f64, f64) {
    let (x, y) = (u[0], u[1]);
    if y > x {
        let x = 0.5 * x;
        (x, y - x)
    } else {
        let y = 0.5 * y;
        (x - y, y)
    }
}
