//! Many chains in parallel: who runs when, where their splats go, and the picture and report that come of it.

use std::sync::Arc;
use std::time::{Duration, Instant};

use ergodic_metropolis::{Mixture, Mutation};
use ergodic_mutations::Rejection;
use ergodic_pathspace::{BrightnessMap, Lengths, Scene};
use ergodic_scattering::{Repertoire, Rgb};
use rayon::prelude::*;

use crate::bidirectional::BidirectionalPathTracer;
use crate::bins::CAPACITY;
use crate::chain_runner::{ChainRunner, FaultRecord, Ledger, Pictured};
use crate::counts::{Counts, counted};
use crate::layers::{self, LayerSums, Layers};
use crate::lives::{Lives, ROUND};
use crate::mixing::{self, ChainTrace, MixingReport};
use crate::observer::{Observer, Stage, Until};
use crate::sampling::{all, sample_until};
use crate::seeding::{Effort, Seeds};
use crate::starts::Seed;
use crate::statistics::MutationStatistics;
use crate::streams::{Purpose, stream};
use crate::{BATCHES, Budget, Direct, Film, Picture, RenderError, Settings};

// A buffer must take what one chain leaves behind in a round.
const _: () = assert!((ROUND as usize) < CAPACITY);

/// Greatest share of a budget of time that seeding takes, and that direct light takes.
pub(crate) const GREATEST_SHARE: f64 = 0.25;

/// Mutations that take about as long as a sample of the seeding, and as one of direct light, where a budget is in mutations.
const MUTATIONS_PER_SEED: f64 = 3.0;
const MUTATIONS_PER_DIRECT_SAMPLE: f64 = 1.0;

/// Chains, and steps of each, that tell how long a mutation takes.
const TRIAL_CHAINS: usize = 8;
const TRIAL_STEPS: u64 = 32;

/// Paths of more than this many edges are indirect.
const DIRECT_EDGES: usize = 2;

/// What the chains found beside the picture.
#[derive(Clone, Debug)]
pub struct MltReport {
    /// Estimate of b, the mean luminance over the image of the paths that the chains sample.
    pub b: f64,
    /// Standard error of b over b; with two stages that of the integral of their target.
    pub b_relative_error: f64,
    /// Independent samples that b comes from.
    pub seeding_samples: u64,
    /// Seconds of seeding.
    pub seeding_seconds: f64,
    /// Seconds of direct light.
    pub direct_seconds: f64,
    /// Seconds of mutations.
    pub mutation_seconds: f64,
    /// Number of chains at once.
    pub chains: usize,
    /// Mutations after which each began anew, if ever.
    pub life: Option<u64>,
    /// Mutations over all chains.
    pub mutations: u64,
    /// How well the chains mix.
    pub mixing: MixingReport,
    /// Numbers for each pixel, if the settings ask for them.
    pub layers: Option<Layers>,
    /// Statistics, one entry for each member of the mixture.
    pub statistics: Vec<MutationStatistics>,
    /// The first proposals whose densities were not numbers.
    pub faults: Vec<FaultRecord>,
}

/// A part of the chains, always worked on together.
struct Batch<S: Pictured> {
    runners: Vec<ChainRunner<S>>,
    /// The chain to run next in this round; beyond the last when the round is done.
    next: usize,
    ledger: Ledger,
    counts: Counts,
}

/// What the chains' buffers are merged into.
struct Sums {
    film: Film,
    layers: Option<LayerSums>,
}

/// The picture, the report, and what was traced and left out.
pub(crate) struct Rendered {
    pub(crate) picture: Picture,
    pub(crate) report: MltReport,
    pub(crate) counts: Counts,
}

/// What chains start from.
pub(crate) struct Start<B> {
    pub(crate) seeds: Seeds,
    /// What the target is divided by.
    pub(crate) brightness: Option<Arc<BrightnessMap>>,
    /// Seconds until here: of the first stage, of seeding, and of whatever else comes before the chains.
    pub(crate) seeding_seconds: f64,
    /// The state that a seed is.
    pub(crate) begin: B,
    /// Splats that a chain leaves in one step at most, or a little more on average.
    pub(crate) splats_per_step: u64,
}

/// What watches over a part of a render that begins at `start` and comes before the chains: it may take its share of a budget of time
/// only, so that the chains have as large a part of a short budget as of a long one.
pub(crate) fn until<'a>(settings: &Settings, start: Instant, observer: &'a dyn Observer) -> Until<'a> {
    until_part(settings, start, observer, 1.0)
}

/// The same for what may take a part of such a share.
pub(crate) fn until_part<'a>(settings: &Settings, start: Instant, observer: &'a dyn Observer, part: f64) -> Until<'a> {
    let share = if settings.share() > 0.0 { settings.share() } else { GREATEST_SHARE };
    let deadline = match settings.budget {
        Budget::Seconds(seconds) => Duration::try_from_secs_f64(seconds * share * part).ok().map(|time| start + time),
        Budget::SamplesPerPixel(_) => None,
    };
    Until { observer, deadline }
}

/// What a part of a render before the chains does at least, so that its error goes down with that of the chains.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeastWork {
    /// Samples.
    pub(crate) samples: f64,
    /// When it may end.
    pub(crate) not_before: Option<Instant>,
}

impl LeastWork {
    /// The share of the work that is done, given that of the samples; in [0, 1].
    pub(crate) fn limit(&self, done: f64) -> f64 {
        // There is no telling how much of the time has passed, but something is left to do.
        if self.not_before.is_some_and(|time| Instant::now() < time) { done.min(0.99) } else { done.min(1.0) }
    }
}

/// The least work of a part that begins at `start` and whose samples take as long as so many mutations.
pub(crate) fn least_work(settings: &Settings, start: Instant, mutations_per_sample: f64) -> LeastWork {
    let share = settings.share();
    match settings.budget {
        Budget::SamplesPerPixel(samples) => {
            let mutations = samples * settings.pixels();
            LeastWork { samples: share * mutations / mutations_per_sample, not_before: None }
        }
        Budget::Seconds(seconds) => {
            let part = Duration::try_from_secs_f64(seconds * share);
            LeastWork { samples: 0.0, not_before: part.ok().map(|part| start + part) }
        }
    }
}

/// How much effort the seeding of a render that began at `start` makes.
pub(crate) fn seeding_effort(settings: &Settings, start: Instant) -> Effort {
    Effort { least: least_work(settings, start, MUTATIONS_PER_SEED), ..Effort::from(&settings.mlt.seeding) }
}

/// Renders by chains that are at their start and make steps by `mixture`. `names` has one entry for each of its members.
///
/// A picture that would be all black is an error: there is nothing that a chain could start from.
pub(crate) fn render<R, S, B, M>(
    scene: &Scene<R>,
    settings: &Settings,
    chains: Start<B>,
    (mixture, space): (&Mixture<M>, &M::Space),
    names: &[&'static str],
    start: Instant,
    observer: &dyn Observer,
) -> Result<Rendered, RenderError>
where
    R: Repertoire,
    S: Pictured,
    B: Fn(&Seeds, &Seed) -> S + Sync,
    M: Mutation<State = S> + Sync,
    M::Space: Sync,
    M::Failure: Into<Rejection>,
{
    let (width, height) = settings.film_size();
    let filter = settings.filter.filter();
    let roulette = settings.roulette.roulette();
    let lengths = chain_lengths(settings);
    let Start { seeds, brightness, seeding_seconds, begin, splats_per_step } = chains;

    let direct_start = Instant::now();
    let mut counts = seeds.counts;
    let mut picture = Picture::black(settings.film_size());
    if let Direct::Separate { samples_per_pixel } = settings.mlt.direct {
        let direct = Lengths { min_edges: settings.min_edges, max_edges: settings.max_edges.min(DIRECT_EDGES) };
        let least = least_work(settings, direct_start, MUTATIONS_PER_DIRECT_SAMPLE);
        let wanted = f64::from(samples_per_pixel).max((least.samples / settings.pixels()).ceil());
        let sampled = sample_until(
            scene,
            &BidirectionalPathTracer::new(direct, roulette),
            settings.film_size(),
            filter,
            |passes| least.limit(passes as f64 / wanted),
            (settings.seed, Purpose::Direct),
            (Stage::Direct, &until(settings, direct_start, observer)),
        );
        picture.add(&sampled.picture(scene));
        counts += sampled.counts;
    }
    let direct_seconds = direct_start.elapsed().as_secs_f64();
    let no_seed = (seeds.b <= 0.0 && lengths.min_edges <= lengths.max_edges).then(|| {
        let (samples, min_edges) = (seeds.samples(), lengths.min_edges);
        format!("no path of {min_edges} or more edges that carries light was found in {samples} samples")
    });
    if let Some(reason) = no_seed.as_ref().filter(|_| picture.mean() == Rgb::ZERO && !observer.should_stop()) {
        return Err(RenderError::Dark(reason.clone()));
    }

    let mutation_start = Instant::now();
    let target = S::target(brightness);
    let step = |runner: &mut ChainRunner<S>, count, ledger: &mut Ledger| runner.run(count, mixture, space, ledger);
    let trial = || {
        let runner = |seed: &Seed| {
            let rng = stream(settings.seed, Purpose::Trial, u64::from(seed.index));
            ChainRunner::with_target(target.clone(), 0, begin(&seeds, seed), rng)
        };
        let mut runners: Vec<ChainRunner<S>> = seeds.chosen(0, TRIAL_CHAINS).iter().map(runner).collect();
        // A copy of one would have no room.
        let mut ledgers: Vec<Ledger> = runners.iter().map(|_| Ledger::new(settings, names)).collect();
        let (steps, trial_start) = (TRIAL_STEPS.min(longest_round(splats_per_step)), Instant::now());
        runners.iter_mut().zip(&mut ledgers).for_each(|(runner, ledger)| step(runner, steps, ledger));
        trial_start.elapsed().as_secs_f64() / (runners.len() as u64 * steps) as f64
    };
    let lives = Lives::new(settings, start, seeds.relative_error, trial);
    let states: Vec<S> = seeds.chosen(0, lives.chains).par_iter().map(|seed| begin(&seeds, seed)).collect();
    let chains = states.len();
    let mut work = share_out(states, &target, settings, names);
    let parts = layers::parts(width as usize * height as usize).min(work.len());
    let layers = (settings.mlt.layers && chains > 0).then(|| LayerSums::new(settings.film_size(), filter, parts));
    let mut sums = Sums { film: Film::new(width, height, filter), layers };
    let renew = |work: &mut [Batch<S>], generation| {
        let (chosen, count) = (seeds.chosen(generation, chains), work.len());
        work.par_iter_mut().enumerate().for_each(|(i, batch)| {
            let ((), counts) = counted(|| {
                for (runner, slot) in batch.runners.iter_mut().zip((i..).step_by(count)) {
                    let index = generation * chains as u64 + slot as u64;
                    let rng = stream(settings.seed, Purpose::Chain, index);
                    runner.begin_anew(index, begin(&seeds, &chosen[slot]), rng, &mut batch.ledger);
                }
            });
            batch.counts += counts;
        });
    };
    let lives = Lives { chains, ..lives };
    let mutations = run(&mut work, &mut sums, (step, renew), splats_per_step, settings, lives, start, observer);
    let mutation_seconds = mutation_start.elapsed().as_secs_f64();

    let mut statistics = MutationStatistics::of_members(names, settings.max_edges);
    let mut faults = Vec::new();
    let steps = if chains > 0 { mutations / chains as u64 } else { 0 };
    for Batch { runners, ledger, .. } in &mut work {
        runners.iter_mut().for_each(|runner| runner.finish(ledger));
    }
    sums.merge(&mut work);
    let layers = sums.layers.as_ref().map(|layers| {
        let chains_of = |part: usize| work.iter().skip(part).step_by(parts).map(|batch| batch.runners.len()).sum();
        let scale = |chains: usize| seeds.target * scene.camera().image_area_pixels() / (steps as f64 * chains as f64);
        layers.finish(&(0..layers.parts()).map(|part| scale(chains_of(part))).collect::<Vec<_>>())
    });
    let traces: Vec<&ChainTrace> = work.iter().flat_map(|b| &b.runners).map(ChainRunner::trace).collect();
    let parts: Vec<&[MutationStatistics]> = work.iter().map(|batch| &batch.ledger.mutations[..]).collect();
    let mut mixing = mixing::report(&traces, steps, &parts);
    mixing.warnings.splice(0..0, no_seed);
    for batch in &work {
        for (sum, more) in statistics.iter_mut().zip(&batch.ledger.mutations) {
            sum.add(more);
        }
        faults.extend_from_slice(&batch.ledger.faults);
        counts += batch.counts;
    }
    if mutations > 0 {
        // I_j = b E[h_j f / C], h_j a density over the image of unit area and b the integral of C (Veach 11.3).
        picture.add(&sums.film.develop(seeds.target * scene.camera().image_area_pixels() / mutations as f64));
    }
    let report = MltReport {
        b: seeds.b,
        b_relative_error: seeds.relative_error,
        seeding_samples: seeds.samples(),
        seeding_seconds,
        direct_seconds,
        mutation_seconds,
        chains,
        life: lives.life,
        mutations,
        mixing,
        layers,
        statistics,
        faults,
    };
    Ok(Rendered { picture, report, counts })
}

/// Steps of a round at most: what a chain leaves behind has to find room in an empty buffer.
fn longest_round(splats_per_step: u64) -> u64 {
    (ROUND / splats_per_step).max(1)
}

/// Lengths of the paths that the chains sample.
pub(crate) fn chain_lengths(settings: &Settings) -> Lengths {
    let min_edges = match settings.mlt.direct {
        Direct::InChain => settings.min_edges,
        Direct::Separate { .. } => settings.min_edges.max(DIRECT_EDGES + 1),
    };
    Lengths { min_edges, max_edges: settings.max_edges }
}

/// Chain i goes to batch i modulo the number of batches, which depends on the number of chains only.
fn share_out<S: Pictured>(
    states: Vec<S>,
    target: &S::Target,
    settings: &Settings,
    names: &[&'static str],
) -> Vec<Batch<S>> {
    let count = BATCHES.min(states.len());
    let mut work: Vec<Batch<S>> = (0..count)
        .map(|_| Batch {
            runners: Vec::new(),
            next: 0,
            ledger: Ledger::new(settings, names),
            counts: Counts::default(),
        })
        .collect();
    for (index, state) in states.into_iter().enumerate() {
        let (index_of_chain, rng) = (index as u64, stream(settings.seed, Purpose::Chain, index as u64));
        let runner = ChainRunner::with_target(target.clone(), index_of_chain, state, rng);
        work[index % count].runners.push(runner);
    }
    work
}

impl<S: Pictured> Batch<S> {
    /// Runs chains for `steps` steps each until the round is done or the buffers may be too small for the next one; whether
    /// the round is done.
    fn advance(
        &mut self,
        steps: u64,
        splats_per_step: u64,
        step: &impl Fn(&mut ChainRunner<S>, u64, &mut Ledger),
    ) -> bool {
        let ((), counts) = counted(|| {
            while self.next < self.runners.len() && self.ledger.has_room(steps * splats_per_step) {
                step(&mut self.runners[self.next], steps, &mut self.ledger);
                self.next += 1;
            }
        });
        self.counts += counts;
        self.next == self.runners.len()
    }
}

impl Sums {
    /// Takes what is in the buffers of all batches.
    fn merge<S: Pictured>(&mut self, work: &mut [Batch<S>]) {
        if let Some(layers) = &mut self.layers {
            layers.merge(&mut work.iter_mut().map(|batch| &mut batch.ledger).collect::<Vec<_>>());
        }
        self.film.merge(&mut work.iter_mut().map(|batch| &mut batch.ledger.splats).collect::<Vec<_>>());
    }
}

/// Runs all chains by `step` until the budget ends, and lets `renew` make the chains of the next generation from time to time; the
/// number of mutations made.
fn run<S: Pictured>(
    work: &mut [Batch<S>],
    sums: &mut Sums,
    (step, renew): (impl Fn(&mut ChainRunner<S>, u64, &mut Ledger) + Sync, impl Fn(&mut [Batch<S>], u64)),
    splats_per_step: u64,
    settings: &Settings,
    Lives { chains, life }: Lives,
    start: Instant,
    observer: &dyn Observer,
) -> u64 {
    let (longest, budget) = (longest_round(splats_per_step), settings.budget);
    if chains == 0 {
        return 0;
    }
    // Steps of each chain in all; with a budget of time, as many as those so far foretell.
    let mut wanted = match budget {
        Budget::SamplesPerPixel(samples) => (samples * settings.pixels() / chains as f64).ceil().max(1.0) as u64,
        Budget::Seconds(_) => u64::MAX,
    };
    let begun = start.elapsed();
    let mut steps: u64 = 0;
    loop {
        if let Some(life) = life.filter(|life| steps > 0 && steps.is_multiple_of(*life)) {
            // A stay that ends is noted, for which there has to be room.
            sums.merge(work);
            renew(work, steps / life);
        }
        let left = life.map_or(u64::MAX, |life| life - steps % life);
        let round = longest.min(left).min(wanted.saturating_sub(steps).max(1));
        // Every batch stops where its buffers may be too small for another chain, which depends on nothing but its own chains.
        while !all(work, |batch| batch.advance(round, splats_per_step, &step)) {
            sums.merge(work);
        }
        work.iter_mut().for_each(|batch| batch.next = 0);
        steps += round;
        let done = match budget {
            Budget::SamplesPerPixel(_) => steps as f64 / wanted as f64,
            Budget::Seconds(seconds) => {
                let done = share_of_time(start.elapsed(), begun, seconds);
                wanted = (steps as f64 / done).ceil() as u64;
                done
            }
        };
        observer.progress(Stage::Rendering, done.min(1.0));
        if done >= 1.0 || observer.should_stop() {
            sums.merge(work);
            return steps * chains as u64;
        }
    }
}

/// The share of the time left at `begun` that has passed; 1 or more when all has.
fn share_of_time(elapsed: Duration, begun: Duration, seconds: f64) -> f64 {
    let left = seconds - begun.as_secs_f64();
    if left > 0.0 { (elapsed - begun).as_secs_f64() / left } else { 1.0 }
}
