//! The Kolmogorov-Smirnov test of uniformity.

/// The outcome of a Kolmogorov-Smirnov test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KolmogorovSmirnov {
    /// Largest distance between the empirical distribution function and the diagonal.
    pub statistic: f64,
    /// Asymptotic probability of a distance at least as large, with Stephens' correction for the sample's size.
    pub p_value: f64,
}

/// Tests whether independent `samples` are uniform on `[0, 1]`. Sorts them. Samples outside, or not numbers, give p = 0.
pub fn kolmogorov_smirnov_uniform(samples: &mut [f64]) -> KolmogorovSmirnov {
    samples.sort_by(f64::total_cmp);
    let n = samples.len() as f64;
    if samples.iter().any(|v| !(0.0..=1.0).contains(v)) {
        return KolmogorovSmirnov { statistic: 1.0, p_value: 0.0 };
    }
    let statistic =
        samples.iter().enumerate().map(|(i, v)| (v - i as f64 / n).max((i + 1) as f64 / n - v)).fold(0.0, f64::max);
    // Stephens 1970; the series of Kolmogorov converges fast for all but the smallest distances.
    let lambda = (n.sqrt() + 0.12 + 0.11 / n.sqrt()) * statistic;
    let p_value = if lambda < 0.2 {
        1.0
    } else {
        let series: f64 = (1..=100)
            .map(|k| {
                let sign = if k % 2 == 1 { 2.0 } else { -2.0 };
                sign * (-2.0 * f64::from(k * k) * lambda * lambda).exp()
            })
            .sum();
        series.clamp(0.0, 1.0)
    };
    KolmogorovSmirnov { statistic, p_value }
}

#[cfg(test)]
mod tests {
    use ergodic_metropolis::RandomSource;

    use super::*;

    #[test]
    fn uniform_passes_and_a_small_bend_fails() {
        let mut rng = crate::generator(1);
        let mut uniform: Vec<f64> = (0..100_000).map(|_| rng.uniform()).collect();
        let mut bent: Vec<f64> = uniform.iter().map(|u| u.powf(1.03)).collect();
        let mut outside = vec![0.5, 1.5];
        assert!(kolmogorov_smirnov_uniform(&mut uniform).p_value > 1e-3);
        assert!(kolmogorov_smirnov_uniform(&mut bent).p_value < 1e-6);
        assert_eq!(kolmogorov_smirnov_uniform(&mut outside).p_value, 0.0);
    }

    #[test]
    fn agrees_with_the_table() {
        // The 5 % point of the limit distribution is 1.3581.
        let n = 1_000_000;
        let shift = 1.3581 / f64::from(n).sqrt();
        let mut shifted: Vec<f64> = (0..n).map(|i| ((f64::from(i) + 0.5) / f64::from(n) - shift).max(0.0)).collect();
        assert!((kolmogorov_smirnov_uniform(&mut shifted).p_value - 0.05).abs() < 1e-3);
    }
}
