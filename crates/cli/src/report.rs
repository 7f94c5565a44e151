//! What a render did: as JSON for programs, as a table for people.

use ergodic_metropolis::Fault;
use ergodic_mutations::Rejection;
use ergodic_pathspace::stability::{LeftOut, Place};
use ergodic_render::statistics::{JUMP_INTERVALS, MutationStatistics, Tally, jump_bounds};
use ergodic_render::{FaultRecord, Mixing, MixingReport, MltReport, Rendering, Settings};

use crate::census::PlanStats;
use crate::progress::human_time;
use crate::source::Source;
use crate::stats::format::{
    AtLag, Diagnostics, FaultStats, JumpStats, MltStats, MutationStats, Quantity, StabilityStats, Stats, TallyStats,
};
use crate::{config, table};

/// What STEM.stats.json says of how it is written; another number for what programs that read it would misread.
pub const STATS_FORMAT: u64 = 1;

impl StabilityStats {
    fn new(rendering: &Rendering) -> Self {
        let stability = rendering.counts.stability;
        let place = |place: &Place| {
            let LeftOut { non_finite, negative } = stability.at(*place);
            let counts = [("non_finite", non_finite), ("negative", negative)];
            (place.name().to_string(), counts.map(|(what, n)| (what.to_string(), n)).into())
        };
        let mutation = |statistics: &MutationStatistics| {
            let faulty = statistics.total().faulty;
            let counts = Fault::ALL.iter().zip(faulty).map(|(fault, n)| (fault.name().to_string(), n));
            (statistics.name.to_string(), counts.collect())
        };
        Self {
            total: irregular(rendering),
            by_place: Place::ALL.iter().map(place).collect(),
            by_mutation: statistics(rendering).iter().map(mutation).collect(),
        }
    }
}

fn statistics(rendering: &Rendering) -> &[MutationStatistics] {
    rendering.mlt.as_ref().map_or(&[], |report| &report.statistics)
}

/// How much was left out because it was no contribution.
fn irregular(rendering: &Rendering) -> u64 {
    let faulty: u64 = statistics(rendering).iter().flat_map(|s| s.total().faulty).sum();
    rendering.counts.stability.total() + faulty
}

/// What was left out, by place and mutation, in words.
fn stability_line(rendering: &Rendering) -> String {
    let total = irregular(rendering);
    if total == 0 {
        return "stability: every contribution was finite and none negative".into();
    }
    let stability = rendering.counts.stability;
    let mut parts = Vec::new();
    for place in Place::ALL {
        let LeftOut { non_finite, negative } = stability.at(place);
        for (count, what) in [(non_finite, "not finite"), (negative, "negative")] {
            if count > 0 {
                parts.push(format!("{} {count} {what}", place.name()));
            }
        }
    }
    for statistics in statistics(rendering) {
        for (fault, count) in Fault::ALL.iter().zip(statistics.total().faulty).filter(|(_, count)| *count > 0) {
            parts.push(format!("{} {count} {}", statistics.name, fault.name()));
        }
    }
    format!("warning: {total} contributions were left out, so the picture is too dark: {}", parts.join(", "))
}

impl Diagnostics {
    fn new(report: &MixingReport) -> Self {
        let quantity = |mixing: &Mixing| Quantity {
            name: mixing.name.into(),
            autocorrelation_time: mixing.autocorrelation_time,
            effective_sample_size: mixing.effective_sample_size,
            r_hat: mixing.r_hat,
            autocorrelation: mixing
                .autocorrelation
                .iter()
                .map(|&(lag, correlation)| AtLag { lag, correlation })
                .collect(),
        };
        Self {
            quantities: report.quantities.iter().map(quantity).collect(),
            longest_stay: report.longest_stay.map_or(0, |stay| stay.steps),
            longest_stay_class: report.longest_stay.map_or_else(String::new, |stay| stay.class.to_string()),
            stuck_chains: report.stuck_chains,
            warnings: report.warnings.clone(),
        }
    }
}

impl TallyStats {
    fn new(tally: &Tally) -> Self {
        let reasons = Rejection::ALL.iter().zip(tally.not_built).filter(|(_, count)| *count > 0);
        Self {
            proposed: tally.proposed,
            not_built: reasons.map(|(reason, count)| (reason.name().to_string(), count)).collect(),
            faulty: tally.faulty.iter().sum(),
            accepted: tally.accepted,
            acceptance: tally.acceptance(),
            mean_jump_pixels: tally.mean_jump_pixels(),
            ns_per_proposal: tally.ns_per_proposal(),
        }
    }
}

impl MutationStats {
    fn new(statistics: &MutationStatistics) -> Self {
        let lengths = statistics.lengths().into_iter();
        let classes = statistics.classes().into_iter();
        Self {
            name: statistics.name.into(),
            total: TallyStats::new(&statistics.total()),
            jumps: jumps(statistics),
            by_length: lengths.map(|(length, tally)| (length.to_string(), TallyStats::new(&tally))).collect(),
            by_class: classes.map(|(class, tally)| (class.to_string(), TallyStats::new(&tally))).collect(),
        }
    }
}

fn jumps(statistics: &MutationStatistics) -> Vec<JumpStats> {
    let Some(shares) = statistics.jump_shares() else { return Vec::new() };
    let interval = |i: usize| {
        let (from_pixels, to) = jump_bounds(i);
        JumpStats { from_pixels, to_pixels: to.is_finite().then_some(to), share: shares[i] }
    };
    (0..JUMP_INTERVALS).map(interval).collect()
}

fn fault(record: &FaultRecord, statistics: &[MutationStatistics]) -> FaultStats {
    FaultStats {
        chain: record.chain,
        step: record.step,
        mutation: statistics.get(record.mutation).map_or_else(String::new, |s| s.name.to_string()),
        density: record.fault.name().into(),
        class: record.class.to_string(),
    }
}

impl MltStats {
    fn new(report: &MltReport) -> Self {
        Self {
            mutations: report.mutations,
            mutations_per_second: rate(report.mutations, report.mutation_seconds),
            seeding_seconds: report.seeding_seconds,
            direct_seconds: report.direct_seconds,
            mutation_seconds: report.mutation_seconds,
            chains: report.chains,
            life: report.life,
            b: report.b,
            b_relative_error: report.b_relative_error,
            seeding_samples: report.seeding_samples,
            diagnostics: Diagnostics::new(&report.mixing),
            mutation_statistics: report.statistics.iter().map(MutationStats::new).collect(),
            faults: report.faults.iter().map(|record| fault(record, &report.statistics)).collect(),
        }
    }
}

fn rate(count: u64, seconds: f64) -> f64 {
    if seconds > 0.0 { count as f64 / seconds } else { 0.0 }
}

impl Stats {
    /// The facts of a render.
    pub fn new(source: &Source, settings: &Settings, rendering: &Rendering, interrupted: bool) -> Self {
        Self {
            format: STATS_FORMAT,
            version: env!("CARGO_PKG_VERSION").into(),
            scene: source.name.clone(),
            method: settings.method.name().into(),
            interrupted,
            width: settings.film_size().0,
            height: settings.film_size().1,
            seed: settings.seed,
            wall_seconds: rendering.seconds,
            threads: rendering.threads,
            instructions: rendering.instructions.into(),
            effects: PlanStats::new(&source.plan, source.scene.repertoire(), &settings.mlt.mutations),
            census: source.census.clone(),
            warnings: source.warnings.clone(),
            notes: source.notes.clone(),
            samples_per_pixel: rendering.samples_per_pixel,
            rays: rendering.counts.rays,
            rays_per_second: rate(rendering.counts.rays, rendering.seconds),
            mean: rendering.picture.mean().to_array(),
            stability: StabilityStats::new(rendering),
            mlt: rendering.mlt.as_ref().map(MltStats::new),
            config: config::to_ron(settings),
        }
    }

    /// As JSON.
    pub fn to_json(&self) -> Result<Vec<u8>, serde_json::Error> {
        serde_json::to_vec_pretty(self)
    }
}

/// What people want to know first.
pub fn summary(rendering: &Rendering) -> Vec<String> {
    let [r, g, b] = rendering.picture.mean().to_array();
    let mut lines = vec![format!(
        "{} in {}: {} {} a pixel, {} rays/s on {} {}, mean radiance {r:.4} {g:.4} {b:.4}",
        rendering.method.name(),
        human_time(rendering.seconds),
        table::count(rendering.samples_per_pixel),
        if rendering.mlt.is_some() { "mutations" } else { "samples" },
        table::count(rate(rendering.counts.rays, rendering.seconds)),
        rendering.threads,
        if rendering.threads == 1 { "thread" } else { "threads" },
    )];
    if let Some(report) = &rendering.mlt {
        lines.push(format!(
            "b = {:.5} +- {:.2} % from {} samples in {}; {} mutations/s in {} chains{}",
            report.b,
            report.b_relative_error * 100.0,
            table::count(report.seeding_samples as f64),
            human_time(report.seeding_seconds),
            table::count(rate(report.mutations, report.mutation_seconds)),
            report.chains,
            report.life.map_or_else(String::new, |life| format!(" that begin anew after {life}")),
        ));
        lines.push(String::new());
        lines.extend(mutation_table(report));
        lines.push(String::new());
        lines.extend(mixing_table(&report.mixing));
        lines.extend(report.mixing.warnings.iter().map(|warning| format!("warning: {warning}")));
    }
    lines.push(stability_line(rendering));
    lines
}

fn mixing_table(report: &MixingReport) -> Vec<String> {
    let or_none = |value: Option<f64>, show: &dyn Fn(f64) -> String| value.map_or("-".into(), show);
    let row = |mixing: &Mixing| {
        vec![
            mixing.name.to_string(),
            or_none(mixing.autocorrelation_time, &|v| format!("{v:.0}")),
            or_none(mixing.effective_sample_size, &table::count),
            or_none(mixing.r_hat, &|v| format!("{v:.3}")),
        ]
    };
    let rows: Vec<Vec<String>> = report.quantities.iter().map(row).collect();
    let mut lines = table::lines(&["chains", "autocorrelation steps", "effective samples", "R-hat"], &rows);
    if let Some(stay) = report.longest_stay {
        lines.push(format!("longest stay {} steps, at a path {}", stay.steps, stay.class));
    }
    lines
}

fn mutation_table(report: &MltReport) -> Vec<String> {
    let row = |statistics: &MutationStatistics| {
        let tally = statistics.total();
        let share = |n: u64| n as f64 / tally.proposed.max(1) as f64;
        let unbuilt: u64 = tally.not_built.iter().sum();
        let mut reasons: Vec<_> = Rejection::ALL.iter().zip(tally.not_built).filter(|(_, n)| *n > 0).collect();
        reasons.sort_by_key(|(_, n)| std::cmp::Reverse(*n));
        let reasons =
            reasons.iter().take(2).map(|(reason, n)| format!("{} {}", reason.name(), table::percent(share(*n))));
        let or_none = |value: Option<f64>, digits: usize| value.map_or("-".into(), |v| format!("{v:.digits$}"));
        vec![
            statistics.name.to_string(),
            table::count(tally.proposed as f64),
            if tally.proposed > 0 { table::percent(share(tally.proposed - unbuilt)) } else { "-".into() },
            tally.acceptance().map_or("-".into(), table::percent),
            or_none(tally.mean_jump_pixels(), 1),
            or_none(tally.ns_per_proposal(), 0),
            tally.faulty.iter().sum::<u64>().to_string(),
            reasons.collect::<Vec<_>>().join(", "),
        ]
    };
    let rows: Vec<Vec<String>> = report.statistics.iter().map(row).collect();
    let head = ["mutation", "proposed", "built", "accepted", "jump px", "ns", "faulty", "not built because"];
    table::lines(&head, &rows)
}
