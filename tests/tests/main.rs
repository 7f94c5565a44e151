//! Cross-crate tests: one binary, so that they share one build.

mod cameras;
mod closed_forms;
mod coverage;
mod dispersion;
mod effects;
mod environment;
mod exact_rank;
mod image_faults;
mod lens_subpaths;
mod media;
mod mutation_laws;
mod numerics;
mod primary_laws;
mod rendering;
mod repertoires;
mod strategies;
mod time_budgets;
mod two_stage;
mod volume_laws;
