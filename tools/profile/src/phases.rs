//! Shares of time by phase: while one thread makes mutations, another looks again and again at which phase it is in.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use ergodic_geometry::phase::{self, Phase};
use ergodic_scattering::Repertoire;
use serde_json::{Value, json};

use crate::work::{MUTATIONS, Work, median, per_mutation, rounds};

/// Time between two looks; the system adds to it. Some tens of mutations, so that looks are as good as independent.
const INTERVAL: Duration = Duration::from_micros(50);

/// How often each phase was seen while `work` went on in this thread.
fn watched(work: impl FnOnce()) -> [u64; Phase::ALL.len()] {
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        let watcher = scope.spawn(|| {
            let mut seen = [0; Phase::ALL.len()];
            while !done.load(Ordering::Relaxed) {
                thread::sleep(INTERVAL);
                seen[phase::current() as usize] += 1;
            }
            seen
        });
        {
            // Seeding had many threads, which leave the mark anywhere.
            let _phase = phase::enter(Phase::Bookkeeping);
            work();
        }
        done.store(true, Ordering::Relaxed);
        watcher.join().unwrap_or_default()
    })
}

/// Measures for some seconds.
pub fn measure<R: Repertoire>(work: &Work<R>, seconds: f64) -> Value {
    let rounds = rounds(seconds, || {
        work.round(|mutate| {
            let mut nanoseconds = 0.0;
            let seen = watched(|| nanoseconds = per_mutation(mutate));
            (nanoseconds, seen)
        })
    });
    let seen = |phase: Phase| rounds.iter().map(|(_, seen)| seen[phase as usize]).sum::<u64>();
    let looks: u64 = Phase::ALL.into_iter().map(seen).sum();
    let mutation = median(rounds.iter().map(|(nanoseconds, _)| *nanoseconds));
    let phases: Vec<Value> = Phase::ALL
        .into_iter()
        .map(|phase| {
            let share = seen(phase) as f64 / looks as f64;
            let error = (share * (1.0 - share) / looks as f64).sqrt();
            json!({ "phase": phase.name(), "share": share, "standard_error": error, "ns": share * mutation })
        })
        .collect();
    json!({
        "mutations": MUTATIONS,
        "rounds": rounds.len(),
        "looks": looks,
        "mutation_ns": mutation,
        "phases": phases,
    })
}
