//! Samples that b is estimated from: what they cost, and the error of b.

use ergodic_assess::accuracy::{Curve, Interval, Sample, mean};
use ergodic_pathspace::Roulette;
use ergodic_render::{Seeding, Seeds, Unobserved};

use super::Effort;
use super::page::{Section, cell, table};
use super::work::{Work, on_one_thread, spread, timed};

const SCENES: [&str; 2] = ["ring", "glass"];
/// Samples of the smallest seeding, the least that there can be; the others have 2, 4 and 8 times as many.
const SAMPLES: u64 = 16_384;
const LEVELS: u32 = 4;

/// One estimate of b.
#[derive(Clone, Copy)]
struct Estimate {
    b: f64,
    told: f64,
    seconds: f64,
}

fn estimates(work: &Work, samples: u64, first: u64, replicas: usize) -> Result<Vec<Estimate>, String> {
    let settings = &work.settings;
    let roulette = Roulette { start: settings.roulette.start, survival: settings.roulette.survival };
    let seeding = Seeding { relative_error: 1e-9, max_samples: samples };
    on_one_thread(|| {
        let draw = |seed| {
            let (seeds, seconds) =
                timed(|| Seeds::draw(&work.scene, settings.lengths(), roulette, &seeding, seed, &Unobserved));
            Estimate { b: seeds.b, told: seeds.relative_error, seconds }
        };
        (first..).take(replicas).map(draw).collect()
    })
}

fn centre_of(estimates: &[Estimate]) -> f64 {
    estimates.iter().map(|e| e.b).sum::<f64>() / estimates.len() as f64
}

/// Measures both scenes.
pub fn measure(effort: &Effort) -> Result<Section, String> {
    let levels = if effort.divisor > 1 { LEVELS - 1 } else { LEVELS };
    let mut rows = Vec::new();
    let mut slopes = Vec::new();
    for name in SCENES {
        let work = Work::new(name)?;
        let mut points = Vec::new();
        for level in 0..levels {
            let samples = SAMPLES << level;
            let all = estimates(&work, samples, u64::from(level) << 32, effort.replicas)?;
            rows.push(vec![
                format!("`{name}`"),
                samples.to_string(),
                cell(mean(&all.iter().map(|e| e.seconds).collect::<Vec<_>>())),
                cell(spread(&all.iter().map(|e| e.b / centre_of(&all)).collect::<Vec<_>>()).map(percent)),
                cell(mean(&all.iter().map(|e| e.told).collect::<Vec<_>>()).map(percent)),
            ]);
            points.push(all);
        }
        // Deviations from the mean of all, which has the least error.
        let n = points.iter().enumerate().map(|(i, p)| (p.len() << i) as f64).sum::<f64>();
        let centre =
            points.iter().enumerate().map(|(i, p)| p.iter().map(|e| e.b).sum::<f64>() * f64::from(1 << i)).sum::<f64>()
                / n;
        let sample = |e: &Estimate| Sample { seconds: e.seconds, error: (e.b - centre).powi(2) };
        let curve =
            Curve { name: name.into(), points: points.iter().map(|p| p.iter().map(sample).collect()).collect() };
        // Of squares, so twice that of the standard error.
        let slope = curve.slope().map(|slope| scaled(slope, 0.5));
        slopes.push(format!("{} in `{name}`", cell(slope)));
    }
    Ok(Section {
        title: "Seeding effort against the error of b",
        parts: vec![
            format!(
                "b, the mean luminance over the image, scales the whole picture of the chains, so its relative error is that of the \
                 picture's\nbrightness. It comes from independent samples, {} replicas each. *Over replicas* is what it is; *told* \
                 is what a single seeding says of\nitself, as in `b_relative_error`.",
                effort.replicas
            ),
            table(&["scene", "samples", "seconds", "standard error over replicas, %", "told, %"], &rows),
            format!(
                "The standard error falls as a power of time, with the exponent {}; -1/2 is what independent samples must\ngive. Half \
                 the error costs four times the time.",
                slopes.join(" and ")
            ),
        ],
    })
}

fn scaled(mut interval: Interval, factor: f64) -> Interval {
    interval.value *= factor;
    interval.low *= factor;
    interval.high *= factor;
    interval.error *= factor;
    interval
}

fn percent(interval: Interval) -> Interval {
    scaled(interval, 100.0)
}
