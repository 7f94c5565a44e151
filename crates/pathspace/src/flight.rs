//! Walks through media that scatter (Pauly, Kollig and Keller 2000): from a vertex a particle flies freely in one direction, and
//! either ends in the medium or meets what lies behind.
//!
//! A point of a medium is a vertex like any other: its measure is volume, it has no cosine, and its scattering function is the
//! scattering coefficient times the phase function. The density of a flight is part of the conversions of [`Edge`](crate::Edge).
//!
//! A medium outside all solids fills a ball about the scene that holds the camera and all lights. So segments between vertices lie
//! in it whole, and light from infinitely far away enters it at a distance that follows from the vertex alone.
//!
//! Nothing here is called, and no number drawn, where no medium scatters.

use ergodic_geometry::{Hit, Ray};
use ergodic_metropolis::RandomSource;
use ergodic_scattering::{Component, Interaction, Medium, Repertoire, Rgb, Wavelength};
use glam::DVec3;

use crate::media::AIR;
use crate::scene::{bounds_towards, count_ray};
use crate::vertex::NO_EMITTER;
use crate::{Coverage, Kind, Scene, Vertex};

/// What a ray passes before it meets anything.
struct Way {
    ray: Ray,
    hit: Option<Hit>,
    /// Parameters of the ray between which the medium lies.
    medium: (f64, f64),
}

impl<R: Repertoire> Scene<R> {
    /// Whether any medium scatters, so that walks may end in one.
    #[inline]
    pub fn scatters(&self) -> bool {
        R::SCATTERING && self.parts.media.scatter()
    }

    /// The medium of the segment between two neighbouring vertices: of the solid whose inner side it leaves at its light side, else
    /// at its eye side, else that which its ends are met in.
    #[inline]
    pub(crate) fn medium_between(&self, light_side: &Vertex<R>, eye_side: &Vertex<R>, direction: DVec3) -> &Medium {
        let index = if bounds_towards(light_side, direction) {
            light_side.material
        } else if bounds_towards(eye_side, -direction) {
            eye_side.material
        } else if light_side.medium != AIR {
            light_side.medium
        } else {
            eye_side.medium
        };
        self.parts.media.medium(index)
    }

    /// What names the medium that a ray from `from` in direction `w` starts in.
    #[inline]
    fn medium_towards(&self, from: &Vertex<R>, w: DVec3) -> u32 {
        if bounds_towards(from, w) { from.material } else { from.medium }
    }

    /// Whether the medium of a vertex in one reaches its neighbour `other` along `w`, the direction to it.
    #[inline]
    pub fn shares_medium(&self, vertex: &Vertex<R>, other: &Vertex<R>, w: DVec3) -> bool {
        vertex.medium == self.medium_towards(other, -w)
    }

    /// Mean length of free flight in the medium of a vertex in one, over the channels' mean extinction; at most the scene's radius.
    pub fn mean_free_path(&self, vertex: &Vertex<R>) -> f64 {
        let extinction = self.parts.media.medium(vertex.medium).extinction().element_sum() / 3.0;
        (1.0 / extinction).min(self.parts.radius)
    }

    /// Transmittance of light from infinitely far away to `eye_side`.
    #[inline]
    pub(crate) fn transmittance_from_afar(&self, eye_side: &Vertex<R>, direction: DVec3) -> Rgb {
        if self.parts.media.air().is_vacuum() && !self.scatters() {
            // It comes from outside all solids.
            return Rgb::ONE;
        }
        let medium = self.parts.media.medium(self.medium_towards(eye_side, -direction));
        if medium.is_vacuum() {
            return Rgb::ONE;
        }
        medium.transmittance(self.depth_from_afar(eye_side.position, direction))
    }

    /// How far light from infinitely far away that travels along `direction` comes through the ball about the scene to a point in it.
    #[inline]
    pub fn depth_from_afar(&self, position: DVec3, direction: DVec3) -> f64 {
        self.crossing(position, -direction).1
    }

    /// Parameters at which a line enters and leaves the ball about the scene; equal where it misses it.
    #[inline]
    fn crossing(&self, origin: DVec3, direction: DVec3) -> (f64, f64) {
        let from_centre = origin - self.centre();
        let middle = -from_centre.dot(direction);
        let off_axis = from_centre + direction * middle;
        let half = (self.parts.radius * self.parts.radius - off_axis.length_squared()).max(0.0).sqrt();
        (middle - half, middle + half)
    }

    /// A point of the medium that `index` names.
    #[inline]
    fn point_of_medium(&self, position: DVec3, index: u32) -> Vertex<R> {
        Vertex {
            kind: Kind::Volume,
            component: Component::Rough,
            coverage: Coverage::WHOLE,
            emitter: NO_EMITTER,
            material: 0,
            medium: index,
            position,
            interaction: Interaction::in_medium(self.parts.media.medium(index).phase()),
            emission: Rgb::ZERO,
        }
    }

    /// A vertex in a medium, moved to another point of it.
    #[inline]
    #[must_use]
    pub fn moved_in_medium(&self, vertex: &Vertex<R>, position: DVec3) -> Vertex<R> {
        self.point_of_medium(position, vertex.medium)
    }

    /// The way of a ray from `from` in direction `w`.
    fn way(&self, from: &Vertex<R>, w: DVec3, rng: &mut impl RandomSource) -> Way {
        count_ray();
        let ray = self.parts.world.spawn(&from.anchor(), w);
        let hit = self.meet(&ray, rng);
        let end = hit.as_ref().map_or_else(|| self.crossing(ray.origin, w).1, |hit| hit.t);
        Way { ray, hit, medium: (0.0, end) }
    }

    /// The way of light from infinitely far away on the line along `direction` through `point`.
    fn way_from_afar(&self, direction: DVec3, point: DVec3, rng: &mut impl RandomSource) -> Way {
        count_ray();
        let ray = self.ray_from_afar(direction, point);
        let hit = self.meet(&ray, rng);
        let (start, end) = self.crossing(ray.origin, direction);
        let end = hit.as_ref().map_or(end, |hit| hit.t);
        Way { ray, hit, medium: (start, end) }
    }

    /// The point of a medium after a flight of `length` into it, if the medium reaches so far.
    fn point_on_way(&self, way: &Way, length: f64, index: u32) -> Option<Vertex<R>> {
        let (start, end) = way.medium;
        let t = start + length;
        let ends_here = length > 0.0 && t < end && self.parts.media.medium(index).scatters();
        ends_here.then(|| self.point_of_medium(way.ray.origin + way.ray.direction * t, index))
    }

    /// A free flight in the medium that `index` names. Draws a number if that medium scatters.
    fn flight(&self, index: u32, rng: &mut impl RandomSource) -> f64 {
        let medium = self.parts.media.medium(index);
        if medium.scatters() { medium.sample_flight(rng.uniform()) } else { f64::INFINITY }
    }

    /// Makes `to` what a particle meets that flies from `from` in direction `w`: a point of a medium or of a surface; false if that is
    /// nothing.
    #[inline]
    pub fn fly_to(
        &self,
        from: &Vertex<R>,
        w: DVec3,
        wavelength: Wavelength,
        to: &mut Vertex<R>,
        rng: &mut impl RandomSource,
    ) -> bool {
        if self.scatters() {
            self.fly_in_media(from, w, wavelength, to, rng)
        } else {
            self.trace_to(from, w, wavelength, to, rng)
        }
    }

    /// Makes `to` what [`Self::fly_to`] does, or the environment where that is nothing; false if that is black.
    #[inline]
    pub fn fly_or_escape(
        &self,
        from: &Vertex<R>,
        w: DVec3,
        wavelength: Wavelength,
        to: &mut Vertex<R>,
        rng: &mut impl RandomSource,
    ) -> bool {
        self.fly_to(from, w, wavelength, to, rng) || self.escape_to(w, to)
    }

    fn fly_in_media(
        &self,
        from: &Vertex<R>,
        w: DVec3,
        wavelength: Wavelength,
        to: &mut Vertex<R>,
        rng: &mut impl RandomSource,
    ) -> bool {
        let index = self.medium_towards(from, w);
        let length = self.flight(index, rng);
        let way = self.way(from, w, rng);
        if let Some(point) = self.point_on_way(&way, length, index) {
            *to = point;
            return true;
        }
        let Some(hit) = way.hit else { return false };
        self.place(&hit, wavelength, to);
        to.medium = self.medium_met(from, w, to, hit.instance);
        true
    }

    /// Makes `to` what light from infinitely far away meets on the line along `direction` through `point`: a point of the medium outside
    /// all solids, or of a surface; false if that is nothing.
    pub(crate) fn fly_parallel(
        &self,
        direction: DVec3,
        point: DVec3,
        wavelength: Wavelength,
        to: &mut Vertex<R>,
        rng: &mut impl RandomSource,
    ) -> bool {
        if !self.scatters() {
            return self.trace_parallel(direction, point, wavelength, to, rng);
        }
        let length = self.flight(AIR, rng);
        let way = self.way_from_afar(direction, point, rng);
        if let Some(met) = self.point_on_way(&way, length, AIR) {
            *to = met;
            return true;
        }
        let Some(hit) = way.hit else { return false };
        self.place(&hit, wavelength, to);
        true
    }

    /// Makes `to` the point of a medium that a flight of `length` from `from` in direction `w` ends in; false if no medium that
    /// scatters reaches so far.
    pub fn place_in_medium(
        &self,
        from: &Vertex<R>,
        w: DVec3,
        length: f64,
        to: &mut Vertex<R>,
        rng: &mut impl RandomSource,
    ) -> bool {
        let index = self.medium_towards(from, w);
        let way = self.way(from, w, rng);
        self.point_on_way(&way, length, index).map(|point| *to = point).is_some()
    }

    /// Makes `to` the point of the medium outside all solids that light from infinitely far away reaches after `length` in it, on the
    /// line along `direction` through `point`; false if it does not reach so far.
    pub fn place_from_afar(
        &self,
        direction: DVec3,
        point: DVec3,
        length: f64,
        to: &mut Vertex<R>,
        rng: &mut impl RandomSource,
    ) -> bool {
        let way = self.way_from_afar(direction, point, rng);
        self.point_on_way(&way, length, AIR).map(|point| *to = point).is_some()
    }
}
