//! Densities that neither overflow nor underflow, with no logarithm taken until one is asked for.

use std::f64::consts::LN_2;

/// A non-negative number as `mantissa · 2^exponent`: a product of very many factors stays in range, and a ratio of two such
/// products costs one division where their logarithms would have cost two and an exponential function.
///
/// ```
/// use ergodic_metropolis::Density;
///
/// let mut product = Density::ONE;
/// for _ in 0..100 {
///     product.multiply(1e-50);
/// }
/// assert!((product.ln() / (100.0 * 1e-50f64.ln()) - 1.0).abs() < 1e-12);
/// assert!((Density::from_ln(-700.0).times(product).ratio_to(product) / (-700.0f64).exp() - 1.0).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Density {
    mantissa: f64,
    exponent: i64,
}

/// Mantissas are renormalised beyond this; a product of two is still far inside the range of f64.
const LIMIT: f64 = 1e120;

/// Running products of plain numbers are brought back beyond this, far inside the range of f64.
const RUNNING: f64 = 1e100;

/// For running products kept as plain numbers, of which `size` is the largest: `(2^-n, n)` with which to multiply them, and which to add
/// to their common exponent, where they have left the range in which further factors are safe. Nothing is rounded by it. `None` within
/// the range, and for 0 and what is no number, which no factor would bring back.
///
/// ```
/// use ergodic_metropolis::renormalisation;
///
/// assert_eq!(renormalisation(1e-30), None);
/// let (factor, power) = renormalisation(1e200).unwrap();
/// assert!((1.0..2.0).contains(&(1e200 * factor)) && factor == f64::powi(0.5, power as i32));
/// ```
#[inline]
pub fn renormalisation(size: f64) -> Option<(f64, i64)> {
    if (1.0 / RUNNING..=RUNNING).contains(&size) || !(size > 0.0 && size.is_finite()) {
        return None;
    }
    let power = libm::log2(size).floor().clamp(-1000.0, 1000.0);
    Some((libm::exp2(-power), power as i64))
}

/// Logarithms up to this size are plain numbers.
const PLAIN_LN: f64 = 250.0;

impl Density {
    /// 1, the empty product.
    pub const ONE: Self = Self { mantissa: 1.0, exponent: 0 };

    /// 0.
    pub const ZERO: Self = Self { mantissa: 0.0, exponent: 0 };

    /// A plain number.
    #[inline]
    pub fn new(value: f64) -> Self {
        let mut density = Self::ONE;
        density.multiply(value);
        density
    }

    /// The number with this natural logarithm; 0 for -inf. Exact to the rounding of the logarithm.
    #[inline]
    pub fn from_ln(ln: f64) -> Self {
        if ln.abs() <= PLAIN_LN {
            return Self { mantissa: libm::exp(ln), exponent: 0 };
        }
        Self::from_large_ln(ln)
    }

    #[cold]
    fn from_large_ln(ln: f64) -> Self {
        if !ln.is_finite() {
            return Self { mantissa: libm::exp(ln), exponent: 0 };
        }
        let exponent = (ln / LN_2).round();
        Self { mantissa: libm::exp(ln - exponent * LN_2), exponent: exponent as i64 }
    }

    /// Multiplies by `factor`.
    #[inline]
    pub fn multiply(&mut self, factor: f64) {
        let mantissa = self.mantissa * factor;
        if (1.0 / LIMIT..=LIMIT).contains(&mantissa) {
            self.mantissa = mantissa;
        } else {
            self.multiply_far(factor);
        }
    }

    /// The product where it is 0, no number, or would leave the range: both factors are brought into [1, 2) first.
    #[cold]
    fn multiply_far(&mut self, factor: f64) {
        let mut factor = Self { mantissa: factor, exponent: 0 };
        self.renormalise();
        factor.renormalise();
        self.mantissa *= factor.mantissa;
        self.exponent = self.exponent.saturating_add(factor.exponent);
    }

    /// The product of two.
    #[inline]
    pub fn times(self, other: Self) -> Self {
        let mut product = Self { mantissa: self.mantissa, exponent: self.exponent.saturating_add(other.exponent) };
        product.multiply(other.mantissa);
        product
    }

    /// The product with 2^`power`, exactly.
    #[inline]
    pub fn scaled(self, power: i64) -> Self {
        Self { exponent: self.exponent.saturating_add(power), ..self }
    }

    /// Brings the mantissa into [1, 2). It is multiplied by powers of two only, so nothing is rounded.
    fn renormalise(&mut self) {
        // 0, infinity and NaN stay what they are.
        if !(self.mantissa > 0.0 && self.mantissa.is_finite()) {
            return;
        }
        if self.mantissa < f64::MIN_POSITIVE {
            // Subnormal: the exponent's bits would not tell.
            self.mantissa *= (1u64 << 54) as f64;
            self.exponent -= 54;
        }
        let power = (self.mantissa.to_bits() >> 52) as i64 - 1023;
        self.mantissa = f64::from_bits(self.mantissa.to_bits() & ((1 << 52) - 1) | 1023 << 52);
        self.exponent = self.exponent.saturating_add(power);
    }

    /// Whether it is a number that a density can have: not negative, not infinite, not NaN.
    #[inline]
    pub fn is_valid(self) -> bool {
        self.mantissa >= 0.0 && self.mantissa < f64::INFINITY
    }

    /// Whether it is 0.
    #[inline]
    pub fn is_zero(self) -> bool {
        self.mantissa == 0.0
    }

    /// This number over another one, as a plain number: infinite or 0 where it leaves the range.
    #[inline]
    pub fn ratio_to(self, other: Self) -> f64 {
        let ratio = self.mantissa / other.mantissa;
        if self.exponent == other.exponent { ratio } else { scale(ratio, self.exponent.saturating_sub(other.exponent)) }
    }

    /// Natural logarithm: -inf for 0, NaN if a factor was NaN or the product negative.
    #[inline]
    pub fn ln(self) -> f64 {
        libm::log(self.mantissa) + self.exponent as f64 * LN_2
    }

    /// The plain number: infinite or 0 where it leaves the range.
    #[inline]
    pub fn value(self) -> f64 {
        if self.exponent == 0 { self.mantissa } else { scale(self.mantissa, self.exponent) }
    }
}

/// `value` · 2^`power`. In two steps: the power alone may leave the range where the product does not.
#[cold]
fn scale(value: f64, power: i64) -> f64 {
    let power = power.clamp(-4000, 4000) as i32;
    let half = power / 2;
    value * 2f64.powi(half) * 2f64.powi(power - half)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_exact_where_plain_numbers_are() {
        let factors = [3.0, 1e-300, 7.5e299, 1e200, 1e-170, 0.1, 5e-324, 1e300];
        let mut product = Density::ONE;
        let mut ln = 0.0;
        for factor in factors {
            product.multiply(factor);
            ln += f64::ln(factor);
            assert!((product.ln() - ln).abs() < 1e-10 * ln.abs().max(1.0), "{product:?} {ln}");
            assert!((Density::from_ln(product.ln()).ratio_to(product) - 1.0).abs() < 1e-9);
        }
        assert_eq!(Density::new(1e-310).value(), 1e-310);
        assert_eq!(Density::new(1e-310).ratio_to(Density::new(1e-310)), 1.0);
    }

    #[test]
    fn ratios_leave_the_range_as_numbers_do() {
        let (tiny, huge) = (Density::from_ln(-1e5), Density::from_ln(1e5));
        assert_eq!((tiny.ratio_to(huge), huge.ratio_to(tiny)), (0.0, f64::INFINITY));
        assert_eq!(tiny.ratio_to(tiny), 1.0);
        assert_eq!((tiny.value(), huge.value()), (0.0, f64::INFINITY));
        assert_eq!(Density::ZERO.ratio_to(huge), 0.0);
        assert!((huge.scaled(-3).ratio_to(huge) - 0.125).abs() < 1e-15);
    }

    #[test]
    fn what_is_no_density_is_told() {
        for bad in [f64::NAN, f64::INFINITY, -1.0] {
            assert!(!Density::new(bad).is_valid(), "{bad}");
        }
        assert!(!Density::from_ln(f64::NAN).is_valid() && !Density::from_ln(f64::INFINITY).is_valid());
        assert!(Density::from_ln(f64::NEG_INFINITY).is_zero() && Density::ZERO.is_valid());
        assert_eq!(Density::ZERO.ln(), f64::NEG_INFINITY);
    }
}
