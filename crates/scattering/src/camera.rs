//! The pinhole camera: raster positions, directions, responsivity (Veach's W_e) and the densities between them.

use glam::{DAffine3, DVec2, DVec3};

/// A perspective pinhole camera.
///
/// Raster coordinates are pixels: (0, 0) is the image's top left corner, x goes right and y down. The raster *domain* is
/// the image enlarged by a margin on every side, for filters that reach over the border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    position: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Width and height of the image in pixels.
    size: DVec2,
    /// Width and height of the image on the plane at unit distance.
    extent: DVec2,
    margin: f64,
}

impl Camera {
    /// A camera that looks along the local -z axis of `transform` with +y up (glTF 2.0, section 3.10), `vertical_fov` in
    /// radians over the image's height. Scale in `transform` is ignored.
    pub fn new(transform: DAffine3, vertical_fov: f64, width: u32, height: u32, margin: f64) -> Self {
        let forward = (-transform.matrix3.z_axis).normalize_or(DVec3::NEG_Z);
        let up = transform.matrix3.y_axis;
        let right = forward.cross(up).normalize_or(forward.any_orthonormal_vector());
        let size = DVec2::new(f64::from(width), f64::from(height));
        let tall = 2.0 * (0.5 * vertical_fov).tan();
        let extent = DVec2::new(tall * size.x / size.y, tall);
        Self { position: transform.translation, right, up: right.cross(forward), forward, size, extent, margin }
    }

    /// The pinhole.
    #[inline]
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// The unit direction in which the camera looks.
    #[inline]
    pub fn forward(&self) -> DVec3 {
        self.forward
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

    /// The angle that a pixel in the middle of the image spans vertically, in radians.
    #[inline]
    pub fn radians_per_pixel(&self) -> f64 {
        self.extent.y / self.size.y
    }

    /// Area of the raster domain in pixels^2.
    #[inline]
    pub fn domain_area(&self) -> f64 {
        let domain = self.size + 2.0 * self.margin;
        domain.x * domain.y
    }

    /// The unit direction from the pinhole through a raster position.
    #[inline]
    pub fn direction(&self, raster: DVec2) -> DVec3 {
        let plane = (raster / self.size - 0.5) * self.extent;
        (self.right * plane.x - self.up * plane.y + self.forward).normalize()
    }

    /// The raster position that sees `direction`; `None` behind the camera or outside the raster domain.
    #[inline]
    pub fn raster(&self, direction: DVec3) -> Option<DVec2> {
        let depth = direction.dot(self.forward);
        if depth <= 0.0 {
            return None;
        }
        let plane = DVec2::new(direction.dot(self.right), -direction.dot(self.up)) / depth;
        let raster = (plane / self.extent + 0.5) * self.size;
        let low = DVec2::splat(-self.margin);
        let high = self.size + self.margin;
        (raster.cmpge(low).all() && raster.cmple(high).all()).then_some(raster)
    }

    /// The raster position that sees `direction` and the responsivity W_e in 1/sr there; `None` where [`Self::raster`] is.
    ///
    /// 1/cos^3 of the angle with the axis is the ratio of area on the plane at unit distance to solid angle.
    #[inline]
    pub fn seen(&self, direction: DVec3) -> Option<(DVec2, f64)> {
        let raster = self.raster(direction)?;
        let cos = direction.dot(self.forward);
        Some((raster, 1.0 / (cos * cos * cos) / (self.extent.x * self.extent.y)))
    }

    /// W_e in 1/sr: with it the integral of incident radiance over directions is the mean of the image. A pinhole has no
    /// normal, so no cosine at the camera goes with it. 0 outside the raster domain.
    #[inline]
    pub fn responsivity(&self, direction: DVec3) -> f64 {
        self.seen(direction).map_or(0.0, |(_, responsivity)| responsivity)
    }

    /// |d raster area / d solid angle| in pixels^2/sr.
    #[inline]
    pub fn raster_per_solid_angle(&self, direction: DVec3) -> f64 {
        self.responsivity(direction) * (self.size.x * self.size.y)
    }

    /// Density in 1/sr of [`Self::sample`].
    #[inline]
    pub fn pdf_solid_angle(&self, direction: DVec3) -> f64 {
        self.raster_per_solid_angle(direction) / self.domain_area()
    }

    /// The direction of a raster position uniform over the raster domain.
    #[inline]
    pub fn sample(&self, u: [f64; 2]) -> DVec3 {
        self.direction(DVec2::from(u) * (self.size + 2.0 * self.margin) - self.margin)
    }
}
