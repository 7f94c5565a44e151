//! Do several chains tell the same story?

use super::Moments;

/// Potential scale reduction R-hat (Gelman and Rubin 1992): the spread that the pooled chains have over the spread within
/// each. Near 1 when every chain has seen the whole target.
///
/// Feed it the halves of each chain (as [`split_r_hat`] does), so that a drift within a chain shows as well; keeping two
/// [`Moments`] per chain is enough for that. `None` for fewer than two parts, parts of fewer than two terms, or parts none of
/// which ever changed.
pub fn r_hat(parts: &[Moments]) -> Option<f64> {
    let shortest = parts.iter().map(Moments::count).min()?;
    if parts.len() < 2 || shortest < 2 {
        return None;
    }
    let within = parts.iter().map(Moments::variance).sum::<f64>() / parts.len() as f64;
    let between: Moments = parts.iter().map(Moments::mean).collect();
    let n = shortest as f64;
    let ratio = ((n - 1.0) / n * within + between.variance()) / within;
    (within > 0.0 && ratio.is_finite()).then(|| ratio.sqrt())
}

/// R-hat of stored chains, each cut in halves (Gelman et al. 2013, section 11.4). The middle term of an odd chain is left out.
///
/// ```
/// use ergodic_metropolis::diagnostics::split_r_hat;
///
/// let low: Vec<f64> = (0..100).map(|i| f64::from(i % 7)).collect();
/// let high: Vec<f64> = low.iter().map(|v| v + 100.0).collect();
/// assert!(split_r_hat(&[&low, &low]).unwrap() < 1.01);
/// assert!(split_r_hat(&[&low, &high]).unwrap() > 10.0);
/// ```
pub fn split_r_hat(chains: &[&[f64]]) -> Option<f64> {
    let halves: Vec<Moments> = chains
        .iter()
        .flat_map(|chain| {
            let half = chain.len() / 2;
            [&chain[..half], &chain[chain.len() - half..]]
        })
        .map(|half| half.iter().copied().collect())
        .collect();
    r_hat(&halves)
}
