//! The integrated autocorrelation time of a stored series.

/// How strongly the terms of a series repeat each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Autocorrelation {
    /// Integrated autocorrelation time τ = 1 + 2 Σ ρ(t), in steps: 1 for independent terms, less for terms that alternate.
    pub time: f64,
    /// The lag at which the sum was cut.
    pub window: usize,
    /// Length of the series over τ: as many independent terms would know the mean as well.
    pub effective_sample_size: f64,
}

/// The window reaches this many autocorrelation times: Sokal's c, between bias exp(-c) and noise growing with the window.
const WINDOW: f64 = 6.0;

/// Estimates the integrated autocorrelation time with Sokal's self-consistent window (Sokal 1997, section 3): the sum of ρ(t)
/// is cut at the first lag M ≥ 6 τ(M).
///
/// The relative standard error is about `sqrt(2 (2 M + 1) / N)`. A series that never changes has no autocorrelation time, nor
/// has one too short for its window (fewer than 50 τ terms, where the estimate would be too small): `None`.
///
/// ```
/// use ergodic_metropolis::diagnostics::autocorrelation;
///
/// let alternating: Vec<f64> = (0..1000).map(|i| f64::from(i % 2)).collect();
/// assert!(autocorrelation(&alternating).unwrap().time < 0.1);
/// assert_eq!(autocorrelation(&[1.0; 1000]), None);
/// ```
pub fn autocorrelation(series: &[f64]) -> Option<Autocorrelation> {
    let n = series.len();
    if n < 2 {
        return None;
    }
    let mean = series.iter().sum::<f64>() / n as f64;
    let centred: Vec<f64> = series.iter().map(|v| v - mean).collect();
    let covariance = |lag: usize| centred[lag..].iter().zip(&centred).map(|(a, b)| a * b).sum::<f64>() / n as f64;
    let variance = covariance(0);
    // A constant series keeps the rounding of its mean: that is no variance.
    if !variance.is_finite() || variance <= (f64::EPSILON * mean).powi(2) {
        return None;
    }
    let mut time = 1.0;
    for window in 1..n {
        time += 2.0 * covariance(window) / variance;
        if window as f64 >= WINDOW * time {
            // Anticorrelated terms can bring the sum to 0 within its noise; τ itself is positive.
            let time = time.max(1.0 / n as f64);
            let enough = n as f64 >= 50.0 * time;
            return enough.then_some(Autocorrelation { time, window, effective_sample_size: n as f64 / time });
        }
    }
    None
}
