//! Reconstruction filters: how much a sample at an offset from a pixel's centre counts for that pixel.

use std::f64::consts::{FRAC_2_SQRT_PI, SQRT_2};

/// A separable pixel filter with integral 1. Lengths are in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// One over the pixel, zero outside.
    Box,
    /// A Gaussian, lowered so that it reaches zero at `radius` without a step.
    Gaussian {
        /// Half the width of the support along each axis.
        radius: f64,
        /// Standard deviation of the Gaussian before it is lowered.
        sigma: f64,
    },
}

/// A [`Filter`] with its constants worked out once, for loops over many pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FilterKernel {
    /// See [`Filter::Box`].
    Box,
    /// See [`Filter::Gaussian`].
    Gaussian {
        /// Half the width of the support.
        radius: f64,
        /// -1 / (2 sigma^2).
        exponent: f64,
        /// The Gaussian's value at `radius`, which is subtracted.
        edge: f64,
        /// One over the integral along one axis.
        normalisation: f64,
    },
}

impl Filter {
    /// Half the width of the support along each axis, in pixels.
    #[inline]
    pub fn radius(&self) -> f64 {
        match *self {
            Self::Box => 0.5,
            Self::Gaussian { radius, .. } => radius,
        }
    }

    /// The weight in 1/pixel^2 at the offset (`dx`, `dy`) of a sample from a pixel's centre.
    ///
    /// Works the normalisation out anew; [`Self::kernel`] keeps it.
    pub fn weight(&self, dx: f64, dy: f64) -> f64 {
        self.kernel().weight(dx, dy)
    }

    /// The filter with its constants worked out.
    pub fn kernel(&self) -> FilterKernel {
        match *self {
            Self::Box => FilterKernel::Box,
            Self::Gaussian { radius, sigma } => {
                let exponent = -0.5 / (sigma * sigma);
                let edge = libm::exp(exponent * radius * radius);
                // Integral over [-r, r] of exp(-x^2/(2 sigma^2)) - edge; sqrt(2 pi) = 2 sqrt(2) / (2 / sqrt(pi)).
                let gaussian = sigma * 2.0 * SQRT_2 / FRAC_2_SQRT_PI * erf(radius / (sigma * SQRT_2));
                let integral = gaussian - 2.0 * radius * edge;
                FilterKernel::Gaussian { radius, exponent, edge, normalisation: 1.0 / integral }
            }
        }
    }
}

impl FilterKernel {
    /// The weight in 1/pixel^2 at the offset (`dx`, `dy`) of a sample from a pixel's centre.
    #[inline]
    pub fn weight(&self, dx: f64, dy: f64) -> f64 {
        self.weight_along(dx) * self.weight_along(dy)
    }

    /// The factor of [`Self::weight`] in 1/pixel for the offset along one axis: filters are separable.
    #[inline]
    pub fn weight_along(&self, d: f64) -> f64 {
        match *self {
            // Half open, so that every raster point belongs to one pixel.
            Self::Box => f64::from(u8::from((-0.5..0.5).contains(&d))),
            Self::Gaussian { radius, exponent, edge, normalisation } => {
                if d.abs() < radius {
                    (libm::exp(exponent * d * d) - edge) * normalisation
                } else {
                    0.0
                }
            }
        }
    }
}

/// The error function for x >= 0, by its series of positive terms (Abramowitz and Stegun 7.1.6).
fn erf(x: f64) -> f64 {
    if x > 6.0 {
        return 1.0;
    }
    let mut term = x;
    let mut sum = x;
    let mut n = 0.0;
    while term > sum * 1e-17 {
        n += 1.0;
        term *= 2.0 * x * x / (2.0 * n + 1.0);
        sum += term;
    }
    FRAC_2_SQRT_PI * libm::exp(-x * x) * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn erf_agrees_with_the_tables() {
        for (x, expected) in [(0.0, 0.0), (0.5, 0.520_499_877_813_046_5), (2.0, 0.995_322_265_018_952_7)] {
            assert!((erf(x) - expected).abs() < 1e-15, "{x}");
        }
    }
}
