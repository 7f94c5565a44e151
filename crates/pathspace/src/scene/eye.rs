//! The eye ends of paths: the camera's own vertex and its lines of sight.

use super::*;

impl Scene {
    /// The camera as a vertex; of a lens its middle.
    #[inline]
    pub fn camera_vertex(&self) -> Vertex {
        self.eye
    }

    /// The camera's end of a path, with density [`Self::eye_pdf_area`]. Draws numbers for a lens only.
    #[inline]
    pub fn sample_eye(&self, rng: &mut impl RandomSource) -> Vertex {
        let mut vertex = self.eye;
        if self.camera.has_aperture()
            && let Some(position) = self.camera.sample_aperture([rng.uniform(), rng.uniform()])
        {
            vertex.position = position;
            if !self.media.is_empty() {
                vertex.medium = self.media.around(&self.world, position, None);
            }
        }
        vertex
    }

    /// Area density of the camera's end of a path on its lens; 1, the Dirac divided out, without a lens; 0 for other vertices.
    #[inline]
    pub fn eye_pdf_area(&self, vertex: &Vertex) -> f64 {
        if vertex.is_eye() { self.camera.pdf_aperture() } else { 0.0 }
    }

    /// The vertex from which a line of sight of an orthographic camera starts: on its film. `None` for other cameras, whose own vertex
    /// `eye` it is.
    #[inline]
    pub fn start_on_film(&self, eye: &Vertex, sight: &Sight) -> Option<Vertex> {
        (eye.kind == Kind::DistantCamera).then(|| self.on_film(sight.eye))
    }

    /// Makes `to` what [`Self::fly_to`] finds on a line of sight of the camera, whose vertex is `eye`; false if there is nothing.
    #[inline]
    pub fn trace_sight(
        &self,
        eye: &Vertex,
        sight: &Sight,
        wavelength: Wavelength,
        to: &mut Vertex,
        rng: &mut impl RandomSource,
    ) -> bool {
        if eye.kind == Kind::DistantCamera {
            return self.fly_to(&self.on_film(sight.eye), sight.direction, wavelength, to, rng);
        }
        self.fly_to(eye, sight.direction, wavelength, to, rng)
    }

    /// What [`Self::fly_or_escape`] makes of `to` on a line of sight of the camera, whose vertex is `eye`.
    ///
    /// An orthographic camera does not see the environment itself: the path would have no end with a position.
    #[inline]
    pub fn look_along(
        &self,
        eye: &Vertex,
        sight: &Sight,
        wavelength: Wavelength,
        to: &mut Vertex,
        rng: &mut impl RandomSource,
    ) -> bool {
        if eye.kind == Kind::DistantCamera {
            return self.trace_sight(eye, sight, wavelength, to, rng);
        }
        self.fly_or_escape(eye, sight.direction, wavelength, to, rng)
    }

    /// A point of the orthographic film as a vertex to trace from.
    pub(super) fn on_film(&self, position: DVec3) -> Vertex {
        let medium = if self.media.is_empty() { AIR } else { self.media.around(&self.world, position, None) };
        Vertex { position, medium, ..self.eye }
    }

    /// The point of an orthographic film that sees a vertex.
    pub(super) fn film_point(&self, vertex: &Vertex) -> DVec3 {
        vertex.position - self.camera.forward() * self.camera.depth(vertex.position)
    }

    /// Whether an orthographic camera sees a vertex that lies before its film.
    pub(super) fn seen_from_film(&self, vertex: &Vertex) -> bool {
        self.world.visible(&vertex.anchor(), &Anchor { position: self.film_point(vertex), normal: DVec3::ZERO })
    }
}
