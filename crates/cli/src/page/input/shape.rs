//! What the page takes from the JSON of a run, by type, so that what is missing is said before a browser stumbles over it.
//!
//! Fields that are read by the page's script only are here for the check alone.

#![allow(dead_code, reason = "the types are the check")]

use std::collections::BTreeMap;

use serde::Deserialize;

/// STEM.stats.json.
#[derive(Deserialize)]
pub struct StatsShape {
    pub scene: String,
    pub method: String,
    pub interrupted: bool,
    pub width: u32,
    pub height: u32,
    pub seed: u64,
    pub wall_seconds: f64,
    pub samples_per_pixel: f64,
    pub config: String,
    pub warnings: Vec<String>,
    pub notes: Vec<String>,
    census: Vec<Census>,
    stability: Stability,
    diagnostics: Option<Diagnostics>,
    pub mutation_statistics: Option<Vec<Mutation>>,
}

#[derive(Deserialize)]
struct Census {
    effect: String,
    found: bool,
    place: String,
    consequence: String,
}

#[derive(Deserialize)]
struct Stability {
    total: u64,
}

#[derive(Deserialize)]
struct Diagnostics {
    quantities: Vec<Quantity>,
    longest_stay: u64,
    stuck_chains: u64,
    warnings: Vec<String>,
}

#[derive(Deserialize)]
struct Quantity {
    name: String,
    autocorrelation_time: Option<f64>,
    r_hat: Option<f64>,
    autocorrelation: Vec<AtLag>,
}

#[derive(Deserialize)]
struct AtLag {
    lag: u64,
    correlation: f64,
}

/// A mutation and its tallies.
#[derive(Deserialize)]
pub struct Mutation {
    name: String,
    #[serde(flatten)]
    total: Tally,
    jumps: Vec<Jump>,
    by_length: BTreeMap<String, Tally>,
    by_class: BTreeMap<String, Tally>,
}

#[derive(Deserialize)]
struct Tally {
    proposed: u64,
    not_built: BTreeMap<String, u64>,
    faulty: u64,
    accepted: u64,
    acceptance: Option<f64>,
    mean_jump_pixels: Option<f64>,
    ns_per_proposal: Option<f64>,
}

#[derive(Deserialize)]
struct Jump {
    from_pixels: f64,
    to_pixels: Option<f64>,
    share: f64,
}

/// STEM.json of an accuracy run.
#[derive(Deserialize)]
pub struct AccuracyShape {
    pub scene: String,
    config: String,
    replicas: u64,
    pub reference: Reference,
    pub methods: Vec<MethodShape>,
    crossings: Vec<Crossing>,
    best: Option<String>,
    advice: String,
}

/// What was compared with.
#[derive(Deserialize)]
pub struct Reference {
    pub file: String,
    origin: String,
}

/// One method of an accuracy run.
#[derive(Deserialize)]
pub struct MethodShape {
    pub name: String,
    pub picture: Option<Picture>,
    points: Vec<Point>,
    slope: Option<Interval>,
    efficiency_relative_to_the_best: Option<Interval>,
    time_to_reach: Vec<TimeToReach>,
}

/// A picture that was kept.
#[derive(Deserialize)]
pub struct Picture {
    pub file: String,
    pub replica: u64,
    pub budget_seconds: f64,
    seconds: f64,
    rel_mse: f64,
    trimmed_rel_mse: f64,
    mse: f64,
    flip: f64,
    bias: f64,
}

#[derive(Deserialize)]
struct Point {
    budget_seconds: f64,
    replicas: Option<u64>,
    seconds: f64,
    rel_mse: Interval,
    trimmed_rel_mse: Interval,
    mse: Interval,
    flip: Interval,
    bias: Option<Interval>,
}

#[derive(Deserialize)]
struct Interval {
    value: f64,
    low: f64,
    high: f64,
    error: f64,
}

#[derive(Deserialize)]
struct TimeToReach {
    rel_mse: f64,
    seconds: Option<Interval>,
}

#[derive(Deserialize)]
struct Crossing {
    late: String,
    early: String,
    seconds: Interval,
}
