//! Exclusive time by phase. Rounds with the clock of phases and rounds without take turns.

use ergodic_geometry::phase::{self, Phase, Tally};
use serde_json::{Value, json};

use crate::work::{MUTATIONS, Work, median, rounds};

/// One round with the clock, beside one without.
struct Round {
    tally: Tally,
    /// Nanoseconds a mutation without the clock.
    plain: f64,
    /// The clock's own time over what its calibration predicts.
    scale: f64,
}

impl Round {
    fn new(work: &Work) -> Self {
        let plain = work.plain();
        let tally = work.round(|mutate| phase::measure(mutate));
        let sum = |times: &[f64]| times.iter().sum::<f64>() / MUTATIONS as f64;
        // In a mutation the clock costs less than in the empty loop of its calibration, where nothing else runs beside it. What
        // it costs in all is known from the round without it.
        let scale = (sum(&tally.raw) - plain) / sum(&tally.overhead);
        Self { tally, plain, scale }
    }

    /// Nanoseconds a mutation that a phase takes, without the clock.
    fn time(&self, phase: Phase) -> f64 {
        let i = phase as usize;
        (self.tally.raw[i] - self.scale * self.tally.overhead[i]) / MUTATIONS as f64
    }
}

/// Measures for some seconds.
pub fn measure(work: &Work, seconds: f64) -> Value {
    let rounds = rounds(seconds, || Round::new(work));
    let plain = median(rounds.iter().map(|round| round.plain));
    let phases: Vec<Value> = Phase::ALL
        .into_iter()
        .map(|phase| {
            let time = median(rounds.iter().map(|round| round.time(phase)));
            let entries = rounds[0].tally.entries[phase as usize] as f64 / MUTATIONS as f64;
            json!({ "phase": phase.name(), "ns": time, "share": time / plain, "entries": entries })
        })
        .collect();
    json!({
        "mutations": MUTATIONS,
        "rounds": rounds.len(),
        "mutation_ns": plain,
        "with_clock_ns": median(rounds.iter().map(|round| round.tally.raw.iter().sum::<f64>() / MUTATIONS as f64)),
        "clock_over_calibration": median(rounds.iter().map(|round| round.scale)),
        "phases": phases,
    })
}
