//! The wavelength of light, for materials that disperse it (KHR_materials_dispersion).
//!
//! Transport is in linear Rec. 709 and stays so. Where a path meets a dispersive interface it is that of one wavelength, drawn
//! uniformly from [`Wavelength::SHORTEST`] to [`Wavelength::LONGEST`], and its light is multiplied by [`Wavelength::response`]: a
//! colour, never negative, whose mean over the range is (1, 1, 1). So a dispersion of 0 gives the picture of RGB transport.

use std::sync::LazyLock;

use crate::Rgb;
use crate::color::XYZ_TO_RGB;

/// A wavelength in vacuum; or [`Wavelength::NONE`], where nothing depends on it.
///
/// Its measure is the share of the range: that of the whole range is 1, so that the density of a uniform one is 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wavelength {
    /// In nanometres; 0 for none.
    nanometres: f64,
}

/// Length of the range in nanometres.
const RANGE: f64 = Wavelength::LONGEST - Wavelength::SHORTEST;

/// Steps of the table of responses, of one nanometre each.
const STEPS: usize = RANGE as usize;

/// Responses at the ends of the steps. Between them they are linear, so that the mean is the trapezoidal rule's to the last bit.
static RESPONSES: LazyLock<[Rgb; STEPS + 1]> = LazyLock::new(|| {
    let step = RANGE / STEPS as f64;
    let clipped = |i: usize| (XYZ_TO_RGB * color_matching(Wavelength::SHORTEST + i as f64 * step)).max(Rgb::ZERO);
    let mut responses: [Rgb; STEPS + 1] = std::array::from_fn(clipped);
    let ends = (responses[0] + responses[STEPS]) * 0.5;
    let mean = (responses[1..STEPS].iter().sum::<Rgb>() + ends) / STEPS as f64;
    responses.iter_mut().for_each(|response| *response /= mean);
    responses
});

/// The colour matching functions x, y and z of the CIE 1931 standard observer, by the multi-lobe fit of Wyman, Sloan and Shirley
/// 2013, "Simple Analytic Approximations to the CIE XYZ Color Matching Functions", equation 4.
fn color_matching(nanometres: f64) -> Rgb {
    let lobe = |height: f64, peak: f64, below: f64, above: f64| {
        let t = (nanometres - peak) / if nanometres < peak { below } else { above };
        height * libm::exp(-0.5 * t * t)
    };
    Rgb::new(
        lobe(0.362, 442.0, 16.0, 26.7) + lobe(1.056, 599.8, 37.9, 31.0) + lobe(-0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    )
}

impl Wavelength {
    /// Stands for no wavelength in particular.
    pub const NONE: Self = Self { nanometres: 0.0 };

    /// The shortest, in nanometres.
    pub const SHORTEST: f64 = 380.0;

    /// The longest, in nanometres.
    pub const LONGEST: f64 = 730.0;

    /// Fraunhofer's line F, blue.
    pub const F: Self = Self { nanometres: 486.1 };

    /// Fraunhofer's line d, yellow, at which a material's index of refraction is stated.
    pub const D: Self = Self { nanometres: 587.6 };

    /// Fraunhofer's line C, red.
    pub const C: Self = Self { nanometres: 656.3 };

    /// The wavelength at a share of the range, in [0, 1).
    #[inline]
    pub fn at(share: f64) -> Self {
        Self { nanometres: Self::SHORTEST + RANGE * share }
    }

    /// In nanometres; 0 for none.
    #[inline]
    pub fn nanometres(self) -> f64 {
        self.nanometres
    }

    /// Whether this is [`Self::NONE`].
    #[inline]
    pub fn is_none(self) -> bool {
        self.nanometres == 0.0
    }

    /// This wavelength moved by some share of the range in [-1, 1]. Beyond an end it comes in again at the other, where the eye
    /// hardly sees either.
    #[inline]
    pub fn moved(self, share: f64) -> Self {
        let moved = self.nanometres + share * RANGE;
        let nanometres = if moved < Self::SHORTEST {
            moved + RANGE
        } else if moved >= Self::LONGEST {
            moved - RANGE
        } else {
            moved
        };
        Self { nanometres }
    }

    /// The distance to another by the shorter way around, as a share of the range in [0, 1/2].
    #[inline]
    pub fn distance(self, other: Self) -> f64 {
        let direct = (self.nanometres - other.nanometres).abs() / RANGE;
        direct.min(1.0 - direct)
    }

    /// What a pixel shows of light of this wavelength: linear Rec. 709, never negative, with mean (1, 1, 1) over the range.
    ///
    /// The fitted colour matching functions in Rec. 709, negative parts clipped, each channel divided by its mean. Clipping leaves
    /// spectral colours less saturated than they are and no display could show; the division makes a flat spectrum white.
    #[inline]
    pub fn response(self) -> Rgb {
        let position = ((self.nanometres - Self::SHORTEST) * (STEPS as f64 / RANGE)).clamp(0.0, STEPS as f64);
        let below = (position as usize).min(STEPS - 1);
        RESPONSES[below].lerp(RESPONSES[below + 1], position - below as f64)
    }
}

/// The index of refraction at a wavelength of a material with index `ior` at the line d and with KHR_materials_dispersion's
/// `dispersion`, 20 over the Abbe number; `ior` for no wavelength.
///
/// n = A + B / λ² (Cauchy), where A and B are such that (n_d - 1) / (n_F - n_C) is the Abbe number; at least 1.
#[inline]
pub(crate) fn index(ior: f64, dispersion: f64, wavelength: Wavelength) -> f64 {
    let inverse_square = |w: Wavelength| 1.0 / (w.nanometres * w.nanometres);
    if wavelength.is_none() {
        return ior;
    }
    let spread = (ior - 1.0) * dispersion / 20.0;
    let b = spread / (inverse_square(Wavelength::F) - inverse_square(Wavelength::C));
    (ior + b * (inverse_square(wavelength) - inverse_square(Wavelength::D))).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means over the range by the midpoint rule, where the first `n` derivatives do not matter.
    fn mean(f: impl Fn(Wavelength) -> Rgb) -> Rgb {
        // A multiple of the steps: the rule is exact for what is linear in each.
        let n = 1000 * STEPS;
        (0..n).map(|i| f(Wavelength::at((i as f64 + 0.5) / n as f64))).sum::<Rgb>() / n as f64
    }

    #[test]
    fn the_mean_response_is_white_and_no_response_is_negative() {
        let white = mean(Wavelength::response);
        assert!((white - Rgb::ONE).abs().max_element() < 1e-12, "{white}");
        let least = (0..10_000).map(|i| Wavelength::at(f64::from(i) / 1e4).response().min_element());
        assert!(least.clone().all(|response| response >= 0.0));
        // Unclipped it would be negative somewhere.
        assert!(least.fold(f64::INFINITY, f64::min) == 0.0);
        // Every wavelength can be seen, so that no chain is stuck at one that cannot.
        assert!((0..=10_000).all(|i| Wavelength::at(f64::from(i) / 1e4).response().max_element() > 0.0));
    }

    #[test]
    fn the_colours_are_those_of_the_spectrum() {
        let largest = |nanometres: f64| {
            let response = Wavelength { nanometres }.response();
            response.to_array().iter().position(|channel| *channel == response.max_element())
        };
        assert_eq!([450.0, 540.0, 630.0].map(largest), [Some(2), Some(1), Some(0)]);
        // CIE 1931, 2 degrees, at 555 and 600 nm; the fit is within 0.02 of the tables.
        let tabulated = [(555.0, Rgb::new(0.512_05, 1.0, 0.005_75)), (600.0, Rgb::new(1.062_2, 0.631, 0.000_8))];
        for (nanometres, expected) in tabulated {
            let fitted = color_matching(nanometres);
            assert!((fitted - expected).abs().max_element() < 0.02, "{nanometres}: {fitted}");
        }
    }

    #[test]
    fn the_index_at_the_three_lines_gives_the_abbe_number_back() {
        for (ior, abbe) in [(1.5168, 64.17), (1.33, 55.0), (2.42, 55.0), (1.5, 4.0)] {
            let n = |w| index(ior, 20.0 / abbe, w);
            assert_eq!(n(Wavelength::D), ior);
            let back = (n(Wavelength::D) - 1.0) / (n(Wavelength::F) - n(Wavelength::C));
            assert!((back / abbe - 1.0).abs() < 1e-12, "{back} for {abbe}");
            // The extension's own numbers, which it rounds.
            let nanometres = 430.0;
            let text = ior + (ior - 1.0) / abbe * (523_655.0 / (nanometres * nanometres) - 1.5168);
            assert!((n(Wavelength { nanometres }) - text).abs() < 1e-3 * (ior - 1.0) / abbe * 5.0, "{text}");
        }
        assert_eq!(index(1.5, 0.0, Wavelength::F), 1.5);
        assert_eq!(index(1.5, 1.0, Wavelength::NONE), 1.5);
        assert_eq!(index(1.1, 1e3, Wavelength::at(1.0)), 1.0);
    }

    #[test]
    fn moves_wrap_around_and_are_as_long_as_they_say() {
        for i in 0..100 {
            let here = Wavelength::at(f64::from(i) / 100.0);
            for by in [-0.5, -0.3, -1e-4, 1e-4, 0.2, 0.499] {
                let there = here.moved(by);
                assert!((Wavelength::SHORTEST..Wavelength::LONGEST).contains(&there.nanometres()));
                assert!((here.distance(there) - by.abs()).abs() < 1e-12);
                assert_eq!(here.distance(there), there.distance(here));
            }
        }
    }
}
