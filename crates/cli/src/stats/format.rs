//! The contents of STEM.stats.json: one definition for what writes it and what reads it.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer, Serialize};

use crate::census::{CensusRow, PlanStats};

/// JSON has no infinity: what was not finite is written as null, and is not a number when read.
fn number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Option::deserialize(deserializer).map(|number| number.unwrap_or(f64::NAN))
}

/// The contents of STEM.stats.json.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Stats {
    /// How the file is written: see [`crate::report::STATS_FORMAT`].
    pub format: u64,
    /// Version of the program.
    pub version: String,
    /// The scene's file.
    pub scene: String,
    pub method: String,
    /// Whether the render was stopped before its budget was used up.
    pub interrupted: bool,
    pub width: u32,
    pub height: u32,
    pub seed: u64,
    /// Wall time in seconds, seeding included, loading and writing not.
    pub wall_seconds: f64,
    pub threads: usize,
    /// Instructions that rays were searched with: the best of the processor, or what ERGODIC_ISA names.
    pub instructions: String,
    /// Which effects were rendered, and which were not because the scene does not have them.
    pub effects: PlanStats,
    /// What the scene has of every effect, and what follows.
    pub census: Vec<CensusRow>,
    /// What was said of the scene when it was loaded.
    pub warnings: Vec<String>,
    pub notes: Vec<String>,
    /// Samples, or mutations, for each pixel.
    pub samples_per_pixel: f64,
    pub rays: u64,
    pub rays_per_second: f64,
    /// Mean radiance of the picture, for each channel.
    pub mean: [f64; 3],
    pub stability: StabilityStats,
    /// What the chains found, if the method has any.
    #[serde(flatten)]
    pub mlt: Option<MltStats>,
    /// All settings, in RON.
    pub config: String,
}

/// Contributions that were not finite, or negative, and were left out.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct StabilityStats {
    /// 0 in a correct renderer.
    pub total: u64,
    /// Where independent samples and splats went wrong, and how.
    pub by_place: BTreeMap<String, BTreeMap<String, u64>>,
    /// Proposals whose contribution, density, or density of the way back was no number, or whose contribution was negative.
    pub by_mutation: BTreeMap<String, BTreeMap<String, u64>>,
}

/// What the chains found.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct MltStats {
    /// Over all chains.
    pub mutations: u64,
    /// Over the time spent on mutations, all threads together.
    pub mutations_per_second: f64,
    pub seeding_seconds: f64,
    pub direct_seconds: f64,
    pub mutation_seconds: f64,
    pub chains: usize,
    /// Mutations after which each chain began anew, if ever.
    pub life: Option<u64>,
    /// Mean luminance over the image of the paths that the chains sample.
    pub b: f64,
    /// Not finite if no seed carried light.
    #[serde(deserialize_with = "number")]
    pub b_relative_error: f64,
    pub seeding_samples: u64,
    pub diagnostics: Diagnostics,
    pub mutation_statistics: Vec<MutationStats>,
    /// The first proposals whose densities were not numbers.
    pub faults: Vec<FaultStats>,
}

/// How well the chains mix.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Diagnostics {
    /// ln C, and the image point in pixels.
    pub quantities: Vec<Quantity>,
    /// Longest run of steps that a chain stayed at one path, and the class of that path.
    pub longest_stay: u64,
    pub longest_stay_class: String,
    pub stuck_chains: usize,
    pub warnings: Vec<String>,
}

#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Quantity {
    pub name: String,
    /// Integrated autocorrelation time in steps.
    pub autocorrelation_time: Option<f64>,
    pub effective_sample_size: Option<f64>,
    pub r_hat: Option<f64>,
    /// The autocorrelation function by lag in steps, over the first chains.
    pub autocorrelation: Vec<AtLag>,
}

#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct AtLag {
    pub lag: u64,
    pub correlation: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct MutationStats {
    pub name: String,
    #[serde(flatten)]
    pub total: TallyStats,
    /// How far accepted proposals move on the image.
    pub jumps: Vec<JumpStats>,
    /// By the number of edges of the path that was to be changed.
    pub by_length: BTreeMap<String, TallyStats>,
    /// By the class of that path, such as LSDE, for paths of up to 8 edges.
    pub by_class: BTreeMap<String, TallyStats>,
}

/// The share of the accepted weight whose jump is from one distance up to another.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct JumpStats {
    pub from_pixels: f64,
    /// None: without end.
    pub to_pixels: Option<f64>,
    pub share: f64,
}

#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct TallyStats {
    pub proposed: u64,
    /// Proposals that could not be built, by reason.
    pub not_built: BTreeMap<String, u64>,
    /// Proposals whose densities were not numbers.
    pub faulty: u64,
    pub accepted: u64,
    /// Mean acceptance probability over all proposals; one that was not built counts as 0.
    pub acceptance: Option<f64>,
    /// Mean distance moved on the image by an accepted proposal, in pixels.
    pub mean_jump_pixels: Option<f64>,
    pub ns_per_proposal: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct FaultStats {
    pub chain: u64,
    pub step: u64,
    pub mutation: String,
    pub density: String,
    pub class: String,
}
