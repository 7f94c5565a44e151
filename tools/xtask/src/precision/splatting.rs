//! Expected values against plain splatting: the same chains, seen in two ways.

use ergodic_assess::accuracy::{mean, ratio, resampled};

use super::Effort;
use super::chains::{Chains, Deposit, Starts};
use super::page::{Section, cell, table};
use super::work::{Work, on_one_thread, timed};

const SCENES: [&str; 3] = ["cornell", "ajar", "glass"];
const CHAINS: usize = 32;
const STEPS: u64 = 4096;
const SAMPLES: u64 = 32_768;

/// Replicas of one scene: pictures and times by way of splatting.
struct Replicas {
    pictures: [Vec<Vec<f64>>; 2],
    seconds: [Vec<f64>; 2],
}

const WAYS: [Deposit; 2] = [Deposit::Expected, Deposit::Plain];

fn replicas(name: &str, effort: &Effort) -> Result<Replicas, String> {
    let chains = Chains::new(&Work::new(name)?)?;
    on_one_thread(|| {
        let mut all = Replicas { pictures: [Vec::new(), Vec::new()], seconds: [Vec::new(), Vec::new()] };
        for seed in 0..effort.replicas {
            let ready = chains.ready(seed as u64, CHAINS, SAMPLES / effort.divisor, Starts::Resampled);
            // Turn about in who begins.
            for way in [seed % 2, 1 - seed % 2] {
                let (picture, seconds) = timed(|| chains.run(&ready, STEPS / effort.divisor, WAYS[way]));
                all.pictures[way].push(picture);
                all.seconds[way].push(seconds);
            }
        }
        all
    })
}

/// For each replica the mean over pixels of its squared deviation from the mean of all, relative to the squared mean with a floor.
fn deviations(pictures: &[Vec<f64>], weights: &[f64]) -> Vec<f64> {
    let means = pixel_means(pictures);
    let of = |picture: &Vec<f64>| {
        let pixels = picture.iter().zip(&means).zip(weights);
        pixels.map(|((value, mean), weight)| weight * (value - mean).powi(2)).sum::<f64>() / weights.len() as f64
    };
    pictures.iter().map(of).collect()
}

fn pixel_means(pictures: &[Vec<f64>]) -> Vec<f64> {
    let n = pictures.len() as f64;
    let pixels = pictures.first().map_or(0, Vec::len);
    (0..pixels).map(|pixel| pictures.iter().map(|picture| picture[pixel]).sum::<f64>() / n).collect()
}

/// 1 / (mean² + floor) of each pixel over all replicas; the floor is a hundredth of the squared mean of the picture.
fn weights(pictures: &[Vec<f64>]) -> Vec<f64> {
    let means = pixel_means(pictures);
    let whole = means.iter().sum::<f64>() / means.len() as f64;
    means.iter().map(|mean| 1.0 / (mean * mean + 0.01 * whole * whole)).collect()
}

/// Measures all scenes.
pub fn measure(effort: &Effort) -> Result<Section, String> {
    let mut rows = Vec::new();
    for name in SCENES {
        let all = replicas(name, effort)?;
        let [expected, plain] = &all.pictures;
        let weights = weights(expected);
        let [expected, plain] = [expected, plain].map(|pictures| deviations(pictures, &weights));
        let efficiency = resampled(effort.replicas, |indices| {
            let sum = |values: &[f64]| indices.iter().map(|i| values[*i]).sum::<f64>();
            Some(sum(&plain) * sum(&all.seconds[1]) / (sum(&expected) * sum(&all.seconds[0])))
        });
        let mutations = (CHAINS as u64 * (STEPS / effort.divisor)) as f64;
        let each = all.seconds[0].iter().map(|seconds| seconds * 1e9 / mutations).collect::<Vec<_>>();
        rows.push(vec![
            format!("`{name}`"),
            cell(mean(&each)),
            cell(ratio(&all.seconds[0], &all.seconds[1])),
            cell(ratio(&plain, &expected)),
            cell(efficiency),
        ]);
    }
    Ok(Section {
        title: "Expected values against plain splatting",
        parts: vec![
            format!(
                "A step leaves both the path before and the candidate on the film, weighted by the probability of each (Veach \
                 11.3.2), instead of\nonly the path after it. Both ways are run on the same {CHAINS} chains of {} mutations, \
                 {} replicas; the variance is that of pixels\nover replicas, relative to their squared means.",
                STEPS / effort.divisor,
                effort.replicas
            ),
            table(
                &[
                    "scene",
                    "a mutation with expected values, ns",
                    "time, expected over plain",
                    "variance, plain over expected",
                    "efficiency, expected over plain",
                ],
                &rows,
            ),
            "Expected values never have the greater variance for a single step, as they are the mean over the coin that decides it; \
             over a whole chain\nthe gain is largest where candidates are often refused but likely enough to count, and small where \
             neighbours depend on each other\nfor long anyway."
                .into(),
        ],
    })
}
