//! The watertight ray-triangle test of Woop, Benthin and Wald (2013, JCGT 2(1)), in `f64`.

use glam::DVec3;

use crate::epsilon::DEGENERATE_SINE;
use crate::phase::{self, Phase};

/// Vertices, in the space of the mesh or the world.
pub(crate) type Triangle = [DVec3; 3];

/// A ray made ready for the test: translated to the origin and sheared so that it runs along axis `Z`, the largest
/// component of its direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shear {
    /// In the order of `axes`.
    pub(crate) origin: [f64; 3],
    /// The axes X, Y and Z of the sheared space.
    pub(crate) axes: [usize; 3],
    /// What is taken off X and Y for each unit of Z.
    pub(crate) slope: [f64; 2],
    /// The ray's parameter for each unit of Z.
    pub(crate) per_z: f64,
}

/// Where a ray meets a triangle: parameter and the barycentrics of vertices 1 and 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    pub t: f64,
    pub u: f64,
    pub v: f64,
}

/// The axes X, Y and Z of the sheared space by the axis that becomes Z. Not a constant, which would be written to the stack for
/// each ray, number by number, and read back two at a time, which processors wait for.
static AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// The axis of the largest component.
#[inline]
fn major_axis(direction: DVec3) -> usize {
    let a = direction.abs();
    if a.x > a.y && a.x > a.z {
        0
    } else if a.y > a.z {
        1
    } else {
        2
    }
}

impl Shear {
    #[inline]
    pub(crate) fn new(origin: DVec3, direction: DVec3) -> Self {
        let axes = AXES[major_axis(direction)];
        let [d, o] = [direction.to_array(), origin.to_array()];
        let [dx, dy, dz] = axes.map(|axis| d[axis]);
        let per_z = 1.0 / dz;
        Self { origin: axes.map(|axis| o[axis]), axes, slope: [dx * per_z, dy * per_z], per_z }
    }

    /// A vertex in the sheared space. It depends on the ray and the vertex alone, so all triangles around the vertex see
    /// the same point.
    #[inline(always)]
    fn vertex(&self, vertex: DVec3) -> [f64; 3] {
        let p = vertex.to_array();
        let [x, y, z] = [0, 1, 2].map(|i| p[self.axes[i]] - self.origin[i]);
        [x - self.slope[0] * z, y - self.slope[1] * z, z]
    }

    /// The crossing with 0 < t <= `t_max`. Both sides count.
    ///
    /// Rounding a product is monotone, so the sign of a difference of two products is right or zero, and where it is
    /// zero it is recomputed exactly: the signs are those of the exact edge functions of the sheared vertices, and
    /// two triangles that share an edge see opposite ones.
    #[inline(always)]
    pub(crate) fn cross(&self, triangle: &Triangle, t_max: f64) -> Option<Crossing> {
        let _phase = phase::enter(Phase::Intersection);
        let [ax, ay, az] = self.vertex(triangle[0]);
        let [bx, by, bz] = self.vertex(triangle[1]);
        let [cx, cy, cz] = self.vertex(triangle[2]);
        let mut wa = cx * by - cy * bx;
        let mut wb = ax * cy - ay * cx;
        let mut wc = bx * ay - by * ax;
        if wa == 0.0 || wb == 0.0 || wc == 0.0 {
            wa = difference_of_products(cx, by, cy, bx);
            wb = difference_of_products(ax, cy, ay, cx);
            wc = difference_of_products(bx, ay, by, ax);
        }
        if (wa < 0.0 || wb < 0.0 || wc < 0.0) && (wa > 0.0 || wb > 0.0 || wc > 0.0) {
            return None;
        }
        let determinant = wa + wb + wc;
        if determinant == 0.0 {
            return None;
        }
        let inverse = 1.0 / determinant;
        let t = (wa * az + wb * bz + wc * cz) * self.per_z * inverse;
        if t > 0.0 && t <= t_max { Some(Crossing { t, u: wb * inverse, v: wc * inverse }) } else { None }
    }
}

/// `a b - c d` with the sign it has in exact arithmetic (Kahan's difference of products, both remainders kept).
#[cold]
fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let cd = c * d;
    let remainder = (-c).mul_add(d, cd);
    a.mul_add(b, -cd) + remainder
}

/// Whether rounding leaves the triangle no direction: a side or the height is zero, or a vertex is NaN.
pub(crate) fn is_degenerate([a, b, c]: &Triangle) -> bool {
    let (ab, ac) = (*b - *a, *c - *a);
    let longest = ab.abs().max(ac.abs()).max_element();
    let sine = (ab / longest).cross(ac / longest).length();
    sine.is_nan() || sine <= DEGENERATE_SINE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn difference_of_products_keeps_the_exact_sign() {
        // (1 + e)(1 - e) = 1 - e² rounds to 1: the plain difference is zero.
        let e = f64::EPSILON;
        assert_eq!((1.0 + e) * (1.0 - e) - 1.0, 0.0);
        assert_eq!(difference_of_products(1.0 + e, 1.0 - e, 1.0, 1.0), -e * e);
        assert_eq!(difference_of_products(1.0, 1.0, 1.0 + e, 1.0 - e), e * e);
    }

    #[test]
    fn crossing_has_the_barycentrics_of_the_point() {
        let triangle = [DVec3::new(1.0, 0.0, 0.2), DVec3::new(0.0, 2.0, -0.3), DVec3::new(-1.0, -1.0, 0.7)];
        let (u, v) = (0.3, 0.2);
        let target = triangle[0] * (1.0 - u - v) + triangle[1] * u + triangle[2] * v;
        let origin = DVec3::new(0.4, -0.3, 5.0);
        let direction = (target - origin).normalize();
        let crossing = Shear::new(origin, direction).cross(&triangle, f64::INFINITY).unwrap();
        assert!((crossing.u - u).abs() < 1e-14 && (crossing.v - v).abs() < 1e-14);
        assert!((crossing.t - origin.distance(target)).abs() < 1e-14);
        assert!(Shear::new(origin, -direction).cross(&triangle, f64::INFINITY).is_none());
        assert!(Shear::new(origin, direction).cross(&triangle, 0.9 * crossing.t).is_none());
    }

    #[test]
    fn degenerate_triangles_are_recognised_at_any_scale() {
        let good = [DVec3::ZERO, DVec3::X, DVec3::new(0.5, 1e-6, 0.0)];
        let line = [DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.5, 1.0, 1.5)];
        for scale in [1e-60, 1.0, 1e60] {
            assert!(!is_degenerate(&good.map(|p| p * scale)));
            assert!(is_degenerate(&line.map(|p| p * scale)));
        }
        assert!(is_degenerate(&[DVec3::X; 3]));
        assert!(is_degenerate(&[DVec3::X, DVec3::Y, DVec3::NAN]));
    }
}
