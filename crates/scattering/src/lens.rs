//! The aperture of a thin lens: a disk or a regular polygon, sampled uniformly.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use crate::warp;

/// More blades than this are as good as a disk.
const MOST_BLADES: u32 = 64;

/// A thin lens. Lengths are in the units of the scene that it looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Radius of the aperture; of a polygon, that of the circle through its corners.
    pub radius: f64,
    /// Distance along the axis of the plane that is seen sharp.
    pub focus_distance: f64,
    /// Number of blades, which are the sides of the aperture; below 3 it is a disk.
    pub blades: u32,
    /// Angle of the polygon's first corner in radians, from right towards up as the camera sees it.
    pub rotation: f64,
}

impl Lens {
    /// Checks the values; a radius of 0 stands for a pinhole.
    ///
    /// # Errors
    ///
    /// The field that is wrong, and a sentence on what it is and what is allowed.
    pub fn check(&self) -> Result<(), (&'static str, String)> {
        if !(self.radius >= 0.0 && self.radius.is_finite()) {
            return Err(("radius", format!("is {}; it must be 0, for a pinhole, or greater", self.radius)));
        }
        if !(self.focus_distance > 0.0 && self.focus_distance.is_finite()) {
            return Err(("focus_distance", format!("is {}; it must be greater than 0", self.focus_distance)));
        }
        if matches!(self.blades, 1 | 2) || self.blades > MOST_BLADES {
            let problem = format!("is {}; it must be 0, for a disk, or from 3 to {MOST_BLADES}", self.blades);
            return Err(("blades", problem));
        }
        if !self.rotation.is_finite() {
            return Err(("rotation", format!("is {}; it must be an angle in radians", self.rotation)));
        }
        Ok(())
    }

    /// Area of the aperture.
    pub fn area(&self) -> f64 {
        let unit = match self.sides() {
            None => PI,
            Some(sides) => 0.5 * sides * libm::sin(TAU / sides),
        };
        unit * self.radius * self.radius
    }

    /// Sides of the aperture if it is a polygon.
    #[inline]
    fn sides(&self) -> Option<f64> {
        (self.blades >= 3).then_some(f64::from(self.blades))
    }

    /// A point uniform over the aperture, its coordinates right and up from the middle. The density is 1 / [`Self::area`].
    #[inline]
    pub fn sample(&self, u: [f64; 2]) -> DVec2 {
        let point = match self.sides() {
            None => warp::concentric_disk(u),
            Some(sides) => {
                // All triangles between the middle and a side are alike.
                let side = (u[0] * sides).floor().min(sides - 1.0);
                let (a, b) = warp::uniform_triangle([u[0] * sides - side, u[1]]);
                let corner = |i: f64| {
                    let (sin, cos) = libm::sincos(self.rotation + TAU * i / sides);
                    DVec2::new(cos, sin)
                };
                corner(side) * a + corner(side + 1.0) * b
            }
        };
        point * self.radius
    }
}
