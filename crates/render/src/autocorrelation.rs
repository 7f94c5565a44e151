//! The autocorrelation function of what the chains are watched by, at lags from one step to some hundred thousand.
//!
//! A chain that is watched keeps short windows of its states: the first [`WINDOW`] of every stride 1, 4, 16, ... A window of one
//! stride serves the lags of a few strides, so that all together cover many powers of ten evenly on a logarithmic axis. Keeping
//! a state is due at few steps only, and everything is computed once the chains have ended.

/// States in each window.
const WINDOW: usize = 128;

/// Strides, each [`RATIO`] times the one before.
const LEVELS: usize = 8;
const RATIO: u64 = 4;

/// Lags of a window are less than this many strides.
const LAGS: usize = 16;

/// Pairs of states that a correlation has to come from.
const LEAST_PAIRS: usize = 1000;

/// How many chains are watched, the first ones. They start independently, so that no others would tell anything else.
pub(crate) const WATCHED: usize = 256;

/// Numbers of a state that are watched.
pub(crate) const QUANTITIES: usize = 3;

const fn stride(level: usize) -> u64 {
    RATIO.pow(level as u32)
}

/// The windows of one chain.
#[derive(Clone, Debug)]
pub(crate) struct Windows {
    states: [[[f32; QUANTITIES]; WINDOW]; LEVELS],
    filled: [usize; LEVELS],
    /// Steps recorded so far.
    step: u64,
    /// The first step that a window wants.
    due: u64,
}

impl Windows {
    pub(crate) fn new() -> Self {
        Self { states: [[[0.0; QUANTITIES]; WINDOW]; LEVELS], filled: [0; LEVELS], step: 0, due: 0 }
    }

    /// The chain was at one state for `steps` steps.
    #[inline]
    pub(crate) fn record(&mut self, state: [f64; QUANTITIES], steps: u64) {
        self.step += steps;
        if self.due < self.step {
            self.keep(state.map(|v| v as f32));
        }
    }

    /// What comes after is another chain, of which nothing is kept: states of two chains are no pair.
    pub(crate) fn end(&mut self) {
        self.due = u64::MAX;
    }

    #[cold]
    fn keep(&mut self, state: [f32; QUANTITIES]) {
        self.due = u64::MAX;
        for level in 0..LEVELS {
            let filled = &mut self.filled[level];
            while *filled < WINDOW && *filled as u64 * stride(level) < self.step {
                self.states[level][*filled] = state;
                *filled += 1;
            }
            if *filled < WINDOW {
                self.due = self.due.min(*filled as u64 * stride(level));
            }
        }
    }

    fn window(&self, level: usize, quantity: usize) -> impl ExactSizeIterator<Item = f64> + Clone + '_ {
        self.states[level][..self.filled[level]].iter().map(move |state| f64::from(state[quantity]))
    }
}

/// Lags in steps, and the correlation of a quantity with itself so many steps later: 1 - E[(x' - x)²] / 2σ², which for chains in
/// their stationary distribution is the autocorrelation, and does not depend on where a short window happens to lie. The variance
/// is that of all chains together, so that chains that stay in different places show as a correlation that does not fall to 0.
pub(crate) fn function(chains: &[&Windows], quantity: usize) -> Vec<(u64, f64)> {
    let values = || chains.iter().flat_map(|chain| (0..LEVELS).flat_map(|level| chain.window(level, quantity)));
    let count = values().count() as f64;
    let mean = values().sum::<f64>() / count;
    let variance = values().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count;
    let mut function = Vec::new();
    for level in 0..LEVELS {
        // The lags of the window before end where these begin.
        let first = if level == 0 { 1 } else { LAGS / RATIO as usize };
        for lag in first..LAGS {
            let (mut sum, mut pairs) = (0.0, 0);
            for chain in chains {
                let window = chain.window(level, quantity);
                for (now, later) in window.clone().zip(window.skip(lag)) {
                    sum += (later - now) * (later - now);
                    pairs += 1;
                }
            }
            let correlation = 1.0 - 0.5 * sum / pairs as f64 / variance;
            if pairs >= LEAST_PAIRS && correlation.is_finite() {
                function.push((lag as u64 * stride(level), correlation));
            }
        }
    }
    function
}

#[cfg(test)]
mod tests {
    use ergodic_metropolis::RandomSource;
    use rand_pcg::Pcg64;

    use super::*;

    /// Chains x' = a x + noise of variance 1 - a², which have correlation a^lag; `run` is how many steps each state is kept.
    fn chains(a: f64, steps: u64, run: u64) -> Vec<Windows> {
        let mut rng = Pcg64::new(11, 5);
        // Uniform on an interval of variance 1: correlations do not ask for more.
        let mut noise = move || (rng.uniform() - 0.5) * 12f64.sqrt();
        let chain = |_| {
            let (mut windows, mut x) = (Windows::new(), noise());
            for _ in 0..steps / run {
                windows.record([x, -x, 7.0], run);
                x = a * x + (1.0 - a * a).sqrt() * noise();
            }
            windows
        };
        (0..WATCHED).map(chain).collect()
    }

    /// The greatest distance from a law, over lags up to some steps.
    fn distance(function: &[(u64, f64)], law: impl Fn(u64) -> f64) -> f64 {
        function.iter().map(|(lag, rho)| (rho - law(*lag)).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn known_correlations_are_found_at_all_lags() {
        let a: f64 = 0.99;
        let chains = chains(a, 1 << 14, 1);
        let chains: Vec<&Windows> = chains.iter().collect();
        for quantity in [0, 1] {
            let function = function(&chains, quantity);
            assert!(function.windows(2).all(|pair| pair[0].0 < pair[1].0), "{function:?}");
            assert!(function.first().unwrap().0 == 1 && function.last().unwrap().0 > 1000);
            // 256 independent chains: a standard error of 1/16 at most, and of several less at large lags.
            let found = distance(&function, |lag| a.powi(lag as i32));
            assert!(found < 0.12, "{found}");
            // Lags that are counted wrong, and a chain that forgets more slowly.
            assert!(distance(&function, |lag| a.powi(2 * lag as i32)) > 0.2);
            assert!(distance(&function, |lag| 0.98f64.powi(lag as i32)) > 0.2);
        }
        assert!(function(&chains, 2).is_empty(), "what does not change has no correlation");
    }

    #[test]
    fn runs_count_as_their_steps() {
        let chains = chains(0.0, 1 << 12, 8);
        let chains: Vec<&Windows> = chains.iter().collect();
        // States that last 8 steps and then are drawn anew: 1 - lag / 8 over all offsets within a run.
        let found = distance(&function(&chains, 0), |lag| (1.0 - lag as f64 / 8.0).max(0.0));
        assert!(found < 0.05, "{found}");
        assert!(distance(&function(&chains, 0), |lag| (1.0 - lag as f64 / 9.0).max(0.0)) > 0.06);
    }

    #[test]
    fn states_of_two_chains_are_no_pair() {
        // Each stays where it is for 200 steps, then another begins elsewhere.
        let chains = |ends: bool| {
            let mut rng = Pcg64::new(3, 7);
            let mut place = move || rng.uniform();
            let chain = |_| {
                let mut windows = Windows::new();
                for _ in 0..100 {
                    windows.record([place(); QUANTITIES], 200);
                    if ends {
                        windows.end();
                    }
                }
                windows
            };
            (0..WATCHED).map(chain).collect::<Vec<_>>()
        };
        let function = |chains: &[Windows]| function(&chains.iter().collect::<Vec<_>>(), 0);
        let one = function(&chains(true));
        assert!(one.last().unwrap().0 > 100 && distance(&one, |_| 1.0) < 1e-9, "{one:?}");
        assert!(distance(&function(&chains(false)), |_| 1.0) > 0.5);
    }
}
