//! Mutations against their rays alone: every ray of a round is recorded, then rounds of mutations and of the recorded rays, traced
//! again in the same order, take turns.

use std::hint::black_box;

use ergodic_pathspace::record::{Question, recorded};
use ergodic_scattering::Repertoire;
use serde_json::{Value, json};

use crate::work::{MUTATIONS, Work, median, per_mutation, rounds};

/// Measures for some seconds.
pub fn measure<R: Repertoire>(work: &Work<R>, seconds: f64) -> Value {
    let questions = work.round(|mutate| recorded(mutate));
    let world = work.scene().world();
    let closest = questions.iter().filter(|question| matches!(question, Question::Closest(_))).count();
    let hits = questions.iter().filter(|question| question.ask(world)).count();
    let rounds = rounds(seconds, || {
        let plain = work.round(|mutate| per_mutation(mutate));
        let bare = per_mutation(|| {
            black_box(questions.iter().filter(|question| question.ask(world)).count());
        });
        (plain, bare)
    });
    let a_mutation = |count: usize| count as f64 / MUTATIONS as f64;
    let ratios = || rounds.iter().map(|(plain, bare)| plain / bare);
    json!({
        "mutations": MUTATIONS,
        "rounds": rounds.len(),
        "closest_per_mutation": a_mutation(closest),
        "any_per_mutation": a_mutation(questions.len() - closest),
        "hit_share": hits as f64 / questions.len() as f64,
        "mutation_ns": median(rounds.iter().map(|(plain, _)| *plain)),
        "bare_rays_ns": median(rounds.iter().map(|(_, bare)| *bare)),
        "ratio": median(ratios()),
        "least_ratio": ratios().fold(f64::INFINITY, f64::min),
        "most_ratio": ratios().fold(0.0, f64::max),
    })
}
