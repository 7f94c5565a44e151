//! The integrated autocorrelation time of a stored series.

/// How strongly the terms of a series repeat each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Autocorrelation {
    /// Integrated autocorrelation time τ = 1 + 2 Σ ρ(t), in steps: 1 for independent terms, less for terms that alternate.
    pub time: f64,
    /// The last lag that was summed.
    pub window: usize,
    /// Length of the series over τ: as many independent terms would know the mean as well.
    pub effective_sample_size: f64,
}

/// The series must be this many autocorrelation times long, or the estimate is too small by its very shortness.
const LEAST_TIMES: f64 = 50.0;

/// Estimates the integrated autocorrelation time by Geyer's initial monotone sequence (Geyer 1992, section 3.3).
///
/// For a reversible chain Γ(k) = ρ(2k) + ρ(2k + 1) is positive and decreasing, also where ρ itself alternates; the sum is cut
/// where the estimate of Γ is lost in its noise (below `1/sqrt(N)`), and what rises again before that is held down. Each lag
/// costs one pass over the series.
///
/// For τ far below 1 the error is a few times `1/sqrt(N)`, no longer relative to τ; [`BatchMeans`](super::BatchMeans) is
/// better there. A series that never changes has no autocorrelation time, nor has one shorter than 50 τ: `None`.
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
    let noise = 1.0 / (n as f64).sqrt();
    let (mut sum, mut before, mut window) = (0.0, f64::INFINITY, 0);
    for lag in (0..n - 1).step_by(2) {
        let pair = (covariance(lag) + covariance(lag + 1)) / variance;
        if pair < noise {
            break;
        }
        before = pair.min(before);
        sum += before;
        window = lag + 1;
    }
    // ρ(0) was counted twice. Terms that alternate perfectly bring the sum to 0; τ itself is positive.
    let time = (2.0 * sum - 1.0).max(1.0 / n as f64);
    let enough = n as f64 >= LEAST_TIMES * time;
    enough.then_some(Autocorrelation { time, window, effective_sample_size: n as f64 / time })
}
