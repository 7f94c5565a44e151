//! Light of one and two edges: sampled apart, or by the chains like all other.

use ergodic_assess::accuracy::{ratio, resampled};
use ergodic_assess::{Image, compare};
use ergodic_render::{Budget, Direct, Seeding, Settings, Unobserved, render};

use super::Effort;
use super::page::{Section, cell, table};
use super::work::Work;

const SCENES: [&str; 3] = ["cornell", "ring", "ajar"];
/// Mutations a pixel.
const MUTATIONS: f64 = 256.0;
const SEEDING: Seeding = Seeding { relative_error: 0.005, max_samples: 65_536 };
const WAYS: [Direct; 2] = [Direct::Separate { samples_per_pixel: 32 }, Direct::InChain];

/// Errors and times of replicas by way.
struct Pairs {
    errors: [Vec<f64>; 2],
    seconds: [Vec<f64>; 2],
}

fn pairs(work: &Work, effort: &Effort) -> Result<Pairs, String> {
    let noise = work.noise();
    let mut pairs = Pairs { errors: [Vec::new(), Vec::new()], seconds: [Vec::new(), Vec::new()] };
    for seed in 0..effort.pairs {
        for way in [seed % 2, 1 - seed % 2] {
            let mut settings = Settings {
                seed: seed as u64,
                budget: Budget::SamplesPerPixel(MUTATIONS / effort.divisor as f64),
                ..work.settings.clone()
            };
            settings.mlt.seeding = Seeding { max_samples: SEEDING.max_samples / effort.divisor, ..SEEDING };
            settings.mlt.direct = WAYS[way];
            let rendering = render(&work.scene, &settings, &Unobserved).map_err(|e| e.to_string())?;
            let (width, height) = settings.size;
            let pixels = rendering.picture.pixels.iter().map(|pixel| pixel.to_array()).collect();
            let comparison = compare(&Image { width, height, pixels }, &work.reference.mean)?;
            pairs.errors[way].push(comparison.rel_mse - noise);
            pairs.seconds[way].push(rendering.processor_seconds);
        }
    }
    Ok(pairs)
}

/// Measures all scenes.
pub fn measure(effort: &Effort) -> Result<Section, String> {
    let mut rows = Vec::new();
    for name in SCENES {
        let Pairs { errors, seconds } = pairs(&Work::new(name)?, effort)?;
        let equal_time = resampled(effort.pairs, |indices| {
            let sum = |values: &[f64]| indices.iter().map(|i| values[*i]).sum::<f64>();
            Some(sum(&errors[1]) * sum(&seconds[1]) / (sum(&errors[0]) * sum(&seconds[0])))
        });
        rows.push(vec![
            format!("`{name}`"),
            cell(ergodic_assess::accuracy::mean(&errors[0])),
            cell(ergodic_assess::accuracy::mean(&errors[1])),
            cell(ratio(&seconds[0], &seconds[1])),
            cell(equal_time),
        ]);
    }
    Ok(Section {
        title: "Direct light, apart or in the chains",
        parts: vec![
            format!(
                "By default paths of one and two edges are sampled apart, with 32 samples a pixel or more (`mlt.direct`), and the chains need not \
                 find them. {}\npairs of renders of 64 x 64 pixels, {} mutations a pixel each, against the stored references. The last \
                 column is the ratio at equal time: of\nrelMSE times processor time, seeding and direct light included. Above 1, apart \
                 is better.",
                effort.pairs,
                MUTATIONS / effort.divisor as f64
            ),
            table(
                &[
                    "scene",
                    "relMSE, apart",
                    "relMSE, in the chains",
                    "time, apart over in the chains",
                    "relMSE at equal time, in the chains over apart",
                ],
                &rows,
            ),
        ],
    })
}
