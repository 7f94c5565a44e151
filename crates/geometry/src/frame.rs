//! Right-handed orthonormal frames around a normal.

use glam::DVec3;

/// A right-handed orthonormal frame: `t × b = n`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Tangent, local x.
    pub t: DVec3,
    /// Bitangent, local y.
    pub b: DVec3,
    /// Normal, local z.
    pub n: DVec3,
}

impl Frame {
    /// The frame around a unit normal whose tangent is chosen without branches (Duff et al. 2017, "Building an
    /// Orthonormal Basis, Revisited", JCGT 6(1)).
    #[inline]
    pub fn from_normal(n: DVec3) -> Self {
        let sign = 1f64.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Self {
            t: DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            b: DVec3::new(b, sign + n.y * n.y * a, -n.y),
            n,
        }
    }

    /// The frame around a unit normal whose tangent is `tangent` made orthogonal to it (Gram-Schmidt); the frame of
    /// [`Frame::from_normal`] where the tangent is zero, parallel to the normal or not finite.
    #[inline]
    pub fn from_normal_tangent(n: DVec3, tangent: DVec3) -> Self {
        let across = tangent - n * n.dot(tangent);
        let length = across.length();
        // What Gram-Schmidt leaves of a nearly parallel tangent is rounding noise. A NaN fails the comparison too.
        if length > 1e-9 * tangent.length() && length < f64::INFINITY {
            // A second pass removes what cancellation left along n.
            let across = across / length;
            let t = (across - n * n.dot(across)).normalize();
            Self { t, b: n.cross(t), n }
        } else {
            Self::from_normal(n)
        }
    }

    /// Coordinates of a world-space vector in this frame.
    #[inline]
    pub fn to_local(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.t), v.dot(self.b), v.dot(self.n))
    }

    /// The world-space vector with these coordinates in this frame.
    #[inline]
    pub fn to_world(&self, v: DVec3) -> DVec3 {
        self.t * v.x + self.b * v.y + self.n * v.z
    }
}
