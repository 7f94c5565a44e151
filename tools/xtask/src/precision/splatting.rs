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

/// Mean over pixels of the variance over replicas, relative to the squared mean with a floor.
fn variance(pictures: &[Vec<f64>], indices: &[usize], weights: &[f64]) -> f64 {
    let n = indices.len() as f64;
    let of_pixel = |(pixel, weight): (usize, &f64)| {
        let (sum, squares) =
            indices.iter().map(|i| pictures[*i][pixel]).fold((0.0, 0.0), |(s, q), v| (s + v, q + v * v));
        weight * (squares - sum * sum / n) / (n - 1.0)
    };
    weights.iter().enumerate().map(of_pixel).sum::<f64>() / weights.len() as f64
}

/// 1 / (mean² + floor) of each pixel over all replicas; the floor is a hundredth of the squared mean of the picture.
fn weights(pictures: &[Vec<f64>]) -> Vec<f64> {
    let n = pictures.len() as f64;
    let pixels = pictures.first().map_or(0, Vec::len);
    let means: Vec<f64> =
        (0..pixels).map(|pixel| pictures.iter().map(|picture| picture[pixel]).sum::<f64>() / n).collect();
    let whole = means.iter().sum::<f64>() / pixels as f64;
    means.iter().map(|mean| 1.0 / (mean * mean + 0.01 * whole * whole)).collect()
}

/// Measures all scenes.
pub fn measure(effort: &Effort) -> Result<Section, String> {
    let mut rows = Vec::new();
    for name in SCENES {
        let all = replicas(name, effort)?;
        let [expected, plain] = &all.pictures;
        let weights = weights(expected);
        let of = |pictures: &Vec<Vec<f64>>, indices: &[usize]| variance(pictures, indices, &weights);
        let variances = resampled(effort.replicas, |indices| Some(of(plain, indices) / of(expected, indices)));
        let efficiency = resampled(effort.replicas, |indices| {
            let seconds = |way: usize| indices.iter().map(|i| all.seconds[way][*i]).sum::<f64>();
            Some(of(plain, indices) * seconds(1) / (of(expected, indices) * seconds(0)))
        });
        let mutations = (CHAINS as u64 * (STEPS / effort.divisor)) as f64;
        let each = all.seconds[0].iter().map(|seconds| seconds * 1e9 / mutations).collect::<Vec<_>>();
        rows.push(vec![
            format!("`{name}`"),
            cell(mean(&each)),
            cell(ratio(&all.seconds[0], &all.seconds[1])),
            cell(variances),
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
