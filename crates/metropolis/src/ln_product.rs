//! Products of many densities without overflow or underflow.

/// Accumulates a product of non-negative factors and gives its natural logarithm.
///
/// Factors are multiplied as they are while the product stays far inside the range of f64, so that the usual case takes
/// one logarithm in all.
///
/// ```
/// use ergodic_metropolis::LnProduct;
///
/// let mut product = LnProduct::one();
/// for _ in 0..100 {
///     product.multiply(1e-50);
/// }
/// assert!((product.ln() / (100.0 * 1e-50f64.ln()) - 1.0).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct LnProduct {
    mantissa: f64,
    ln: f64,
}

/// Products are renormalised beyond this; a single factor may be as large again without harm.
const LIMIT: f64 = 1e120;

impl LnProduct {
    /// The empty product.
    #[inline]
    pub fn one() -> Self {
        Self { mantissa: 1.0, ln: 0.0 }
    }

    /// Multiplies by `factor`.
    #[inline]
    pub fn multiply(&mut self, factor: f64) {
        self.mantissa *= factor;
        if !(1.0 / LIMIT..=LIMIT).contains(&self.mantissa) {
            self.renormalise();
        }
    }

    #[cold]
    fn renormalise(&mut self) {
        // 0, infinity and NaN stay what they are: ln() reports them.
        if self.mantissa > 0.0 && self.mantissa.is_finite() {
            self.ln += self.mantissa.ln();
            self.mantissa = 1.0;
        }
    }

    /// Natural logarithm of the product: -inf for 0, NaN if a factor was NaN or the product negative.
    #[inline]
    pub fn ln(&self) -> f64 {
        self.ln + self.mantissa.ln()
    }
}
