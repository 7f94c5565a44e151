//! KHR_materials_sheen: fibres that stand on a surface, seen at grazing angles ("Charlie", Estevez and Kulla 2017).
//!
//! With the extension's distribution D and visibility V the lobe is color D V. Two things keep it from making energy:
//!
//! - Below the cosine [`LEAST_COSINE`] the fitted visibility grows without bound; there it stays as it is at that cosine.
//! - At grazing directions the albedo R of a lobe of small roughness exceeds 1. It is divided by max(1, R(light), R(eye)),
//!   which is the same both ways and leaves at most min(1, R).
//!
//! Local directions, z > 0.

use std::f64::consts::{FRAC_1_PI, PI};
use std::sync::LazyLock;

use glam::DVec3;

use crate::albedo_table::AlbedoTable;
use crate::{Rgb, SELECTION_FLOOR, luminance, warp};

/// Least roughness: a smaller one makes a distribution that only exactly grazing directions see, and none at 0.
const LEAST_ROUGHNESS: f64 = 0.07;

/// Cosines below this count as this much for the visibility.
const LEAST_COSINE: f64 = 1e-3;

/// What the table's albedos are multiplied by: its interpolation errs by less.
const MARGIN: f64 = 1.01;

/// Density in 1/sr of [`sample`].
pub(crate) const PDF: f64 = 0.5 * FRAC_1_PI;

/// The albedo R of the lobe D V with color 1.
static ALBEDO: LazyLock<AlbedoTable<1>> =
    LazyLock::new(|| AlbedoTable::new(LEAST_ROUGHNESS, |cos, roughness| [raw_albedo(cos, roughness, 64)]));

/// R by the midpoint rule over the square root of the other cosine and over the azimuth.
fn raw_albedo(cos: f64, roughness: f64, steps: u32) -> f64 {
    let eye = DVec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
    let sectors = steps / 4;
    let mut sum = 0.0;
    for i in 0..steps {
        let root = (f64::from(i) + 0.5) / f64::from(steps);
        let z = root * root;
        let radius = (1.0 - z * z).sqrt();
        let visibility = visibility(roughness * roughness, eye.z, z);
        let ring: f64 = (0..sectors)
            .map(|j| {
                // The other half of the circle is its mirror image.
                let (sin, cos) = libm::sincos((f64::from(j) + 0.5) / f64::from(sectors) * PI);
                distribution(roughness * roughness, eye + DVec3::new(radius * cos, radius * sin, z))
            })
            .sum();
        // dw = 2 root droot dphi.
        sum += ring * visibility * z * 2.0 * root;
    }
    sum * 2.0 * PI / (f64::from(sectors) * f64::from(steps))
}

/// D for the half vector along `sum`, which need not be a unit vector.
#[inline]
fn distribution(alpha: f64, sum: DVec3) -> f64 {
    let sin2 = (sum.x * sum.x + sum.y * sum.y) / sum.length_squared();
    let exponent = 1.0 / alpha;
    (2.0 + exponent) * libm::exp(0.5 * exponent * libm::log(sin2)) * (0.5 * FRAC_1_PI)
}

/// Smith's Lambda of the fibres: a curve fitted by Estevez and Kulla.
#[inline]
fn lambda(alpha: f64, cos: f64) -> f64 {
    let t = (1.0 - alpha) * (1.0 - alpha);
    let mix = |rough: f64, smooth: f64| rough + (smooth - rough) * t;
    let (a, b) = (mix(21.5473, 25.3245), mix(3.82987, 3.32435));
    let (c, d, e) = (mix(0.19823, 0.16801), mix(-1.97760, -1.27393), mix(-4.32054, -4.85967));
    let curve = |x: f64| a / (1.0 + b * libm::pow(x, c)) + d * x + e;
    if cos < 0.5 { libm::exp(curve(cos)) } else { libm::exp(2.0 * curve(0.5) - curve((1.0 - cos).max(0.0))) }
}

/// V = G / (4 cos cos).
#[inline]
fn visibility(alpha: f64, a: f64, b: f64) -> f64 {
    let (a, b) = (a.max(LEAST_COSINE), b.max(LEAST_COSINE));
    1.0 / ((1.0 + lambda(alpha, a) + lambda(alpha, b)) * (4.0 * a * b))
}

/// A sheen at one point; black for none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sheen {
    color: Rgb,
    roughness: f64,
}

impl Sheen {
    /// With sheenColor and sheenRoughness.
    #[inline]
    pub(crate) fn new(color: Rgb, roughness: f64) -> Self {
        Self { color, roughness: roughness.max(LEAST_ROUGHNESS) }
    }

    /// Whether there is one.
    #[inline]
    pub(crate) fn is_present(&self) -> bool {
        self.color != Rgb::ZERO
    }

    /// The albedo R of the lobe with color 1 at cosine `cos`.
    #[inline]
    fn raw(&self, cos: f64) -> f64 {
        MARGIN * ALBEDO.at(cos, self.roughness)[0]
    }

    /// The scattering function in 1/sr, and the share of the light that reaches what is below: 1 - max(color) E, with the
    /// larger E of both directions, as the extension has it.
    #[inline]
    pub(crate) fn value(&self, light: DVec3, eye: DVec3) -> (Rgb, f64) {
        let alpha = self.roughness * self.roughness;
        let albedo = self.raw(light.z).max(self.raw(eye.z));
        let lobe = distribution(alpha, light + eye) * visibility(alpha, light.z, eye.z) / albedo.max(1.0);
        (self.color * lobe, 1.0 - self.color.max_element() * albedo.min(1.0))
    }

    /// The share of light at cosine `cos` that the sheen takes from what is below.
    #[inline]
    pub(crate) fn shadow(&self, cos: f64) -> f64 {
        self.color.max_element() * self.raw(cos).min(1.0)
    }

    /// The weight of choosing the lobe for a direction at cosine `cos`.
    #[inline]
    pub(crate) fn weight(&self, cos: f64) -> f64 {
        luminance(self.color) * self.raw(cos).clamp(SELECTION_FLOOR, 1.0)
    }
}

/// A direction uniform over the hemisphere: the lobe is wide, and brightest where a cosine would draw least.
#[inline]
pub(crate) fn sample(u: [f64; 2]) -> DVec3 {
    warp::uniform_cone(u, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_the_integral_to_within_its_margin() {
        let mut worst = 0.0_f64;
        for i in 0..40 {
            for roughness in [0.0701, 0.0723, 0.08, 0.1, 0.137, 0.2, 0.31, 0.5, 0.77, 1.0] {
                let cos = ((f64::from(i) + 0.31) / 40.0).powi(2);
                let exact = raw_albedo(cos, roughness, 400);
                let table = ALBEDO.at(cos, roughness)[0];
                // Where it is small only its size matters.
                let error = (table - exact).abs() / exact.max(0.5);
                assert!(error < MARGIN - 1.0, "{cos} {roughness}: {table} {exact}");
                worst = worst.max(error);
            }
        }
        // The margin is no larger than it has to be.
        assert!(worst > 0.2 * (MARGIN - 1.0), "{worst}");
    }

    #[test]
    fn the_extensions_formulas_gain_energy_and_these_do_not() {
        // What the module says of the raw lobe.
        assert!(raw_albedo(2e-3, 0.07, 400) > 2.0);
        let exact = |cos: f64| raw_albedo(cos, 0.07, 400);
        let sheen = Sheen::new(Rgb::ONE, 0.07);
        for cos in [1e-5, 1e-3, 0.01, 0.1] {
            assert!(exact(cos) / sheen.raw(cos).max(1.0) <= 1.0 + 1e-3, "{cos}");
        }
    }

    #[test]
    fn single_values_are_those_of_the_extension() {
        // By hand from its code, with alpha = 1: 3 sin / (2 pi), and l(0.5) with the first constants.
        let half = DVec3::new(0.6, 0.0, 0.8);
        assert!((distribution(1.0, half) - 3.0 * 0.6 / (2.0 * PI)).abs() < 1e-12);
        let l = 21.5473 / (1.0 + 3.82987 * 0.5_f64.powf(0.19823)) - 1.97760 * 0.5 - 4.32054;
        assert!((lambda(1.0, 0.5 - 1e-12) - l.exp()).abs() < 1e-9);
        assert!((lambda(1.0, 0.5) - l.exp()).abs() < 1e-9);
        let sheen = Sheen::new(Rgb::new(0.5, 0.25, 0.0), 1.0);
        let (light, eye) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(-0.6, 0.0, 0.8));
        assert_eq!(sheen.value(light, eye).0, Rgb::ZERO);
    }
}
