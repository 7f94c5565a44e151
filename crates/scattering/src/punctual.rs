//! Lights without extent: point, spot and directional (KHR_lights_punctual).

use glam::DVec3;

use crate::Rgb;

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
