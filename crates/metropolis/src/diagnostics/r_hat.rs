//! Do several chains tell the same story?

use super::Moments;

/// Variances of terms in several parts.
struct Spread {
    /// Terms of the shortest part.
    terms: f64,
    /// Mean variance within a part.
    within: f64,
    /// Variance of the parts' means.
    between: f64,
    /// Variance of all terms together.
    pooled: f64,
}

impl Spread {
    /// `None` for fewer than two parts, or parts of fewer than two terms.
    fn of(parts: &[Moments]) -> Option<Self> {
        let shortest = parts.iter().map(Moments::count).min()?;
        if parts.len() < 2 || shortest < 2 {
            return None;
        }
        let terms = shortest as f64;
        let within = parts.iter().map(Moments::variance).sum::<f64>() / parts.len() as f64;
        let between = parts.iter().map(Moments::mean).collect::<Moments>().variance();
        let pooled = (terms - 1.0) / terms * within + between;
        Some(Self { terms, within, between, pooled })
    }
}

/// Potential scale reduction R-hat (Gelman and Rubin 1992): the spread that the pooled chains have over the spread within
/// each. Near 1 when every chain has seen the whole target.
///
/// Feed it the halves of each chain (as [`split_r_hat`] does), so that a drift within a chain shows as well; keeping two
/// [`Moments`] per chain is enough for that. `None` for fewer than two parts, parts of fewer than two terms, or parts none of
/// which ever changed.
pub fn r_hat(parts: &[Moments]) -> Option<f64> {
    let Spread { within, pooled, .. } = Spread::of(parts)?;
    let ratio = pooled / within;
    (within > 0.0 && ratio.is_finite()).then(|| ratio.sqrt())
}

/// Integrated autocorrelation time in steps, from stationary chains that started independently of each other: the spread of their means
/// against the spread of all terms, n Var(mean of a chain) / Var(term).
///
/// Batches within a chain tell no time longer than a batch. This tells any up to n, the length of a chain, and of chains that never move
/// it says n. Its own relative error is √(2/m) for m chains. `None` for fewer than two chains, or where nothing ever changed.
pub fn time_between_chains(chains: &[Moments]) -> Option<f64> {
    let Spread { terms, between, pooled, .. } = Spread::of(chains)?;
    let time = terms * between / pooled;
    time.is_finite().then_some(time)
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
