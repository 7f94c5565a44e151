//! From a statistic to a probability and back: normal, Student and chi-square tails, Sidak's correction.

use statrs::function::{beta, erf, gamma};

/// The level for each of `tests` independent tests that makes the level of all together `alpha` (Sidak 1967):
/// `1 - (1 - alpha)^(1/tests)`.
pub fn sidak(alpha: f64, tests: usize) -> f64 {
    -f64::exp_m1(f64::ln_1p(-alpha) / tests.max(1) as f64)
}

/// The probability that a standard normal number is at least `|z|` away from 0; 0 for a `z` that is not a number.
pub fn normal_two_sided(z: f64) -> f64 {
    if z.is_nan() { 0.0 } else { erf::erfc(z.abs() / std::f64::consts::SQRT_2) }
}

/// The `|z|` that a standard normal number exceeds with probability `alpha`.
pub fn normal_limit(alpha: f64) -> f64 {
    std::f64::consts::SQRT_2 * erf::erfc_inv(alpha)
}

/// The probability that Student's t with `dof` degrees of freedom is at least `|t|` away from 0; 0 for NaN.
pub fn student_two_sided(t: f64, dof: f64) -> f64 {
    if t.is_nan() || t.is_infinite() { 0.0 } else { beta::beta_reg(0.5 * dof, 0.5, dof / (dof + t * t)) }
}

/// The probability that chi-square with `dof` degrees of freedom is at least `statistic`; 0 for NaN.
pub fn chi_square_tail(statistic: f64, dof: f64) -> f64 {
    if statistic.is_nan() || statistic.is_infinite() {
        0.0
    } else if statistic <= 0.0 {
        1.0
    } else {
        gamma::gamma_ur(0.5 * dof, 0.5 * statistic)
    }
}

/// How many standard errors `estimate` is away from `expected`, signed.
///
/// Without spread there is no scale: 0 where the two agree to rounding, infinite where they do not. What is not a number
/// is infinitely far away, so that no comparison lets it pass.
pub fn z_score(estimate: f64, expected: f64, standard_error: f64) -> f64 {
    let difference = estimate - expected;
    if difference.is_nan() || standard_error.is_nan() {
        f64::INFINITY
    } else if difference.abs() <= 1e-12 * expected.abs() {
        0.0
    } else {
        difference / standard_error
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_agree_with_tables() {
        assert!((normal_two_sided(1.959_963_985) - 0.05).abs() < 1e-9);
        assert!((normal_limit(0.05) - 1.959_963_985).abs() < 1e-8);
        assert!((normal_limit(1e-6) - 4.891_638_475).abs() < 1e-6);
        assert!((student_two_sided(2.228_138_852, 10.0) - 0.05).abs() < 1e-9);
        assert!((chi_square_tail(18.307_038_05, 10.0) - 0.05).abs() < 1e-9);
        // Wilson and Hilferty's cube root is good to four digits this far out.
        let dof = 4000.0f64;
        let statistic = dof * (1.0 - 2.0 / (9.0 * dof) + 1.644_853_627 * (2.0 / (9.0 * dof)).sqrt()).powi(3);
        assert!((chi_square_tail(statistic, dof) - 0.05).abs() < 1e-4);
    }

    #[test]
    fn sidak_is_exact_for_independent_tests() {
        let single = sidak(0.01, 7);
        assert!(((1.0 - single).powi(7) - 0.99).abs() < 1e-14);
        assert!((sidak(1e-12, 1_000_000) / 1e-18 - 1.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_not_a_number_is_never_consistent() {
        assert_eq!(normal_two_sided(f64::NAN), 0.0);
        assert_eq!(student_two_sided(f64::NAN, 3.0), 0.0);
        assert_eq!(chi_square_tail(f64::NAN, 3.0), 0.0);
        assert_eq!(z_score(f64::NAN, 1.0, 1.0), f64::INFINITY);
        assert_eq!(z_score(1.0, 1.0, 0.0), 0.0);
        assert_eq!(z_score(1.1, 1.0, 0.0), f64::INFINITY);
    }
}
