//! The hot functions, once for each kind of number: the same text compiled for `f64` and for `f32`.

/// The sign of `a b - c d` as it is in exact arithmetic.
pub trait Exact: Copy {
    fn difference_of_products(a: Self, b: Self, c: Self, d: Self) -> Self;
}

impl Exact for f64 {
    fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
        let cd = c * d;
        let remainder = (-c).mul_add(d, cd);
        a.mul_add(b, -cd) + remainder
    }
}

impl Exact for f32 {
    // Products of two numbers of 24 bits are exact in 53.
    fn difference_of_products(a: f32, b: f32, c: f32, d: f32) -> f32 {
        (f64::from(a) * f64::from(b) - f64::from(c) * f64::from(d)) as f32
    }
}

macro_rules! kernels {
    ($name:ident, $real:ident, $vector:ident) => {
        /// With numbers of one kind.
        pub mod $name {
            use std::$real::consts::{FRAC_1_PI, TAU};

            pub use glam::$vector as V;

            use super::Exact;

            pub type R = $real;

            /// From the numbers of the inputs.
            pub fn number(value: f64) -> R {
                value as R
            }

            pub fn vector(value: glam::DVec3) -> V {
                V::new(value.x as R, value.y as R, value.z as R)
            }

            /// Where a ray meets a triangle, after Möller and Trumbore (1997).
            #[inline]
            pub fn plain(origin: V, direction: V, [a, b, c]: &[V; 3]) -> Option<R> {
                let (ab, ac) = (*b - *a, *c - *a);
                let p = direction.cross(ac);
                let determinant = ab.dot(p);
                if determinant == 0.0 {
                    return None;
                }
                let inverse = 1.0 / determinant;
                let from = origin - *a;
                let u = from.dot(p) * inverse;
                if !(0.0..=1.0).contains(&u) {
                    return None;
                }
                let q = from.cross(ab);
                let v = direction.dot(q) * inverse;
                if v < 0.0 || u + v > 1.0 {
                    return None;
                }
                let t = ac.dot(q) * inverse;
                (t > 0.0).then_some(t)
            }

            /// A ray made ready for the watertight test.
            #[derive(Clone, Copy)]
            pub struct Sheared {
                origin: [R; 3],
                axes: [usize; 3],
                slope: [R; 2],
                per_z: R,
            }

            impl Sheared {
                #[inline]
                pub fn new(origin: V, direction: V) -> Self {
                    let a = direction.abs();
                    let axes = if a.x > a.y && a.x > a.z {
                        [1, 2, 0]
                    } else if a.y > a.z {
                        [2, 0, 1]
                    } else {
                        [0, 1, 2]
                    };
                    let (d, o) = (direction.to_array(), origin.to_array());
                    let per_z = 1.0 / d[axes[2]];
                    let slope = [d[axes[0]] * per_z, d[axes[1]] * per_z];
                    Self { origin: axes.map(|axis| o[axis]), axes, slope, per_z }
                }

                #[inline]
                fn vertex(&self, vertex: V) -> [R; 3] {
                    let p = vertex.to_array();
                    let [x, y, z] = [0, 1, 2].map(|i| p[self.axes[i]] - self.origin[i]);
                    [x - self.slope[0] * z, y - self.slope[1] * z, z]
                }

                /// Where it meets a triangle, after Woop, Benthin and Wald (2013).
                #[inline]
                pub fn cross(&self, [a, b, c]: &[V; 3]) -> Option<R> {
                    let ([ax, ay, az], [bx, by, bz], [cx, cy, cz]) =
                        (self.vertex(*a), self.vertex(*b), self.vertex(*c));
                    let mut wa = cx * by - cy * bx;
                    let mut wb = ax * cy - ay * cx;
                    let mut wc = bx * ay - by * ax;
                    if wa == 0.0 || wb == 0.0 || wc == 0.0 {
                        wa = R::difference_of_products(cx, by, cy, bx);
                        wb = R::difference_of_products(ax, cy, ay, cx);
                        wc = R::difference_of_products(bx, ay, by, ax);
                    }
                    if (wa < 0.0 || wb < 0.0 || wc < 0.0) && (wa > 0.0 || wb > 0.0 || wc > 0.0) {
                        return None;
                    }
                    let determinant = wa + wb + wc;
                    if determinant == 0.0 {
                        return None;
                    }
                    let t = (wa * az + wb * bz + wc * cz) * self.per_z / determinant;
                    (t > 0.0).then_some(t)
                }
            }

            /// The geometry term of an edge without its visibility: cos cos / d².
            #[inline]
            pub fn geometry_term(x: V, normal_x: V, y: V, normal_y: V) -> R {
                let d = y - x;
                let squared = d.length_squared();
                normal_x.dot(d).abs() * normal_y.dot(d).abs() / (squared * squared)
            }

            /// A direction from the frame of a normal (Duff et al. 2017) to the world.
            #[inline]
            pub fn to_world(normal: V, local: V) -> V {
                let sign = R::copysign(1.0, normal.z);
                let a = -1.0 / (sign + normal.z);
                let b = normal.x * normal.y * a;
                let x = V::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x);
                let y = V::new(b, sign + normal.y * normal.y * a, -normal.y);
                x * local.x + y * local.y + normal * local.z
            }

            /// GGX's D(h) in 1/sr (Walter et al. 2007).
            #[inline]
            fn distribution(alpha: R, h: V) -> R {
                let alpha2 = alpha * alpha;
                let spread = h.x * h.x + h.y * h.y + alpha2 * h.z * h.z;
                FRAC_1_PI * alpha2 / (spread * spread)
            }

            #[inline]
            fn root(alpha: R, w: V) -> R {
                (alpha * alpha * (w.x * w.x + w.y * w.y) + w.z * w.z).sqrt()
            }

            /// GGX's f_s for reflection without Fresnel's factor: D G / (4 cos cos).
            #[inline]
            pub fn ggx_eval(alpha: R, wi: V, wo: V) -> R {
                let h = (wi + wo).normalize();
                0.5 * distribution(alpha, h) / (wi.z * root(alpha, wo) + wo.z * root(alpha, wi))
            }

            /// The density of `wo` in 1/sr where the half vector is drawn from those visible from `wi` (Heitz 2018).
            #[inline]
            pub fn ggx_pdf(alpha: R, wi: V, wo: V) -> R {
                let h = (wi + wo).normalize();
                0.5 * distribution(alpha, h) / (wi.z + root(alpha, wi))
            }

            /// A direction drawn with that density, by spherical caps (Dupuy and Benyoub 2023).
            #[inline]
            pub fn ggx_sample(alpha: R, wi: V, [u1, u2]: [R; 2]) -> V {
                let stretched = V::new(alpha * wi.x, alpha * wi.y, wi.z).normalize();
                let z = 1.0 - u1 * (1.0 + stretched.z);
                let radius = (1.0 - z * z).max(0.0).sqrt();
                let (sin, cos) = (TAU * u2).sin_cos();
                let cap = V::new(radius * cos, radius * sin, z) + stretched;
                let h = V::new(alpha * cap.x, alpha * cap.y, cap.z).normalize();
                h * (2.0 * wi.dot(h)) - wi
            }
        }
    };
}

kernels!(double, f64, DVec3);
kernels!(single, f32, Vec3);
