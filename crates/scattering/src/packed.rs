//! Numbers and directions in few bytes, so that a surface with many effects is no larger than a common one.

use glam::DVec3;

use crate::Rgb;

/// A number in [0, 1] to 1/65535; both ends are exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Share(u16);

impl Share {
    /// The nearest one; what is outside [0, 1] or no number becomes the nearer end.
    #[inline]
    pub(crate) fn new(value: f64) -> Self {
        Self((value.clamp(0.0, 1.0) * f64::from(u16::MAX)).round() as u16)
    }

    /// The number.
    #[inline]
    pub(crate) fn get(self) -> f64 {
        f64::from(self.0) / f64::from(u16::MAX)
    }
}

/// Three shares.
#[inline]
pub(crate) fn shares(color: Rgb) -> [Share; 3] {
    color.to_array().map(Share::new)
}

/// The colour of three shares.
#[inline]
pub(crate) fn color(shares: [Share; 3]) -> Rgb {
    Rgb::from_array(shares.map(Share::get))
}

/// A unit vector as a point of the octahedron's unfolded square (Meyer et al. 2010, "On floating-point normal vectors").
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Direction([f32; 2]);

impl Direction {
    /// The nearest one to a unit vector.
    #[inline]
    pub(crate) fn new(w: DVec3) -> Self {
        let sum = w.x.abs() + w.y.abs() + w.z.abs();
        let (x, y) = (w.x / sum, w.y / sum);
        // The lower half is folded outwards over the square's edges.
        let (x, y) = if w.z < 0.0 { ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y)) } else { (x, y) };
        Self([x as f32, y as f32])
    }

    /// The unit vector.
    #[inline]
    pub(crate) fn get(self) -> DVec3 {
        let [x, y] = self.0.map(f64::from);
        let z = 1.0 - x.abs() - y.abs();
        let fold = (-z).max(0.0);
        DVec3::new(x - fold.copysign(x), y - fold.copysign(y), z).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_near_and_exact_at_both_ends() {
        assert_eq!((Share::new(0.0).get(), Share::new(1.0).get(), Share::new(7.0).get()), (0.0, 1.0, 1.0));
        for i in 0..1000 {
            let value = f64::from(i) / 999.0;
            assert!((Share::new(value).get() - value).abs() < 0.8e-5);
        }
    }

    #[test]
    fn directions_survive() {
        for i in 0..1000 {
            let z = 1.0 - f64::from(i) / 499.5;
            let (sin, cos) = (f64::from(i) * 2.4).sin_cos();
            let radius = (1.0 - z * z).max(0.0).sqrt();
            let w = DVec3::new(radius * cos, radius * sin, z).normalize();
            assert!((Direction::new(w).get() - w).length() < 3e-7, "{w}");
        }
        for w in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
            assert!((Direction::new(w).get() - w).length() < 1e-12);
        }
    }
}
