//! The phase function of Henyey and Greenstein (1941): how a medium turns light, by one parameter.
//!
//! p(θ) = (1 - g²) / (4π (1 + g² - 2 g cos θ)^(3/2)) per sr, with θ the angle between the directions of travel before and after.
//! It is the same for both ways through the vertex, and its integral over the sphere is 1.

use std::f64::consts::PI;

use ergodic_geometry::{Frame, sin_cos_turns};
use glam::DVec3;

use crate::Rgb;

/// The scattering at a point of a medium: scattering coefficient times phase function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HenyeyGreenstein {
    /// Scattering coefficient σ_s per unit of length.
    pub scattering: Rgb,
    /// Mean cosine g of the turn, in (-1, 1): 0 is the same to all sides, 1 forward.
    pub anisotropy: f64,
}

impl HenyeyGreenstein {
    /// σ_s p per unit of length and sr, between two directions away from the point.
    #[inline]
    pub(crate) fn eval(&self, light: DVec3, eye: DVec3) -> Rgb {
        self.scattering * self.pdf(light, eye)
    }

    /// Density in 1/sr of [`Self::sample`]: the phase function itself.
    #[inline]
    pub(crate) fn pdf(&self, from: DVec3, to: DVec3) -> f64 {
        let g = self.anisotropy;
        // Away from the point both, so the cosine of the turn has the other sign.
        let base = 1.0 + g * g + 2.0 * g * from.dot(to);
        (1.0 - g * g) / (4.0 * PI * base * base.sqrt())
    }

    /// A direction away from the point, for light that came from `from`.
    ///
    /// The inverse of the distribution of the cosine, multiplied out so that it divides by no power of g.
    #[inline]
    pub(crate) fn sample(&self, from: DVec3, u: [f64; 2]) -> DVec3 {
        let (g, a) = (self.anisotropy, 2.0 * u[0] - 1.0);
        let root = 1.0 + g * a;
        let above = 2.0 * a + g * (a * a + 3.0) + 2.0 * g * g * a + g * g * g * (a * a - 1.0);
        let cos = (above / (2.0 * root * root)).clamp(-1.0, 1.0);
        let sin = (1.0 - cos * cos).sqrt();
        let (sin_phi, cos_phi) = sin_cos_turns(u[1]);
        let frame = Frame::from_normal(-from);
        (frame.t * (sin * cos_phi) + frame.b * (sin * sin_phi) - from * cos).normalize()
    }
}
