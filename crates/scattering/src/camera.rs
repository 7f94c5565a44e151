//! The camera: raster positions, lines of sight, responsivity (Veach's W_e) and the densities between them.
//!
//! With x the last vertex before the camera and e the camera's own, the picture's mean is the integral of
//! L(x -> e) W_e G over both of them, where the camera's vertex is
//!
//! - of a pinhole, a Dirac: G = |cos| / d^2, without a cosine at the camera;
//! - of a thin lens, a point of the aperture, measured by area: G = |cos| |cos| / d^2 with the cosine at the lens, which stands
//!   across the axis. Each of its points sees a picture of its own, and all of them agree on the plane in focus;
//! - of an orthographic camera, a direction without position, as that of a distant light: W_e is per area of the film, and G is the
//!   cosine at x alone.
//!
//! W_e is scaled so that a uniform environment of radiance 1 has mean 1, whatever the aperture.

use std::marker::PhantomData;

use glam::{DAffine3, DVec2, DVec3};

use crate::{Everything, Lens, Repertoire};

/// A camera.
///
/// Raster coordinates are pixels: (0, 0) is the image's top left corner, x goes right and y down. The raster *domain* is
/// the image enlarged by a margin on every side, for filters that reach over the border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera<R: Repertoire = Everything> {
    /// The pinhole, the middle of the lens, or the middle of the orthographic film, before it is cropped.
    position: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Width and height of the image in pixels.
    size: DVec2,
    /// Width and height of the image on the plane at unit distance; of an orthographic one, on its film.
    extent: DVec2,
    /// Pixels per unit of length there.
    density: DVec2,
    /// W_e on the axis of a pinhole, the share of the image per area there.
    on_axis: f64,
    /// The middle of the image there, right and down of the axis.
    middle: DVec2,
    margin: f64,
    optics: Optics,
    repertoire: PhantomData<R>,
}

/// How a camera gathers light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Optics {
    /// A perspective view through one point.
    Pinhole,
    /// A perspective view through an aperture.
    Lens {
        /// The lens.
        lens: Lens,
        /// Area of its aperture.
        area: f64,
    },
    /// Parallel lines of sight.
    Orthographic,
}

/// A line of sight: from the camera's vertex to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// The pinhole, the point of the lens, or the point of the film; the last is not read.
    pub eye: DVec3,
    /// The point that is seen, which only an orthographic camera reads. NaN where it has no position.
    pub point: DVec3,
    /// Unit direction from the camera to the point.
    pub direction: DVec3,
}

impl Camera {
    /// A pinhole camera that looks along the local -z axis of `transform` with +y up (glTF 2.0, section 3.10), `vertical_fov` in
    /// radians over the image's height. Scale in `transform` is ignored.
    pub fn new(transform: DAffine3, vertical_fov: f64, width: u32, height: u32, margin: f64) -> Self {
        Self::over(transform, 2.0 * libm::tan(0.5 * vertical_fov), width, height, margin)
    }

    /// An orthographic camera whose image is `tall` high in the world. Its film goes through the origin of `transform`; what lies
    /// behind it is not seen.
    pub fn orthographic(transform: DAffine3, tall: f64, width: u32, height: u32, margin: f64) -> Self {
        Self { optics: Optics::Orthographic, ..Self::over(transform, tall, width, height, margin) }
    }

    fn over(transform: DAffine3, tall: f64, width: u32, height: u32, margin: f64) -> Self {
        let forward = (-transform.matrix3.z_axis).normalize_or(DVec3::NEG_Z);
        let up = transform.matrix3.y_axis;
        let right = forward.cross(up).normalize_or(forward.any_orthonormal_vector());
        let size = DVec2::new(f64::from(width), f64::from(height));
        let extent = DVec2::new(tall * size.x / size.y, tall);
        let (position, up) = (transform.translation, right.cross(forward));
        let (density, on_axis) = (DVec2::ZERO, 0.0);
        let camera = Self {
            position,
            right,
            up,
            forward,
            size,
            extent,
            density,
            on_axis,
            middle: DVec2::ZERO,
            margin,
            optics: Optics::Pinhole,
            repertoire: PhantomData,
        };
        camera.of_extent(size, extent)
    }

    /// The same camera with an image of this size in pixels and on the plane at unit distance.
    fn of_extent(self, size: DVec2, extent: DVec2) -> Self {
        Self { size, extent, density: size / extent, on_axis: 1.0 / (extent.x * extent.y), ..self }
    }

    /// The same pinhole camera with a lens.
    #[must_use]
    pub fn with_lens(self, lens: Lens) -> Self {
        Self { optics: Optics::Lens { lens, area: lens.area() }, ..self }
    }

    /// The camera of a window of the image, from the pixel corner `low` to the corner `high`. Its raster begins at `low`, and its
    /// picture is that part of the whole one; means over the image are means over the window.
    #[must_use]
    pub fn cropped(self, low: DVec2, high: DVec2) -> Self {
        let size = high - low;
        let extent = self.extent * size / self.size;
        let middle = self.middle + (0.5 * (low + high) / self.size - 0.5) * self.extent;
        Self { middle, ..self }.of_extent(size, extent)
    }

    /// The same camera in another repertoire, which must have its kind.
    #[must_use]
    pub fn within<R: Repertoire>(self) -> Camera<R> {
        let Self { position, right, up, forward, size, extent, density, on_axis, middle, margin, optics, .. } = self;
        let repertoire = PhantomData;
        Camera { position, right, up, forward, size, extent, density, on_axis, middle, margin, optics, repertoire }
    }
}

impl<R: Repertoire> Camera<R> {
    /// The pinhole, or the middle of the lens or of the film.
    #[inline]
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// Four points whose hull holds all points that lines of sight start at: of the lens, or of the film with its margin.
    pub fn reach(&self) -> [DVec3; 4] {
        let (middle, half) = match self.optics() {
            Optics::Pinhole => (DVec2::ZERO, DVec2::ZERO),
            Optics::Lens { lens, .. } => (DVec2::ZERO, DVec2::splat(lens.radius)),
            Optics::Orthographic => (self.middle, self.extent * (0.5 + self.margin / self.size)),
        };
        [DVec2::new(-1.0, -1.0), DVec2::new(1.0, -1.0), DVec2::new(-1.0, 1.0), DVec2::new(1.0, 1.0)].map(|corner| {
            let p = middle + half * corner;
            self.position + self.right * p.x - self.up * p.y
        })
    }

    /// The unit direction in which the camera looks.
    #[inline]
    pub fn forward(&self) -> DVec3 {
        self.forward
    }

    /// How it gathers light.
    #[inline]
    pub fn optics(&self) -> &Optics {
        if R::OTHER_CAMERAS { &self.optics } else { &Optics::Pinhole }
    }

    /// Width and height of the image in pixels.
    #[inline]
    pub fn size(&self) -> DVec2 {
        self.size
    }

    /// Pixels by which the raster domain is wider than the image on each side.
    #[inline]
    pub fn margin(&self) -> f64 {
        self.margin
    }

    /// Area of the image, without margin, in pixels^2.
    #[inline]
    pub fn image_area_pixels(&self) -> f64 {
        self.size.x * self.size.y
    }

    /// What a pixel in the middle of the image spans vertically at a distance from the camera, to first order.
    #[inline]
    pub fn length_per_pixel(&self, distance: f64) -> f64 {
        match *self.optics() {
            Optics::Pinhole | Optics::Lens { .. } => self.extent.y / self.size.y * distance,
            Optics::Orthographic => self.extent.y / self.size.y,
        }
    }

    /// Area of the raster domain in pixels^2.
    #[inline]
    pub fn domain_area(&self) -> f64 {
        let domain = self.size + 2.0 * self.margin;
        domain.x * domain.y
    }

    /// A position uniform over the raster domain.
    #[inline]
    pub fn sample_raster(&self, u: [f64; 2]) -> DVec2 {
        DVec2::from(u) * (self.size + 2.0 * self.margin) - self.margin
    }

    /// A position uniform over the aperture, of density [`Self::pdf_aperture`]; `None` for a camera without one, whose vertex is
    /// given.
    #[inline]
    pub fn sample_aperture(&self, u: [f64; 2]) -> Option<DVec3> {
        let Optics::Lens { lens, .. } = self.optics() else { return None };
        let offset = lens.sample(u);
        Some(self.position + self.right * offset.x + self.up * offset.y)
    }

    /// Density per area of a point of the aperture; 1, the Dirac divided out, if there is none.
    #[inline]
    pub fn pdf_aperture(&self) -> f64 {
        match *self.optics() {
            Optics::Lens { area, .. } => 1.0 / area,
            Optics::Pinhole | Optics::Orthographic => 1.0,
        }
    }

    /// Whether the camera's vertex can be sampled.
    #[inline]
    pub fn has_aperture(&self) -> bool {
        matches!(self.optics(), Optics::Lens { .. })
    }

    /// Where `eye`, a point of the lens, sees what a ray through the middle of the lens sees at the origin of the plane at unit
    /// distance: to the right and down.
    #[inline]
    fn parallax(&self, lens: &Lens, eye: DVec3) -> DVec2 {
        let offset = eye - self.position;
        DVec2::new(offset.dot(self.right), -offset.dot(self.up)) / lens.focus_distance
    }

    /// Where a raster position is on the plane at unit distance, or on the orthographic film.
    #[inline]
    fn plane(&self, raster: DVec2) -> DVec2 {
        (raster / self.size - 0.5) * self.extent + self.middle
    }

    /// The line of sight on which a raster position is seen from `eye`, the position of the camera's vertex, which of an
    /// orthographic camera is not read. Its point lies at unit distance.
    #[inline]
    pub fn sight(&self, eye: DVec3, raster: DVec2) -> Sight {
        let plane = self.plane(raster);
        let towards = |plane: DVec2| (self.right * plane.x - self.up * plane.y + self.forward).normalize();
        let (origin, direction) = match self.optics() {
            Optics::Pinhole => (eye, towards(plane)),
            Optics::Lens { lens, .. } => (eye, towards(plane - self.parallax(lens, eye))),
            Optics::Orthographic => (self.position + self.right * plane.x - self.up * plane.y, self.forward),
        };
        Sight { eye: origin, point: origin + direction, direction }
    }

    /// How far a point is before the camera, along its axis.
    #[inline]
    pub fn depth(&self, point: DVec3) -> f64 {
        (point - self.position).dot(self.forward)
    }

    /// The raster position at which a point is seen; `None` behind the camera or outside the raster domain.
    #[inline]
    pub fn raster(&self, sight: &Sight) -> Option<DVec2> {
        let plane = match self.optics() {
            Optics::Pinhole => self.perspective(sight.direction)?,
            Optics::Lens { lens, .. } => self.perspective(sight.direction)? + self.parallax(lens, sight.eye),
            Optics::Orthographic => {
                let offset = sight.point - self.position;
                let in_front = offset.dot(self.forward) > 0.0;
                in_front.then(|| DVec2::new(offset.dot(self.right), -offset.dot(self.up)))?
            }
        };
        let raster = (plane - self.middle) * self.density + 0.5 * self.size;
        self.in_domain(raster).then_some(raster)
    }

    /// Whether a raster position lies in the raster domain.
    #[inline]
    pub fn in_domain(&self, raster: DVec2) -> bool {
        raster.cmpge(DVec2::splat(-self.margin)).all() && raster.cmple(self.size + self.margin).all()
    }

    /// Where a direction meets the plane at unit distance; `None` if it points backward.
    #[inline]
    fn perspective(&self, direction: DVec3) -> Option<DVec2> {
        let depth = direction.dot(self.forward);
        if depth <= 0.0 {
            return None;
        }
        Some(DVec2::new(direction.dot(self.right), -direction.dot(self.up)) / depth)
    }

    /// The raster position at which a point is seen and the responsivity W_e there; `None` where [`Self::raster`] is.
    ///
    /// W_e is in 1/sr, of a lens per area of the aperture besides, of an orthographic camera per area of the film instead. 1/cos^3 of
    /// the angle with the axis is the ratio of area on the plane at unit distance to solid angle.
    #[inline]
    pub fn seen(&self, sight: &Sight) -> Option<(DVec2, f64)> {
        let raster = self.raster(sight)?;
        let cos = sight.direction.dot(self.forward);
        let responsivity = match *self.optics() {
            Optics::Pinhole => self.on_axis / (cos * cos * cos),
            Optics::Lens { area, .. } => self.on_axis / (cos * cos * cos) / (area * cos),
            Optics::Orthographic => self.on_axis,
        };
        Some((raster, responsivity))
    }

    /// W_e; 0 outside the raster domain. With it the measured light is the mean of the image.
    #[inline]
    pub fn responsivity(&self, sight: &Sight) -> f64 {
        self.seen(sight).map_or(0.0, |(_, responsivity)| responsivity)
    }

    /// What W_e of a lens lacks to the density of lines of sight from one of its points: the area of the aperture, and the cosine at
    /// the lens. `None` without an aperture.
    #[inline]
    pub fn aperture_factor(&self, direction: DVec3) -> Option<f64> {
        match *self.optics() {
            Optics::Lens { area, .. } => Some(area * direction.dot(self.forward)),
            Optics::Pinhole | Optics::Orthographic => None,
        }
    }

    /// |d raster area / d solid angle| in pixels^2/sr from the camera's vertex; of an orthographic camera pixels^2 per area of the
    /// film.
    #[inline]
    pub fn raster_per_measure(&self, sight: &Sight) -> f64 {
        self.raster_per_measure_at(self.responsivity(sight), sight.direction)
    }

    /// The same where W_e of the line of sight is known already.
    #[inline]
    pub fn raster_per_measure_at(&self, responsivity: f64, direction: DVec3) -> f64 {
        let per_measure = responsivity * (self.size.x * self.size.y);
        self.aperture_factor(direction).map_or(per_measure, |factor| per_measure * factor)
    }

    /// Density in 1/sr, or per area of an orthographic film, of a line of sight through [`Self::sample_raster`], given the camera's
    /// vertex.
    #[inline]
    pub fn pdf_sight(&self, sight: &Sight) -> f64 {
        self.pdf_sight_at(self.responsivity(sight), sight.direction)
    }

    /// The same where W_e of the line of sight is known already.
    #[inline]
    pub fn pdf_sight_at(&self, responsivity: f64, direction: DVec3) -> f64 {
        self.raster_per_measure_at(responsivity, direction) / self.domain_area()
    }

    /// What a line of sight so drawn from a vertex so drawn weighs: W_e times the cosine at a lens, over both densities.
    #[inline]
    pub fn weight(&self, sight: &Sight) -> f64 {
        let responsivity = self.responsivity(sight);
        let measured = self.aperture_factor(sight.direction).map_or(responsivity, |factor| responsivity * factor);
        measured / self.pdf_sight(sight)
    }
}
