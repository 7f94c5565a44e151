//! Two neighbouring vertices: direction, geometry term, transmittance, and the only conversion between solid angle and the measure
//! of vertices, area or volume.

use ergodic_scattering::{Repertoire, Rgb, Sight};
use glam::DVec3;

use crate::{Scene, Vertex};

/// The segment between two neighbouring vertices, without visibility. A pure function of its two ends.
///
/// In scenes with surfaces that cover a share only, visibility is part of it (see [`crate::Coverage`]): the share of light that
/// passes the segment is in the geometry term and in both conversions, and the coverage of the vertex that is found in the
/// conversion to its side. The coverage of the light side is in the geometry term, so that a path has that of each vertex once.
///
/// In a medium that scatters, a walk flies freely along the segment and ends in the medium or passes it (see [`crate::flight`]): the
/// conversion to a vertex holds the density with which a flight ends there, so that what is drawn per solid angle becomes a density
/// per volume, or the probability with which it gets there if that is no point of the medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Unit direction in which light flows: from the light side to the eye side.
    pub direction: DVec3,
    /// Length; infinite when the light side is a distant light or the environment. To an orthographic camera, that to its film.
    pub length: f64,
    /// Geometry term without visibility, G = |cos| |cos| / d² (Veach 8.3). A cosine is 1 at points in free space and in media; with a
    /// distant light or the environment G = |cos| at the eye side, with an orthographic camera |cos| at the light side.
    pub geometry: f64,
    /// Turns a solid-angle density at the light side into an area density at the eye side: |cos| / d². From a distant
    /// light or the environment it turns a density on their disk into one on the surface: |cos|.
    pub to_eye_side: f64,
    /// Turns a solid-angle density at the eye side into an area density at the light side: |cos| / d²; 0 when the light
    /// side cannot be hit, and 1 to the environment, whose measure is solid angle. From an orthographic camera it turns a density
    /// on its film into one on the surface: |cos|.
    pub to_light_side: f64,
    /// Beer's transmittance along the segment.
    pub transmittance: Rgb,
}

#[inline(always)]
fn cosine<R: Repertoire>(vertex: &Vertex<R>, w: DVec3) -> f64 {
    if vertex.has_area() { vertex.interaction.ng.dot(w).abs() } else { 1.0 }
}

impl Edge {
    /// The edge from `light_side` to `eye_side`.
    #[inline(always)]
    pub fn new<R: Repertoire>(scene: &Scene<R>, light_side: &Vertex<R>, eye_side: &Vertex<R>) -> Self {
        let mut edge = Self::between(scene, light_side, eye_side);
        if scene.scatters() {
            edge = edge.flown(scene, light_side, eye_side);
        }
        if scene.has_partial_coverage() { edge.covered(scene, light_side, eye_side) } else { edge }
    }

    /// This edge with the shares that surfaces cover.
    fn covered<R: Repertoire>(self, scene: &Scene<R>, light_side: &Vertex<R>, eye_side: &Vertex<R>) -> Self {
        let passes = scene.visibility(light_side, eye_side);
        let (light, eye) = (passes * light_side.coverage.share(), passes * eye_side.coverage.share());
        Self {
            geometry: self.geometry * light,
            to_eye_side: self.to_eye_side * eye,
            to_light_side: self.to_light_side * light,
            ..self
        }
    }

    /// This edge with free flight in both conversions.
    fn flown<R: Repertoire>(self, scene: &Scene<R>, light_side: &Vertex<R>, eye_side: &Vertex<R>) -> Self {
        let flight = |to: &Vertex<R>| self.flight(scene, light_side, eye_side, to);
        Self {
            to_eye_side: self.to_eye_side * flight(eye_side),
            to_light_side: self.to_light_side * flight(light_side),
            ..self
        }
    }

    /// What free flight adds to the conversion to `to`, one of the two ends: the density per length of a flight that ends there if
    /// it is a point of a medium, else the probability of getting there. 1 where nothing scatters.
    #[inline]
    pub fn flight<R: Repertoire>(
        &self,
        scene: &Scene<R>,
        light_side: &Vertex<R>,
        eye_side: &Vertex<R>,
        to: &Vertex<R>,
    ) -> f64 {
        if !scene.scatters() {
            return 1.0;
        }
        let medium = scene.medium_between(light_side, eye_side, self.direction);
        match (medium.scatters(), to.is_in_medium()) {
            (false, _) => 1.0,
            (true, true) => medium.flight_pdf(self.transmittance),
            (true, false) => medium.flight_survival(self.transmittance),
        }
    }

    /// The segment as if nothing covered or scattered. A light without extent is not seen itself: on the image it would be a Dirac,
    /// which only strategies that connect it with the eye could make, and no pixel could show. So G = 0 between the two.
    #[inline(always)]
    fn between<R: Repertoire>(scene: &Scene<R>, light_side: &Vertex<R>, eye_side: &Vertex<R>) -> Self {
        let mut edge = Self::straight(scene, light_side, eye_side);
        if light_side.is_without_extent() && eye_side.is_eye() {
            edge.geometry = 0.0;
        }
        edge
    }

    #[inline(always)]
    fn straight<R: Repertoire>(scene: &Scene<R>, light_side: &Vertex<R>, eye_side: &Vertex<R>) -> Self {
        if light_side.is_distant() {
            let direction = light_side.interaction.ng;
            let cos_eye = cosine(eye_side, direction);
            return Self {
                direction,
                length: f64::INFINITY,
                geometry: cos_eye,
                to_eye_side: cos_eye,
                to_light_side: if light_side.is_environment() { 1.0 } else { 0.0 },
                transmittance: scene.transmittance_from_afar(eye_side, direction),
            };
        }
        if eye_side.is_on_film() {
            return Self::to_distant_camera(scene, light_side, eye_side);
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
            to_light_side: if light_side.scatters() { cos_light * inverse } else { 0.0 },
            transmittance: scene.transmittance(light_side, eye_side, direction, length),
        }
    }

    /// The camera's line of sight along this edge, from its vertex `eye` to the vertex `seen`.
    #[inline]
    pub fn sight<R: Repertoire>(&self, seen: &Vertex<R>, eye: &Vertex<R>) -> Sight {
        let point = if seen.is_distant() { DVec3::NAN } else { seen.position };
        Sight { eye: eye.position, point, direction: -self.direction }
    }

    /// The edge from a point to an orthographic camera, the mirror image of one from a distant light.
    fn to_distant_camera<R: Repertoire>(scene: &Scene<R>, light_side: &Vertex<R>, eye_side: &Vertex<R>) -> Self {
        let direction = -eye_side.interaction.ng;
        let length = scene.camera().depth(light_side.position);
        let cos_light = cosine(light_side, direction);
        Self {
            direction,
            length,
            geometry: cos_light,
            to_eye_side: 0.0,
            to_light_side: if light_side.scatters() { cos_light } else { 0.0 },
            transmittance: scene.transmittance(light_side, eye_side, direction, length),
        }
    }
}
