//! Reflectance of a thin film: interference between the light that its two faces reflect (Belcour and Barla 2017), in the
//! form that KHR_materials_iridescence gives it.
//!
//! Polarisation is left out, both faces reflect by Schlick's form, and the spectrum is integrated in Fourier space: the
//! sensitivities of the eye are sums of Gaussians in the wave number, whose transforms are known. Names of the steps are
//! those of the extension's text.

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

use glam::DVec3;

use crate::Rgb;
use crate::color::XYZ_TO_RGB;
use crate::fresnel::schlick_weight;

/// A thin film at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ThinFilm {
    /// iridescenceFactor: how much of the film there is; 0 for none.
    pub strength: f64,
    /// iridescenceIor.
    pub ior: f64,
    /// Thickness in nanometres.
    pub thickness: f64,
}

/// Added to the base's reflectance before an index is made of it, and its largest value then.
const GUARD: f64 = 1e-4;

/// What the sensitivities' magnitudes are divided by.
const NORMALIZATION: f64 = 1.0685e-7;

/// A Gaussian of wave number, as its Fourier transform needs it.
struct Gaussian {
    /// Height times sqrt(2 pi variance), normalised.
    weight: f64,
    /// Centre in 1/m.
    centre: f64,
    /// Variance in 1/m^2.
    variance: f64,
}

/// Of X, Y and Z, and the second peak of X.
static SENSITIVITIES: LazyLock<[Gaussian; 4]> = LazyLock::new(|| {
    [
        (5.4856e-13, 1.6810e6, 4.3278e9),
        (4.4201e-13, 1.7953e6, 9.3046e9),
        (5.2481e-13, 2.2084e6, 6.6121e9),
        (9.7470e-14, 2.2399e6, 4.5282e9),
    ]
    .map(|(height, centre, variance): (f64, f64, f64)| Gaussian {
        weight: height * (TAU * variance).sqrt() / NORMALIZATION,
        centre,
        variance,
    })
});

/// Reflectance at normal incidence between two indices.
#[inline]
fn normal_reflectance(n_to: Rgb, n_from: f64) -> Rgb {
    let r = (n_to - n_from) / (n_to + n_from);
    r * r
}

#[inline]
fn schlick(f0: Rgb, cos: f64) -> Rgb {
    f0.lerp(Rgb::ONE, schlick_weight(cos))
}

/// The sensitivities' transform for an optical path difference in nanometres and a shift of the phase for each channel.
#[inline]
fn sensitivity(path: f64, shift: Rgb) -> Rgb {
    let phase = TAU * path * 1e-9;
    let [x, y, z, x2] = &*SENSITIVITIES;
    let at = |g: &Gaussian, shift: f64| {
        g.weight * libm::cos(g.centre * phase + shift) * libm::exp(-phase * phase * g.variance)
    };
    XYZ_TO_RGB * DVec3::new(at(x, shift.x) + at(x2, shift.x), at(y, shift.y), at(z, shift.z))
}

impl ThinFilm {
    /// The share of light reflected at cosine `cos` outside the film, in [0, 1]; `base_f0` is what is below, in air.
    ///
    /// The three terms of the series that are kept can leave [0, 1] by a little in saturated colours. The extension
    /// bounds them below; they are bounded above as well, so that no energy is made.
    pub(crate) fn reflectance(&self, base_f0: Rgb, cos: f64) -> Rgb {
        let cos2_squared = 1.0 - (1.0 - cos * cos) / (self.ior * self.ior);
        if cos2_squared < 0.0 {
            return Rgb::ONE;
        }
        let cos2 = cos2_squared.sqrt();
        // First face.
        let r12 = schlick(normal_reflectance(Rgb::splat(self.ior), 1.0), cos).x;
        let t121 = 1.0 - r12;
        // Second face.
        let root = (base_f0 + GUARD).min(Rgb::splat(1.0 - GUARD));
        let root = Rgb::new(root.x.sqrt(), root.y.sqrt(), root.z.sqrt());
        let base_ior = (1.0 + root) / (1.0 - root);
        let r23 = schlick(normal_reflectance(base_ior, self.ior), cos2);
        // Phases.
        let path = 2.0 * self.ior * self.thickness * cos2;
        let phi12 = if self.ior < 1.0 { PI } else { 0.0 };
        let phi21 = PI - phi12;
        let phi23 = |base: f64| if base < self.ior { PI } else { 0.0 };
        let phi = Rgb::new(phi23(base_ior.x), phi23(base_ior.y), phi23(base_ior.z)) + phi21;
        // The series.
        let r123 = (r23 * r12).clamp(Rgb::splat(1e-5), Rgb::splat(0.9999));
        let amplitude = Rgb::new(r123.x.sqrt(), r123.y.sqrt(), r123.z.sqrt());
        let rs = r23 * (t121 * t121) / (1.0 - r123);
        let mut sum = rs + r12;
        let mut term = rs - t121;
        for m in [1.0, 2.0] {
            term *= amplitude;
            sum += term * sensitivity(m * path, phi * m) * 2.0;
        }
        sum.clamp(Rgb::ZERO, Rgb::ONE)
    }

    /// `plain` reflectance with the film over it.
    #[inline]
    pub(crate) fn over(&self, plain: Rgb, base_f0: Rgb, cos: f64) -> Rgb {
        plain.lerp(self.reflectance(base_f0, cos), self.strength)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GLASS: Rgb = Rgb::splat(0.04);

    #[test]
    fn a_film_of_the_outsides_index_is_not_there() {
        // Seen along the normal. Elsewhere Schlick's form reflects at any face, even between equal indices.
        let film = ThinFilm { strength: 1.0, ior: 1.0, thickness: 300.0 };
        let difference = (film.reflectance(GLASS, 1.0) - GLASS).abs().max_element();
        // The series never leaves out its oscillation wholly: the amplitude is at least sqrt(1e-5).
        assert!(difference < 1e-2, "{difference}");
    }

    #[test]
    fn a_thick_film_reflects_as_two_faces_without_interference() {
        let film = ThinFilm { strength: 1.0, ior: 1.38, thickness: 1e5 };
        let r12 = (0.38_f64 / 2.38).powi(2);
        let base = (1.0 + 0.0401_f64.sqrt()) / (1.0 - 0.0401_f64.sqrt());
        let r23 = ((base - 1.38) / (base + 1.38)).powi(2);
        let expected = r12 + (1.0 - r12).powi(2) * r23 / (1.0 - r12 * r23);
        let found = film.reflectance(GLASS, 1.0);
        assert!((found - expected).abs().max_element() < 1e-4, "{found} {expected}");
    }

    #[test]
    fn a_quarter_wave_layer_quenches_the_reflection_of_glass() {
        // Magnesium fluoride, a quarter of 550 nm thick: the oldest antireflection coating. A half wave is no coating.
        let green = |thickness| ThinFilm { strength: 1.0, ior: 1.38, thickness }.reflectance(GLASS, 1.0).y;
        let (quarter, half) = (green(550.0 / 4.0 / 1.38), green(550.0 / 2.0 / 1.38));
        assert!(quarter < 0.016 && (0.03..0.045).contains(&half), "{quarter} {half}");
        // Seen at 60 degrees the paths through a film differ by less: what was green turns blue.
        let film = ThinFilm { strength: 1.0, ior: 1.8, thickness: 300.0 };
        let (straight, slanted) = (film.reflectance(Rgb::splat(0.5), 1.0), film.reflectance(Rgb::splat(0.5), 0.5));
        assert!(straight.y > 1.4 * straight.x.max(straight.z) && slanted.z > 1.2 * slanted.y, "{straight} {slanted}");
    }

    #[test]
    fn the_reflectance_is_a_share_everywhere() {
        for ior in [1.0, 1.3, 1.8, 2.5] {
            for thickness in [0.0, 120.0, 333.0, 700.0] {
                for f0 in [Rgb::ZERO, GLASS, Rgb::new(1.0, 0.7, 0.2)] {
                    for i in 0..=50 {
                        let film = ThinFilm { strength: 1.0, ior, thickness };
                        let r = film.reflectance(f0, f64::from(i) / 50.0);
                        assert!(r.min_element() >= 0.0 && r.max_element() <= 1.0 && r.is_finite(), "{film:?} {r}");
                    }
                }
            }
        }
    }
}
