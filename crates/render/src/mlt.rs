//! Metropolis light transport (Veach 11): seeds, and chains of paths that start from them.

use std::time::Instant;

use ergodic_metropolis::{Mixture, Mutation};
use ergodic_mutations::{Rejection, Splice};
use ergodic_pathspace::{Path, PathSpace, Scene};
use ergodic_scattering::Repertoire;

use crate::chain_runner::{ChainRunner, ChainStep, FaultRecord, Pictured};
use crate::chains::{self, Rendered, chain_lengths, seeding_effort, until, until_part};
use crate::first_stage::{PART_OF_SEEDING, brightness};
use crate::observer::{Observer, Unobserved};
use crate::seeding::Seeds;
use crate::starts::Seed;
use crate::streams::{Purpose, stream};
use crate::{RenderError, Settings};

/// Renders with any mixture of path mutations; `names` has one entry for each member.
pub(crate) fn render<R, M>(
    scene: &Scene<R>,
    settings: &Settings,
    mixture: &Mixture<M>,
    names: &[&'static str],
    start: Instant,
    observer: &dyn Observer,
) -> Result<Rendered, RenderError>
where
    R: Repertoire,
    M: Mutation<Space = PathSpace<R>, State = Path<R>, Plan = Splice, Failure = Rejection> + Sync,
{
    let lengths = chain_lengths(settings);
    let watch = until(settings, start, observer);
    let roulette = settings.roulette.roulette();
    let effort = seeding_effort(settings, start);
    let (brightness, counts) = brightness(scene, settings, &until_part(settings, start, observer, PART_OF_SEEDING));
    let mut seeds = Seeds::draw_for(scene, brightness.as_deref(), (lengths, roulette), effort, settings.seed, &watch);
    seeds.counts += counts;
    let begin = |seeds: &Seeds, seed: &Seed| seeds.path(scene, seed);
    let seeding_seconds = start.elapsed().as_secs_f64();
    let chains = chains::Start { seeds, brightness, seeding_seconds, begin, splats_per_step: 1 };
    let space = PathSpace { scene: scene.clone(), lengths };
    chains::render(scene, settings, chains, (mixture, &space), names, start, observer)
}

/// A step of a chain seen again.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// The chain before the step.
    pub before: ChainRunner,
    /// The chain after it; [`ChainRunner::candidate`] is what was proposed.
    pub after: ChainRunner,
    /// What the step came to.
    pub step: ChainStep,
}

/// Runs one chain again, alone, up to the given step, for looking at a fault.
///
/// `None` if there is no such chain.
pub fn replay<M>(scene: &Scene, settings: &Settings, mixture: &Mixture<M>, record: &FaultRecord) -> Option<Replayed>
where
    M: Mutation<Space = PathSpace, State = Path, Plan = Splice, Failure = Rejection>,
{
    let (lengths, chains) = (chain_lengths(settings), settings.mlt.chains);
    let roulette = settings.roulette.roulette();
    let effort = seeding_effort(settings, Instant::now());
    let (brightness, _) = brightness(scene, settings, &Unobserved);
    let seeds = Seeds::draw_for(scene, brightness.as_deref(), (lengths, roulette), effort, settings.seed, &Unobserved);
    let (generation, slot) = (record.chain / chains as u64, (record.chain % chains as u64) as usize);
    let start = seeds.path(scene, seeds.chosen(generation, chains).get(slot)?);
    let space = PathSpace { scene: scene.clone(), lengths };
    let (target, rng) = (Path::target(brightness), stream(settings.seed, Purpose::Chain, record.chain));
    let mut after = ChainRunner::with_target(target, record.chain, start, rng);
    for _ in 0..record.step {
        after.step(mixture, &space);
    }
    let before = after.clone();
    let step = after.step(mixture, &space);
    Some(Replayed { before, after, step })
}
