//! A homogeneous medium: what absorbs and scatters light between surfaces, and how far light flies in it.
//!
//! Free flight has an exponential distribution whose rate differs by channel. One channel of three is chosen and its flight is
//! drawn, and the density is the mean over the channels, whichever was chosen (one-sample multiple importance sampling; Raab,
//! Seibert and Keller 2008): no channel's contribution over density is more than three times what its own flight would give.

use crate::{HenyeyGreenstein, Rgb};

/// Coefficients per unit of length, and the phase function's parameter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Medium {
    /// Scattering coefficient σ_s.
    pub scattering: Rgb,
    /// Absorption coefficient σ_a.
    pub absorption: Rgb,
    /// Mean cosine g of the turn, in (-1, 1) (see [`HenyeyGreenstein`]).
    pub anisotropy: f64,
}

impl Medium {
    /// Nothing at all.
    pub const VACUUM: Self = Self { scattering: Rgb::ZERO, absorption: Rgb::ZERO, anisotropy: 0.0 };

    /// Extinction coefficient σ_t = σ_a + σ_s.
    #[inline]
    pub fn extinction(&self) -> Rgb {
        self.scattering + self.absorption
    }

    /// Whether it does nothing to light.
    #[inline]
    pub fn is_vacuum(&self) -> bool {
        self.extinction().max_element() <= 0.0
    }

    /// Whether light changes its direction in it.
    #[inline]
    pub fn scatters(&self) -> bool {
        self.scattering.max_element() > 0.0
    }

    /// The scattering at each of its points.
    #[inline]
    pub fn phase(&self) -> HenyeyGreenstein {
        HenyeyGreenstein { scattering: self.scattering, anisotropy: self.anisotropy }
    }

    /// The same with lengths measured in another unit, of which the old one has `scale`.
    #[must_use]
    pub fn scaled(&self, scale: f64) -> Self {
        Self { scattering: self.scattering / scale, absorption: self.absorption / scale, ..*self }
    }

    /// Beer's transmittance exp(-σ_t d).
    #[inline]
    pub fn transmittance(&self, distance: f64) -> Rgb {
        let depth = self.extinction() * distance;
        (-depth).map(libm::exp)
    }

    /// A free flight, drawn from one number in [0, 1); infinite if the channel that was chosen has none.
    #[inline]
    pub fn sample_flight(&self, u: f64) -> f64 {
        let scaled = 3.0 * u;
        let channel = (scaled as usize).min(2);
        let extinction = self.extinction()[channel];
        // Numbers from 0 to 1 again, with 1 left out.
        let rest = (scaled - channel as f64).min(1.0 - f64::EPSILON);
        if extinction > 0.0 { -libm::log1p(-rest) / extinction } else { f64::INFINITY }
    }

    /// Density per unit of length of a flight that ends where the transmittance is `transmittance`: the mean of σ_t exp(-σ_t d).
    #[inline]
    pub fn flight_pdf(&self, transmittance: Rgb) -> f64 {
        (self.extinction() * transmittance).element_sum() / 3.0
    }

    /// The probability that a flight goes on beyond there: the mean of exp(-σ_t d).
    #[inline]
    pub fn flight_survival(&self, transmittance: Rgb) -> f64 {
        transmittance.element_sum() / 3.0
    }
}
