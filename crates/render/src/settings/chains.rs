//! Settings of Markov chains: Metropolis light transport, and primary sample space.

use ergodic_mutations::AnyMutation;
use ergodic_pathspace::Effects;
use serde::{Deserialize, Serialize};

use crate::chains::GREATEST_SHARE;
use crate::primary::PrimaryMutation;

/// The greatest number of samples of a seeding, so that 32 bits count them.
pub(crate) const MOST_SEEDS: u64 = 1 << 31;

/// Settings of Metropolis light transport.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MltSettings {
    /// The mixture: weights and mutations.
    pub mutations: Vec<(f64, AnyMutation)>,
    /// Number of independent chains at once; within a budget of time fewer, 16 at least, if else they would not have a whole
    /// life each.
    pub chains: usize,
    /// When a chain begins anew from another start.
    pub life: Life,
    /// Whether the chains' target is luminance over the brightness of the image, as a first stage of few samples saw it, and not luminance
    /// itself, so that dark parts get as good as bright ones.
    pub two_stage: bool,
    /// Light that arrives by at most one bounce.
    pub direct: Direct,
    /// The independent samples that estimate b and start the chains.
    pub seeding: Seeding,
    /// Share of the work that seeding has, and that direct light has, at most a quarter. Of a budget of time it is what they get, or
    /// with 0 what they need and at most a quarter; where the budget is in mutations, it is the least share of the time that these are
    /// expected to take.
    pub share: f64,
    /// Whether to keep numbers for each pixel: acceptance, standard error, longest stay.
    pub layers: bool,
}

/// Steps through primary sample space.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct PrimarySettings {
    /// What pssmlt makes of a point.
    pub sampler: PrimarySampler,
    /// Probability of a large step, in (0, 1].
    pub large_step: f64,
    /// Smallest move of a coordinate by a small step.
    pub min_step: f64,
    /// Largest move, less than 1/2.
    pub max_step: f64,
    /// What [`MltSettings::share`] is for paths; less will do, since large steps find what seeds did not.
    pub share: f64,
}

/// What makes a sample of a point of primary sample space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum PrimarySampler {
    /// Path tracing with next-event estimation.
    Path,
    /// Bidirectional path tracing.
    Bidirectional,
}

/// When chains begin anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Life {
    /// There are as many lives as the seeds are worth: of those whose mean has a relative error e, 1/e².
    Auto,
    /// After so many mutations.
    Mutations(u64),
    /// Never.
    Endless,
}

/// Who renders paths of one and two edges.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum Direct {
    /// The chains, like all others.
    InChain,
    /// Bidirectional sampling of its own, with this many samples a pixel.
    Separate {
        /// Samples a pixel.
        samples_per_pixel: u32,
    },
}

/// How b is estimated.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Seeding {
    /// Relative standard error of b at which seeding ends.
    pub relative_error: f64,
    /// Seeding also ends after this many samples; the error reached is reported.
    pub max_samples: u64,
}

impl Default for PrimarySettings {
    /// The sizes are those of Kelemen et al. (2002).
    fn default() -> Self {
        Self {
            sampler: PrimarySampler::Bidirectional,
            large_step: 0.3,
            min_step: 1.0 / 1024.0,
            max_step: 1.0 / 64.0,
            share: 0.1,
        }
    }
}

impl Default for MltSettings {
    fn default() -> Self {
        Self {
            mutations: AnyMutation::default_mixture(),
            chains: 512,
            life: Life::Auto,
            two_stage: true,
            direct: Direct::Separate { samples_per_pixel: 32 },
            seeding: Seeding::default(),
            share: 0.2,
            layers: false,
        }
    }
}

impl Default for Seeding {
    fn default() -> Self {
        Self { relative_error: 0.005, max_samples: 4_000_000 }
    }
}

impl PrimarySettings {
    /// The mixture of large and small steps.
    pub(crate) fn mutations<E>(&self) -> Vec<(f64, PrimaryMutation<E>)> {
        let small = PrimaryMutation::small(self.min_step, self.max_step);
        vec![(self.large_step, PrimaryMutation::Large), (1.0 - self.large_step, small)]
    }

    pub(super) fn validate(&self) -> Result<(), String> {
        if !(self.large_step > 0.0 && self.large_step <= 1.0) {
            return Err(format!(
                "primary.large_step is {}; it must be in (0, 1], because no other step reaches everything",
                self.large_step
            ));
        }
        if !(self.min_step >= 1e-12 && self.min_step < self.max_step && self.max_step < 0.5) {
            return Err(format!(
                "primary.min_step is {} and max_step {}; they must satisfy 1e-12 <= min_step < max_step < 0.5",
                self.min_step, self.max_step
            ));
        }
        validate_share("primary.share", self.share)
    }
}

fn validate_share(name: &str, share: f64) -> Result<(), String> {
    if !(0.0..=GREATEST_SHARE).contains(&share) {
        return Err(format!("{name} is {share}; it must be from 0 to {GREATEST_SHARE}"));
    }
    Ok(())
}

impl MltSettings {
    /// The mixture without the mutations of weight 0 and those that can change no path of a scene with these effects.
    pub fn mutations_for(&self, effects: Effects) -> Vec<(f64, AnyMutation)> {
        let used =
            |(weight, mutation): &&(f64, AnyMutation)| *weight > 0.0 && mutation.never_applies(effects).is_none();
        self.mutations.iter().filter(used).copied().collect()
    }

    pub(super) fn validate(&self) -> Result<(), String> {
        if !(1..=1 << 20).contains(&self.chains) {
            return Err(format!("mlt.chains is {}; it must be from 1 to {}", self.chains, 1 << 20));
        }
        if self.life == Life::Mutations(0) {
            return Err("mlt.life is Mutations(0); give 1 at least, or Endless for chains that never begin anew".into());
        }
        if let Direct::Separate { samples_per_pixel: 0 } = self.direct {
            return Err("mlt.direct: Separate has 0 samples_per_pixel; give at least 1, or use InChain".into());
        }
        if !(self.seeding.relative_error > 0.0 && self.seeding.relative_error.is_finite()) {
            return Err(format!(
                "mlt.seeding.relative_error is {}; it must be greater than 0",
                self.seeding.relative_error
            ));
        }
        if !(1000..=MOST_SEEDS).contains(&self.seeding.max_samples) {
            let given = self.seeding.max_samples;
            return Err(format!("mlt.seeding.max_samples is {given}; it must be from 1000 to {MOST_SEEDS}"));
        }
        validate_share("mlt.share", self.share)?;
        for (i, (weight, mutation)) in self.mutations.iter().enumerate() {
            if !(weight.is_finite() && *weight >= 0.0) {
                return Err(format!("mlt.mutations[{i}] has weight {weight}; weights are finite and not negative"));
            }
            mutation.validate().map_err(|what| format!("mlt.mutations[{i}] ({}): {what}", mutation.name()))?;
        }
        let ergodic = |(weight, mutation): &(f64, AnyMutation)| *weight > 0.0 && mutation.is_ergodic();
        if !self.mutations.iter().any(ergodic) {
            return Err(
                "mlt.mutations needs Bidirectional with a positive weight: no other mutation reaches every path, \
                        so without it the picture would be wrong"
                    .into(),
            );
        }
        Ok(())
    }
}
