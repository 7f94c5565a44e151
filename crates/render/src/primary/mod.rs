//! Metropolis light transport in primary sample space (Kelemen et al. 2002): the state is the numbers that a sample was made from.
//!
//! A sampler that turns a list of numbers in [0, 1) into light on the image needs no other change: the numbers are the coordinates of
//! a point of the unit cube, and the chain moves through the cube, where densities are trivial. The price is that a mutation
//! cannot say what it wants to keep. The samplers are those of independent sampling: path tracing, bidirectional path tracing, and
//! multiplexed sampling (Hachisuka et al. 2014), which makes one path by one strategy, both chosen by coordinates.
//!
//! `coordinates` is the point, `mutation` the large and the small step, `multiplexed` that sampler, `pictured` what
//! a chain leaves of a sample on the film, `seeds` what it starts from.

mod coordinates;
mod multiplexed;
mod mutation;
mod pictured;
mod seeds;

use std::time::Instant;

use ergodic_metropolis::Mixture;
use ergodic_pathspace::Scene;

pub use coordinates::{Coordinates, PrimarySample};
pub use multiplexed::Multiplexed;
pub(crate) use multiplexed::PILOT_PART_OF_SEEDING;
pub use mutation::{PrimaryMutation, PrimarySpace, PrimaryTarget, PrimaryValue};
pub use seeds::Seedable;

use crate::chains::{self, Rendered, chain_lengths, seeding_effort, until, until_part};
use crate::first_stage::{PART_OF_SEEDING, brightness};
use crate::observer::Observer;
use crate::seeding::Seeds;
use crate::starts::Seed;
use crate::streams::{Purpose, stream};
use crate::{RenderError, Settings};

/// Renders by chains over the points that `estimator` makes samples of.
///
/// Seeds are made from samples of the estimator itself, so that b is the mean of just what the chains sample.
pub(crate) fn render<E: Seedable + Sync>(
    scene: &Scene<E::Repertoire>,
    settings: &Settings,
    estimator: &E,
    start: Instant,
    observer: &dyn Observer,
) -> Result<Rendered, RenderError> {
    let mixture = Mixture::new(settings.primary.mutations())?;
    let names: Vec<&str> = mixture.members().iter().map(|(_, mutation)| mutation.name()).collect();
    let space = PrimarySpace { scene: scene.clone() };
    let (brightness, counts) = brightness(scene, settings, &until_part(settings, start, observer, PART_OF_SEEDING));
    let target = PrimaryTarget::new(brightness.clone());
    let mut seeds = Seeds::draw_by(
        || PrimarySample::new(estimator.clone()),
        |sample, _, rng| E::seed(sample, scene, &target, rng),
        scene.camera().size(),
        (chain_lengths(settings), settings.roulette.roulette()),
        seeding_effort(settings, start),
        settings.seed,
        &until(settings, start, observer),
    );
    seeds.counts += counts;
    let begin = |_: &Seeds, seed: &Seed| {
        let mut sample = PrimarySample::new(estimator.clone());
        let mut rng = stream(settings.seed, Purpose::Seeding, u64::from(seed.index));
        E::seed(&mut sample, scene, &target, &mut rng);
        sample
    };
    let chains = chains::Start {
        seeding_seconds: start.elapsed().as_secs_f64(),
        seeds,
        brightness,
        begin,
        // One at the image point, and one for every connection of a vertex to the eye.
        splats_per_step: settings.max_edges as u64 + 1,
    };
    chains::render(scene, settings, chains, (&mixture, &space), &names, start, observer)
}
