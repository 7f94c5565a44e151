//! The eye ends of paths: the camera's own vertex and its lines of sight.

use super::*;

impl<R: Repertoire> Scene<R> {
    /// The camera as a vertex; of a lens its middle.
    #[inline]
    pub fn camera_vertex(&self) -> Vertex<R> {
        self.parts.eye.within()
    }

    /// The camera's end of a path, with density [`Self::eye_pdf_area`]. Draws numbers for a lens only.
    #[inline]
    pub fn sample_eye(&self, rng: &mut impl RandomSource) -> Vertex<R> {
        let mut vertex = self.camera_vertex();
        if self.camera.has_aperture()
            && let Some(position) = self.camera.sample_aperture([rng.uniform(), rng.uniform()])
        {
            vertex.position = position;
            if self.has_media() {
                vertex.medium = self.parts.media.around(&self.parts.world, position, None);
            }
        }
        vertex
    }

    /// Area density of the camera's end of a path on its lens; 1, the Dirac divided out, without a lens; 0 for other vertices.
    #[inline]
    pub fn eye_pdf_area(&self, vertex: &Vertex<R>) -> f64 {
        if vertex.is_eye() { self.camera.pdf_aperture() } else { 0.0 }
    }

    /// The vertex from which a line of sight of an orthographic camera starts: on its film. `None` for other cameras, whose own vertex
    /// `eye` it is.
    #[inline]
    pub fn start_on_film(&self, eye: &Vertex<R>, sight: &Sight) -> Option<Vertex<R>> {
        eye.is_on_film().then(|| self.on_film(sight.eye))
    }

    /// Makes `to` what [`Self::fly_to`] finds on a line of sight of the camera, whose vertex is `eye`; false if there is nothing.
    #[inline]
    pub fn trace_sight(
        &self,
        eye: &Vertex<R>,
        sight: &Sight,
        wavelength: Wavelength,
        to: &mut Vertex<R>,
        rng: &mut impl RandomSource,
    ) -> bool {
        if eye.is_on_film() {
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
        eye: &Vertex<R>,
        sight: &Sight,
        wavelength: Wavelength,
        to: &mut Vertex<R>,
        rng: &mut impl RandomSource,
    ) -> bool {
        if eye.is_on_film() {
            return self.trace_sight(eye, sight, wavelength, to, rng);
        }
        self.fly_or_escape(eye, sight.direction, wavelength, to, rng)
    }

    /// A point of the orthographic film as a vertex to trace from.
    pub(super) fn on_film(&self, position: DVec3) -> Vertex<R> {
        let medium = if self.has_media() { self.parts.media.around(&self.parts.world, position, None) } else { AIR };
        Vertex { position, medium, ..self.camera_vertex() }
    }

    /// The point of an orthographic film that sees a vertex.
    pub(super) fn film_point(&self, vertex: &Vertex<R>) -> DVec3 {
        vertex.position - self.camera.forward() * self.camera.depth(vertex.position)
    }

    /// Whether an orthographic camera sees a vertex that lies before its film.
    pub(super) fn seen_from_film(&self, vertex: &Vertex<R>) -> bool {
        self.parts.world.visible(&vertex.anchor(), &Anchor { position: self.film_point(vertex), normal: DVec3::ZERO })
    }
}
