//! Lambertian reflection: f = albedo / pi, sampled by the cosine. As a lobe of a layered surface, and alone as the
//! commonest and cheapest material.

use std::f64::consts::FRAC_1_PI;

use ergodic_geometry::Frame;
use glam::DVec3;

use crate::{Rgb, warp};

/// Scattering function in 1/sr of a Lambertian lobe.
#[inline]
pub(crate) fn value(albedo: Rgb) -> Rgb {
    albedo * FRAC_1_PI
}

/// Density in 1/sr of [`sample`].
#[inline]
pub(crate) fn pdf(to: DVec3) -> f64 {
    warp::cosine_hemisphere_pdf(to.z)
}

/// A local direction on the upper side.
#[inline(always)]
pub(crate) fn sample(u: [f64; 2]) -> DVec3 {
    warp::cosine_hemisphere(u)
}

/// A surface that is Lambertian and nothing else, the same on both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    /// Reflected share of the light.
    pub albedo: Rgb,
}

impl Lambert {
    /// The scattering function; needs only the two directions' cosines with the shading normal.
    #[inline]
    pub(crate) fn eval(&self, cos_light: f64, cos_eye: f64) -> Rgb {
        if cos_light * cos_eye > 0.0 { value(self.albedo) } else { Rgb::ZERO }
    }

    /// Density of [`Self::sample`].
    #[inline]
    pub(crate) fn pdf(&self, cos_from: f64, cos_to: f64) -> f64 {
        if cos_from * cos_to > 0.0 { cos_to.abs() * FRAC_1_PI } else { 0.0 }
    }

    /// A direction on the side of a direction with cosine `cos_from`; `None` for a black surface.
    #[inline(always)]
    pub(crate) fn sample(&self, frame: &Frame, cos_from: f64, u: [f64; 2]) -> Option<DVec3> {
        if self.albedo == Rgb::ZERO {
            return None;
        }
        let local = sample(u);
        Some(frame.to_world(DVec3::new(local.x, local.y, local.z.copysign(cos_from))))
    }
}
