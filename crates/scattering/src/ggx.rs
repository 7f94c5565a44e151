//! The GGX (Trowbridge-Reitz) distribution of microfacet normals with Smith's masking and shadowing, for isotropic and
//! anisotropic surfaces.
//!
//! Directions are local, on the side z > 0. Walter et al. 2007; Heitz 2014 (masking, anisotropy); Dupuy and Benyoub 2023
//! (sampling).

use std::f64::consts::FRAC_1_PI;

use ergodic_geometry::sin_cos_turns;
use glam::DVec3;

/// Surfaces with a smaller alpha are perfectly smooth: their specular lobes are Dirac. The lobe would be narrower than any
/// pixel sees, and the gain of drawing it by chance is nil.
pub const SMOOTH_ALPHA: f64 = 1e-3;

/// How rough a surface is: one alpha, or one along each axis of the local frame.
pub trait Roughness: Copy {
    /// Space stretched by the alphas along x and y, in which the surface is a hemisphere.
    fn stretch(self, w: DVec3) -> DVec3;

    /// D(h) in 1/sr. Written with x^2 + y^2 instead of 1 - z^2, which would cancel for small alpha.
    fn distribution(self, h: DVec3) -> f64;

    /// z (1 + 2 Lambda) of Smith's auxiliary function Lambda: the root sqrt(alpha^2 sin^2 + cos^2). It never vanishes with
    /// z, so the forms made from it are finite at grazing directions.
    fn root(self, w: DVec3) -> f64;

    /// The largest alpha.
    fn largest(self) -> f64;

    /// The least alpha.
    fn least(self) -> f64;
}

impl Roughness for f64 {
    #[inline]
    fn stretch(self, w: DVec3) -> DVec3 {
        DVec3::new(self * w.x, self * w.y, w.z)
    }

    #[inline]
    fn distribution(self, h: DVec3) -> f64 {
        let alpha2 = self * self;
        let spread = h.x * h.x + h.y * h.y + alpha2 * h.z * h.z;
        FRAC_1_PI * alpha2 / (spread * spread)
    }

    #[inline]
    fn root(self, w: DVec3) -> f64 {
        (self * self * (w.x * w.x + w.y * w.y) + w.z * w.z).sqrt()
    }

    #[inline]
    fn largest(self) -> f64 {
        self
    }

    #[inline]
    fn least(self) -> f64 {
        self
    }
}

/// Different alphas along local x and y (KHR_materials_anisotropy).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anisotropic {
    /// Alpha along x.
    pub x: f64,
    /// Alpha along y.
    pub y: f64,
}

impl Roughness for Anisotropic {
    #[inline]
    fn stretch(self, w: DVec3) -> DVec3 {
        DVec3::new(self.x * w.x, self.y * w.y, w.z)
    }

    #[inline]
    fn distribution(self, h: DVec3) -> f64 {
        let product = self.x * self.y;
        let spread = DVec3::new(self.y * h.x, self.x * h.y, product * h.z).length_squared();
        let ratio = product / spread;
        FRAC_1_PI * product * ratio * ratio
    }

    #[inline]
    fn root(self, w: DVec3) -> f64 {
        self.stretch(w).length()
    }

    #[inline]
    fn largest(self) -> f64 {
        self.x.max(self.y)
    }

    #[inline]
    fn least(self) -> f64 {
        self.x.min(self.y)
    }
}

/// G1(w) / |w.z|, with G1 = 2 / (1 + sqrt(1 + alpha^2 tan^2)).
#[inline]
pub(crate) fn masking_over_cosine(alpha: impl Roughness, w: DVec3) -> f64 {
    2.0 / (w.z.abs() + alpha.root(w))
}

/// G2(a, b) / (4 |a.z| |b.z|) for two directions on one side, masking and shadowing correlated by height
/// (Heitz 2014, eq. 99).
#[inline]
pub(crate) fn visibility(alpha: impl Roughness, a: DVec3, b: DVec3) -> f64 {
    0.5 / (a.z.abs() * alpha.root(b) + b.z.abs() * alpha.root(a))
}

/// Density in 1/sr of [`sample_visible`], divided by w·h: G1(w) D(h) / w.z.
#[inline]
pub(crate) fn visible_over_cosine(alpha: impl Roughness, w: DVec3, h: DVec3) -> f64 {
    masking_over_cosine(alpha, w) * alpha.distribution(h)
}

/// A microfacet normal as seen from `w`, with density G1(w) max(0, w·h) D(h) / w.z.
///
/// Stretching space by alpha turns the surface into hemispheres. Mirror directions of parallel rays off a sphere's visible
/// half are uniform over a spherical cap, z in (-w.z, 1]; the normal is half way between `w` and such a direction.
#[inline]
pub(crate) fn sample_visible(alpha: impl Roughness, w: DVec3, u: [f64; 2]) -> DVec3 {
    let w = alpha.stretch(w).normalize();
    // 1 + z and 1 - z of the cap's point, z = (1 - u)(1 + w.z) - w.z, without cancellation.
    let above = (1.0 - w.z) + (1.0 - u[0]) * (1.0 + w.z);
    let below = u[0] * (1.0 + w.z);
    let radius = (above * below).max(0.0).sqrt();
    let (sin, cos) = sin_cos_turns(u[1]);
    let half = DVec3::new(radius * cos + w.x, radius * sin + w.y, (1.0 - u[0]) * (1.0 + w.z));
    alpha.stretch(half).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// D through the slope, with nothing to cancel: tan^2 theta given.
    fn reference(alpha: f64, theta: f64) -> f64 {
        let (sin, cos) = theta.sin_cos();
        let tan2 = (sin / cos).powi(2);
        let a2 = alpha * alpha;
        FRAC_1_PI * a2 / (cos.powi(4) * (a2 + tan2).powi(2))
    }

    /// The textbook form, which cancels: the fault that the test must see.
    fn through_the_cosine(alpha: f64, h: DVec3) -> f64 {
        let a2 = alpha * alpha;
        let t = h.z * h.z * (a2 - 1.0) + 1.0;
        FRAC_1_PI * a2 / (t * t)
    }

    #[test]
    fn the_distribution_is_stable_for_small_alpha() {
        let (mut worst, mut worst_of_fault) = (0.0_f64, 0.0_f64);
        for exponent in 0..=10 {
            let alpha = 10.0_f64.powf(-0.5 * f64::from(exponent));
            for step in 0..=46 {
                let theta = alpha * 0.05 * 200.0_f64.powf(f64::from(step) / 46.0);
                if theta > 1.5 {
                    continue;
                }
                // Half vectors come from sums of directions that are unit only to rounding.
                let (sin, cos) = theta.sin_cos();
                let h = (DVec3::new(sin * 0.6, sin * 0.8, cos) * 1.7).normalize();
                let exact = reference(alpha, theta);
                worst = worst.max((alpha.distribution(h) / exact - 1.0).abs());
                worst_of_fault = worst_of_fault.max((through_the_cosine(alpha, h) / exact - 1.0).abs());
            }
        }
        assert!(worst < 1e-12, "{worst}");
        assert!(worst_of_fault > 1e-8, "{worst_of_fault}");
    }

    #[test]
    fn the_distribution_is_normalised() {
        // Integral of D cos over the hemisphere, in the variable tan theta = alpha x.
        for alpha in [1.0, 0.3, 1e-2, 1e-5] {
            let n = 200_000;
            let sum: f64 = (0..n)
                .map(|i| {
                    let s = (f64::from(i) + 0.5) / f64::from(n);
                    let (x, dx) = (s / (1.0 - s), 1.0 / ((1.0 - s) * (1.0 - s)));
                    let theta = (alpha * x).atan();
                    let (sin, cos) = theta.sin_cos();
                    let d = alpha.distribution(DVec3::new(sin, 0.0, cos));
                    TAU * d * cos * sin * (cos * cos * alpha * dx) / f64::from(n)
                })
                .sum();
            assert!((sum - 1.0).abs() < 1e-6, "{alpha}: {sum}");
        }
    }

    #[test]
    fn masking_takes_away_what_the_visible_normals_do_not_fill() {
        // The projected area of visible facets is the surface's: integral of G1(w) max(0, w.h) D(h) dh = w.z.
        for (alpha, cos) in [(1.0, 0.9), (0.5, 0.3), (0.2, 0.05)] {
            let w = DVec3::new(f64::sqrt(1.0 - cos * cos), 0.0, cos);
            let n = 2000;
            let mut sum = 0.0;
            for i in 0..n {
                let theta = (f64::from(i) + 0.5) / f64::from(n) * 0.5 * std::f64::consts::PI;
                let (sin, cos) = theta.sin_cos();
                for j in 0..400 {
                    let phi = (f64::from(j) + 0.5) / 400.0 * TAU;
                    let h = DVec3::new(sin * phi.cos(), sin * phi.sin(), cos);
                    sum += visible_over_cosine(alpha, w, h) * w.dot(h).max(0.0) * sin;
                }
            }
            let integral = sum * 0.5 * std::f64::consts::PI / f64::from(n) * TAU / 400.0;
            assert!((integral - 1.0).abs() < 1e-4, "{alpha} {cos}: {integral}");
        }
    }

    #[test]
    fn equal_alphas_make_the_isotropic_distribution() {
        let w = DVec3::new(0.48, -0.36, 0.8);
        for alpha in [1.0, 0.2, 1e-3] {
            let both = Anisotropic { x: alpha, y: alpha };
            assert!((both.distribution(w) / alpha.distribution(w) - 1.0).abs() < 1e-12);
            assert!((both.root(w) / alpha.root(w) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_anisotropic_distribution_is_normalised_and_longer_along_its_rougher_axis() {
        let surface = Anisotropic { x: 0.6, y: 0.15 };
        let n = 1000;
        let mut sum = 0.0;
        for i in 0..n {
            // In the slopes' plane, stretched to the unit circle: r = s / (1 - s).
            let s = (f64::from(i) + 0.5) / f64::from(n);
            let (r, dr) = (s / (1.0 - s), 1.0 / ((1.0 - s) * (1.0 - s)));
            for j in 0..200 {
                let (sin, cos) = ((f64::from(j) + 0.5) / 200.0 * TAU).sin_cos();
                let h = DVec3::new(surface.x * r * cos, surface.y * r * sin, 1.0).normalize();
                // D cos dw = D cos^4 d(slopes).
                sum += surface.distribution(h) * h.z.powi(4) * surface.x * surface.y * r * dr;
            }
        }
        let integral = sum * TAU / (f64::from(n) * 200.0);
        assert!((integral - 1.0).abs() < 1e-4, "{integral}");
        let tilted = |x: f64, y: f64| surface.distribution(DVec3::new(x, y, 0.8));
        assert!(tilted(0.6, 0.0) > 10.0 * tilted(0.0, 0.6));
    }
}
