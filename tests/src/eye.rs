//! A camera that is placed by what it looks at.

use ergodic_pathspace::CameraDescription;
use glam::{DAffine3, DMat3, DVec2, DVec3};

/// A camera and what it looks at.
#[derive(Clone, Copy, Debug)]
pub struct Eye {
    /// Where it is.
    pub from: DVec3,
    /// A point in the middle of the picture.
    pub at: DVec3,
    /// What is up.
    pub up: DVec3,
    /// Full field of view, horizontal and vertical, in radians.
    pub fov: f64,
}

impl Eye {
    /// One that sees a square of the plane through `at`, 2 `half` wide and perpendicular to its view.
    pub fn over(from: DVec3, at: DVec3, up: DVec3, half: f64) -> Self {
        Self { from, at, up, fov: 2.0 * (half / from.distance(at)).atan() }
    }

    /// Right, up and backward.
    fn axes(&self) -> DMat3 {
        let z = (self.from - self.at).normalize();
        let x = self.up.cross(z).normalize();
        DMat3::from_cols(x, z.cross(x), z)
    }

    /// The point of the plane through `at`, perpendicular to the view, that is seen at `p` in shares of the picture.
    pub fn sees(&self, p: DVec2) -> DVec3 {
        let axes = self.axes();
        let width = 2.0 * (0.5 * self.fov).tan() * self.from.distance(self.at);
        self.at + (axes.x_axis * (p.x - 0.5) - axes.y_axis * (p.y - 0.5)) * width
    }

    /// As a scene's camera.
    pub fn description(&self) -> CameraDescription {
        let transform = DAffine3 { matrix3: self.axes(), translation: self.from };
        CameraDescription::pinhole(transform, self.fov)
    }
}
