//! Two neighbouring vertices: direction, geometry term, absorption, and the only conversion between solid-angle and area
//! measure.

use ergodic_scattering::Rgb;
use glam::DVec3;

use crate::{Kind, Scene, Vertex};

/// The segment between two neighbouring vertices, without visibility. A pure function of its two ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Unit direction in which light flows: from the light side to the eye side.
    pub direction: DVec3,
    /// Length; infinite when the light side is a distant light or the environment.
    pub length: f64,
    /// Geometry term without visibility, G = |cos| |cos| / d² (Veach 8.3). A cosine is 1 at points in free space; with a
    /// distant light or the environment G = |cos| at the eye side.
    pub geometry: f64,
    /// Turns a solid-angle density at the light side into an area density at the eye side: |cos| / d². From a distant
    /// light or the environment it turns a density on their disk into one on the surface: |cos|.
    pub to_eye_side: f64,
    /// Turns a solid-angle density at the eye side into an area density at the light side: |cos| / d²; 0 when the light
    /// side cannot be hit, and 1 to the environment, whose measure is solid angle.
    pub to_light_side: f64,
    /// Beer's transmittance along the segment.
    pub transmittance: Rgb,
}

fn cosine(vertex: &Vertex, w: DVec3) -> f64 {
    if vertex.is_surface() { vertex.interaction.ng.dot(w).abs() } else { 1.0 }
}

impl Edge {
    /// The edge from `light_side` to `eye_side`.
    #[inline]
    pub fn new(scene: &Scene, light_side: &Vertex, eye_side: &Vertex) -> Self {
        if light_side.is_distant() {
            let direction = light_side.interaction.ng;
            let cos_eye = cosine(eye_side, direction);
            return Self {
                direction,
                length: f64::INFINITY,
                geometry: cos_eye,
                to_eye_side: cos_eye,
                to_light_side: if light_side.kind == Kind::Environment { 1.0 } else { 0.0 },
                // It comes from outside all solids.
                transmittance: Rgb::ONE,
            };
        }
        let offset = eye_side.position - light_side.position;
        let length_squared = offset.length_squared();
        let length = length_squared.sqrt();
        let direction = offset / length;
        let inverse = 1.0 / length_squared;
        let cos_light = cosine(light_side, direction);
        let cos_eye = cosine(eye_side, direction);
        Self {
            direction,
            length,
            geometry: cos_light * cos_eye * inverse,
            to_eye_side: cos_eye * inverse,
            to_light_side: if light_side.is_surface() { cos_light * inverse } else { 0.0 },
            transmittance: scene.transmittance(light_side, eye_side, direction, length),
        }
    }
}
