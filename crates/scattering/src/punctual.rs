//! Lights without extent: point, spot and directional (KHR_lights_punctual).

use std::f64::consts::{PI, TAU};

use ergodic_geometry::Frame;
use glam::DVec3;

use crate::{Rgb, warp};

/// A light without extent, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PunctualLight {
    /// Emits the same intensity in every direction.
    Point {
        /// Where it is.
        position: DVec3,
        /// Radiant intensity per channel: colour times intensity in candela.
        intensity: Rgb,
    },
    /// Emits into a cone; full intensity inside the inner angle, none outside the outer.
    Spot {
        /// Where it is.
        position: DVec3,
        /// Unit axis of the cone, away from the light.
        axis: DVec3,
        /// Radiant intensity inside the inner cone.
        intensity: Rgb,
        /// Cosine of the inner cone's half angle.
        cos_inner: f64,
        /// Cosine of the outer cone's half angle, less than `cos_inner`.
        cos_outer: f64,
    },
    /// Parallel light from infinitely far away.
    Directional {
        /// Unit direction in which the light travels.
        direction: DVec3,
        /// Irradiance on a surface facing it: colour times intensity in lux.
        irradiance: Rgb,
    },
}

/// Least difference of the cone's cosines, as KHR_lights_punctual has it: the rim's ramp never becomes a step.
const LEAST_RAMP: f64 = 0.001;

/// Width in cosine of the ramp from the outer to the inner cone.
#[inline]
fn ramp(cos_inner: f64, cos_outer: f64) -> f64 {
    (cos_inner - cos_outer).max(LEAST_RAMP)
}

impl PunctualLight {
    /// What leaves into the unit direction `w` from the light outwards: radiant intensity in W/sr; for a directional light
    /// its irradiance, whatever `w` (the direction is a Dirac the caller keeps to).
    #[inline]
    pub fn emitted(&self, w: DVec3) -> Rgb {
        match *self {
            Self::Point { intensity, .. } => intensity,
            Self::Spot { axis, intensity, cos_inner, cos_outer, .. } => {
                let attenuation = ((axis.dot(w) - cos_outer) / ramp(cos_inner, cos_outer)).clamp(0.0, 1.0);
                intensity * (attenuation * attenuation)
            }
            Self::Directional { irradiance, .. } => irradiance,
        }
    }

    /// Density in 1/sr of [`Self::sample_direction`]; for a directional light 1, the Dirac divided out.
    #[inline]
    pub fn pdf_direction(&self, w: DVec3) -> f64 {
        match *self {
            Self::Point { .. } => warp::UNIFORM_SPHERE_PDF,
            Self::Spot { axis, cos_outer, .. } => {
                if axis.dot(w) >= cos_outer {
                    warp::uniform_cone_pdf(cos_outer)
                } else {
                    0.0
                }
            }
            Self::Directional { .. } => 1.0,
        }
    }

    /// A direction in which the light emits: uniform over the sphere or the outer cone, or the one direction.
    #[inline]
    pub fn sample_direction(&self, u: [f64; 2]) -> DVec3 {
        match *self {
            Self::Point { .. } => warp::uniform_sphere(u),
            Self::Spot { axis, cos_outer, .. } => Frame::from_normal(axis).to_world(warp::uniform_cone(u, cos_outer)),
            Self::Directional { direction, .. } => direction,
        }
    }

    /// Where the light is; `None` for one infinitely far away.
    #[inline]
    pub fn position(&self) -> Option<DVec3> {
        match *self {
            Self::Point { position, .. } | Self::Spot { position, .. } => Some(position),
            Self::Directional { .. } => None,
        }
    }

    /// Radiant power in W; of a directional light what crosses a disk of `scene_radius`.
    pub fn power(&self, scene_radius: f64) -> Rgb {
        match *self {
            Self::Point { intensity, .. } => intensity * (4.0 * PI),
            Self::Spot { intensity, cos_inner, cos_outer, .. } => {
                // The squared linear ramp from cos_outer to `top`, cut off at the axis, and the full cone above it.
                let width = ramp(cos_inner, cos_outer);
                let top = (cos_outer + width).min(1.0);
                let rim = ((top - cos_outer) / width).powi(3) * width / 3.0;
                intensity * (TAU * (rim + (1.0 - top)))
            }
            Self::Directional { irradiance, .. } => irradiance * (PI * scene_radius * scene_radius),
        }
    }
}
