//! How well the chains mix: autocorrelation, effective sample size, R-hat over chains, stays on one path.

use ergodic_metropolis::diagnostics::{BatchMeans, Moments, r_hat, time_between_chains};
use ergodic_pathspace::{Measured, PathClass};

use crate::autocorrelation::{self, WATCHED, Windows};
use crate::statistics::MutationStatistics;

/// Batches whose means a chain keeps for its autocorrelation time.
const BATCHES: usize = 32;

/// With so many chains their means tell the autocorrelation time, to 18 % or better; fewer are cut into batches, which are short.
const MANY_CHAINS: usize = 64;

/// Above this R-hat the chains disagree about the mean.
pub const R_HAT_LIMIT: f64 = 1.05;

/// A chain is stuck if one stay takes this share of its steps, and at least so many.
const STUCK_SHARE: f64 = 0.05;
const STUCK_STEPS: u64 = 200;

/// A run of steps at one path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stay {
    /// Steps in which the chain did not move.
    pub steps: u64,
    /// Class of the path.
    pub class: PathClass,
}

/// What one chain shows of its mixing.
#[derive(Clone, Debug)]
pub(crate) struct ChainTrace {
    ln_luminance: BatchMeans,
    image_x: BatchMeans,
    image_y: BatchMeans,
    /// Of chains that are watched closely.
    windows: Option<Box<Windows>>,
    longest: Option<Stay>,
}

impl ChainTrace {
    /// Of the chain of this number.
    pub(crate) fn new(index: u64) -> Self {
        let none = || BatchMeans::new(BATCHES);
        let windows = (index < WATCHED as u64).then(|| Box::new(Windows::new()));
        Self { ln_luminance: none(), image_x: none(), image_y: none(), windows, longest: None }
    }

    /// The chain was at a path for `steps` steps, the last of which took it away or was the last of all.
    #[inline]
    pub(crate) fn record(&mut self, at: &Measured, class: PathClass, steps: u64) {
        let ln_luminance = at.target.ln();
        self.ln_luminance.add_run(ln_luminance, steps);
        self.image_x.add_run(at.raster.x, steps);
        self.image_y.add_run(at.raster.y, steps);
        if let Some(windows) = &mut self.windows {
            windows.record([ln_luminance, at.raster.x, at.raster.y], steps);
        }
        self.record_stay(class, steps.saturating_sub(1));
    }

    pub(crate) fn record_stay(&mut self, class: PathClass, steps: u64) {
        if steps > self.longest.map_or(0, |stay| stay.steps) {
            self.longest = Some(Stay { steps, class });
        }
    }

    /// The chain begins anew. Means go on, since what their spread tells is the error of the picture; correlations do not.
    pub(crate) fn begin_anew(&mut self) {
        if let Some(windows) = &mut self.windows {
            windows.end();
        }
    }

    pub(crate) fn longest_stay(&self) -> Option<Stay> {
        self.longest
    }
}

/// How well the chains estimate the mean of one quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Mixing {
    /// What was watched.
    pub name: &'static str,
    /// Integrated autocorrelation time in steps, from the spread of the means of many chains, or the mean over few of what their batches
    /// say; `None` if they are too short to tell.
    pub autocorrelation_time: Option<f64>,
    /// All steps over that time.
    pub effective_sample_size: Option<f64>,
    /// Potential scale reduction over the chains.
    pub r_hat: Option<f64>,
    /// Lags in steps and the correlation at each, over the first 256 chains until they begin anew.
    pub autocorrelation: Vec<(u64, f64)>,
}

/// The mixing of all chains.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MixingReport {
    /// ln C, and the image point's two coordinates in pixels.
    pub quantities: Vec<Mixing>,
    /// The longest stay of any chain.
    pub longest_stay: Option<Stay>,
    /// How many chains are stuck: one stay takes a twentieth of their steps.
    pub stuck_chains: usize,
    /// What should be known before the picture is believed.
    pub warnings: Vec<String>,
}

fn mixing(
    name: &'static str,
    traces: &[&ChainTrace],
    of: impl Fn(&ChainTrace) -> &BatchMeans,
    autocorrelation: Vec<(u64, f64)>,
) -> Mixing {
    let steps: u64 = traces.iter().map(|trace| of(trace).terms().count()).sum();
    let parts: Vec<Moments> = traces.iter().map(|trace| of(trace).terms()).collect();
    let autocorrelation_time = if parts.len() >= MANY_CHAINS {
        time_between_chains(&parts)
    } else {
        let times: Moments = traces.iter().filter_map(|trace| of(trace).autocorrelation_time()).collect();
        (times.count() > 0).then(|| times.mean())
    };
    Mixing {
        name,
        autocorrelation_time,
        effective_sample_size: autocorrelation_time.map(|time| steps as f64 / time),
        r_hat: r_hat(&parts),
        autocorrelation,
    }
}

/// The class whose share of the steps differs most between parts of the chains: where they disagree.
fn least_agreed(parts: &[&[MutationStatistics]]) -> Option<PathClass> {
    let mut classes: Vec<PathClass> =
        parts.iter().flat_map(|part| part.iter()).flat_map(|s| s.classes()).map(|(class, _)| class).collect();
    classes.sort_unstable_by_key(|class| (class.length, class.specular));
    classes.dedup();
    let steps: Vec<u64> = parts.iter().map(|part| part.iter().map(|s| s.total().proposed).sum()).collect();
    let spread = |class: PathClass| {
        let share = |(part, steps): (&&[MutationStatistics], &u64)| {
            let here: u64 = part.iter().map(|s| s.class(class).proposed).sum();
            here as f64 / (*steps).max(1) as f64
        };
        parts.iter().zip(&steps).map(share).collect::<Moments>().variance()
    };
    let spreads = classes.into_iter().map(|class| (class, spread(class)));
    spreads.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(class, _)| class)
}

/// Puts together what the chains show; `parts` are the statistics of parts of the chains.
pub(crate) fn report(traces: &[&ChainTrace], steps: u64, parts: &[&[MutationStatistics]]) -> MixingReport {
    let watched: Vec<&Windows> = traces.iter().filter_map(|trace| trace.windows.as_deref()).collect();
    let quantities = vec![
        mixing("ln_luminance", traces, |trace| &trace.ln_luminance, autocorrelation::function(&watched, 0)),
        mixing("image_x", traces, |trace| &trace.image_x, autocorrelation::function(&watched, 1)),
        mixing("image_y", traces, |trace| &trace.image_y, autocorrelation::function(&watched, 2)),
    ];
    let longest_stay = traces.iter().filter_map(|trace| trace.longest_stay()).max_by_key(|stay| stay.steps);
    let limit = STUCK_STEPS.max((steps as f64 * STUCK_SHARE) as u64);
    let stuck_chains =
        traces.iter().filter(|trace| trace.longest_stay().is_some_and(|stay| stay.steps > limit)).count();
    let mut warnings = Vec::new();
    if let Some(stay) = longest_stay.filter(|_| stuck_chains > 0) {
        warnings.push(format!(
            "{stuck_chains} of {} chains stayed more than {limit} of their {steps} steps at one path; the longest stay, {} \
             steps, was at a path {}: the picture may have bright spots there",
            traces.len(),
            stay.steps,
            stay.class,
        ));
    }
    let worst = quantities.iter().filter_map(|q| q.r_hat.map(|r| (q.name, r))).max_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((name, r)) = worst.filter(|(_, r)| *r > R_HAT_LIMIT) {
        let class = least_agreed(parts).map_or_else(String::new, |c| format!(", most about paths {c}"));
        warnings.push(format!(
            "the chains disagree{class}: R-hat of {name} is {r:.3}, more than {R_HAT_LIMIT}; longer chains, or other \
             mutations, would help"
        ));
    }
    MixingReport { quantities, longest_stay, stuck_chains, warnings }
}
