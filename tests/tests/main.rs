//! Cross-crate tests: one binary, so that they share one build.

mod closed_forms;
mod image_faults;
mod mutation_laws;
mod rendering;
mod strategies;
mod units;
mod volume_laws;
