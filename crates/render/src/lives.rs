//! How many chains there are at once, and when they begin anew.
//!
//! A picture by chains is as good as the chains' steps and as good as their starts. Many short lives use as many seeds as may be, which is
//! best when seeds are many and alike: chains then hardly have to mix. But if few seeds carry most of the light, lives that are
//! many more than these begin at the same paths again and again, and a bright one leaves a bright spot; long lives wash it out.
//! Independent samples whose mean has the relative standard error e are worth 1/e² equal ones (Kong 1992), and so many lives there are.

use std::time::Instant;

use crate::settings::Life;
use crate::{Budget, MltSettings, Settings};

/// Mutations that a chain makes between two looks at the clock, but for what is left at the end of a life or of a budget. Fixed, so that the
/// order of splats does not depend on speed.
pub(crate) const ROUND: u64 = 256;

/// Mutations of the shortest life and of the longest, where the seeds decide. A start costs as much as several mutations.
const SHORTEST: f64 = 512.0;
const LONGEST: f64 = 16384.0;

/// Mutations that a chain should make if it never begins anew.
const ENDLESS: f64 = 4096.0;

/// Chains that there are at least, unless the settings have fewer.
const LEAST_CHAINS: usize = 16;

/// What was decided before the first mutation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Lives {
    /// Chains at once.
    pub(crate) chains: usize,
    /// Mutations after which each begins anew, if ever.
    pub(crate) life: Option<u64>,
}

impl Lives {
    /// For a render that began at `start`, whose seeds tell the integral of the target with a `relative_error`.
    ///
    /// With a budget of time there may be fewer chains than the settings have, so that each has a whole life: many that end
    /// early would make a picture of little but their starts.
    pub(crate) fn new(
        settings: &Settings,
        start: Instant,
        relative_error: f64,
        seconds_per_mutation: impl FnOnce() -> f64,
    ) -> Self {
        let MltSettings { chains, life, .. } = settings.mlt;
        let mutations = match settings.budget {
            Budget::SamplesPerPixel(samples) => samples * settings.pixels(),
            Budget::Seconds(seconds) => {
                let left = (seconds - start.elapsed().as_secs_f64()).max(0.0);
                left * settings.worker_threads() as f64 / seconds_per_mutation()
            }
        };
        let life = match life {
            Life::Endless => None,
            Life::Mutations(mutations) => Some(mutations),
            Life::Auto => {
                let each = mutations * relative_error * relative_error;
                // Without a seed nothing is known.
                let each = if each.is_finite() { each.clamp(SHORTEST, LONGEST) } else { LONGEST };
                Some((each / ROUND as f64).round() as u64 * ROUND)
            }
        };
        let chains = match settings.budget {
            Budget::SamplesPerPixel(_) => chains,
            Budget::Seconds(_) => {
                let least = LEAST_CHAINS.max(settings.worker_threads());
                let count = mutations / life.map_or(ENDLESS, |life| life as f64);
                if count.is_finite() { (count as usize).max(least).min(chains) } else { chains }
            }
        };
        Self { chains, life }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lives(budget: Budget, life: Life, threads: usize, relative_error: f64, each: f64) -> Lives {
        let mut settings = Settings { threads, budget, size: (100, 100), ..Settings::default() };
        settings.mlt.life = life;
        Lives::new(&settings, Instant::now(), relative_error, || each)
    }

    #[test]
    fn short_budgets_have_fewer_chains_of_whole_lives() {
        let count = |seconds, life, each| lives(Budget::Seconds(seconds), life, 2, 0.01, each).chains as f64;
        let near = |found: f64, expected: f64| (found / expected - 1.0).abs() < 0.02;
        // Two threads, a mutation a microsecond.
        assert!(near(count(1.0, Life::Mutations(4096), 1e-6), 2e6 / 4096.0));
        assert!(near(count(0.5, Life::Mutations(8192), 1e-6), 1e6 / 8192.0));
        assert!(near(count(0.5, Life::Endless, 1e-6), 1e6 / 4096.0));
        assert_eq!(count(20.0, Life::Mutations(4096), 1e-6), 512.0);
        assert_eq!(count(1e-3, Life::Mutations(4096), 1e-6), 16.0);
        assert_eq!(count(1.0, Life::Mutations(4096), f64::NAN), 512.0, "without a seed nothing is known");
        assert_eq!(lives(Budget::Seconds(1e-3), Life::Mutations(4096), 40, 0.01, 1e-6).chains, 40);
        // Mutations that are counted are shared by all chains.
        assert_eq!(lives(Budget::SamplesPerPixel(0.01), Life::Auto, 2, 0.01, 1e-6).chains, 512);
    }

    #[test]
    fn there_are_as_many_lives_as_seeds_are_worth() {
        // 10 000 pixels: ten million mutations.
        let life =
            |relative_error| lives(Budget::SamplesPerPixel(1e3), Life::Auto, 1, relative_error, 1e-6).life.unwrap();
        let near = |found: u64, expected: f64| (found as f64 - expected).abs() <= ROUND as f64 / 2.0;
        for worth in [1e3, 2e3, 1e4] {
            assert!(near(life(1.0 / f64::sqrt(worth)), 1e7 / worth), "{worth}");
        }
        assert_eq!((life(1e-4), life(0.5)), (SHORTEST as u64, LONGEST as u64));
        assert_eq!((life(f64::INFINITY), life(0.0)), (LONGEST as u64, SHORTEST as u64));
        assert_eq!(lives(Budget::SamplesPerPixel(1e3), Life::Endless, 1, 0.01, 1e-6).life, None);
        // However long: errors of seeds go down with the square root of the time, lives are as long, and chains as many, until there
        // are as many as the settings have.
        let timed = |seconds, relative_error| lives(Budget::Seconds(seconds), Life::Auto, 1, relative_error, 1e-6);
        let (short, long) = (timed(0.25, 0.08), timed(4.0, 0.02));
        assert!(near(short.life.unwrap(), 1600.0) && near(long.life.unwrap(), 1600.0), "{short:?} {long:?}");
        assert!((130..=165).contains(&short.chains) && long.chains == 512, "{short:?} {long:?}");
    }
}
