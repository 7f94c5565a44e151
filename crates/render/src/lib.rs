//! From a scene and settings to a picture: film, seeding and b, scheduling, statistics, and the estimators path tracing,
//! bidirectional path tracing and Metropolis light transport.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod autocorrelation;
mod bidirectional;
mod bins;
mod chain_runner;
mod chains;
mod counts;
mod film;
mod first_stage;
mod grid;
mod layers;
mod lives;
mod memory;
mod mixing;
mod mlt;
mod observer;
mod path_tracer;
mod primary;
mod replicas;
mod sampling;
mod seeding;
mod settings;
mod starts;
pub mod statistics;
mod streams;

pub use bidirectional::BidirectionalPathTracer;
pub use chain_runner::{ChainRunner, ChainStep, FaultRecord, Ledger, Pictured, ValueOf};
pub use chains::MltReport;
pub use counts::Counts;
pub use film::{Film, Picture, SplatBuffer};
pub use layers::{Layers, VisitBuffer};
pub use memory::peak_bytes;
pub use mixing::{Mixing, MixingReport, R_HAT_LIMIT, Stay};
pub use mlt::{Replayed, replay};
pub use observer::{Observer, Stage, Unobserved};
pub use path_tracer::PathTracer;
pub use primary::{
    Coordinates, Multiplexed, PrimaryMutation, PrimarySample, PrimarySpace, PrimaryTarget, PrimaryValue, Seedable,
};
pub use replicas::render_replicas;
pub use sampling::{Estimator, Sampled, sample_image};
pub use seeding::{Effort, Seeds, Weighed};
pub use settings::{
    Budget, Direct, EnvironmentMap, EnvironmentSettings, FilterSettings, LensSettings, Life, LightUnits,
    MediumSettings, Method, MltSettings, PrimarySampler, PrimarySettings, RouletteSettings, Seeding, Settings,
};
pub use starts::Strategy;
pub use streams::{Purpose, stream};

use std::time::Instant;

use ergodic_metropolis::{Mixture, MixtureError, Mutation};
use ergodic_mutations::{InRepertoire, Rejection, Splice};
use ergodic_pathspace::{Path, PathSpace, Scene, Within};
use ergodic_scattering::Repertoire;
use thiserror::Error;

use chains::{Rendered, chain_lengths, until_part};
use counts::counted;

/// What a render came to.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// The picture.
    pub picture: Picture,
    /// The method.
    pub method: Method,
    /// Seconds of wall time in all.
    pub seconds: f64,
    /// Seconds of processor time of all threads; 0 where the system does not tell.
    pub processor_seconds: f64,
    /// Threads used.
    pub threads: usize,
    /// Instructions that rays were searched with; the picture does not depend on them.
    pub instructions: &'static str,
    /// What was traced and left out.
    pub counts: Counts,
    /// Samples taken in each pixel, or mutations a pixel if the method has chains.
    pub samples_per_pixel: f64,
    /// What the chains found, if the method has any.
    pub mlt: Option<MltReport>,
}

/// Why nothing was rendered.
#[derive(Debug, Error)]
pub enum RenderError {
    /// A setting is out of range.
    #[error("{0}")]
    Settings(String),
    /// The mixture is empty.
    #[error("mlt.mutations: {0}")]
    Mixture(#[from] MixtureError),
    /// Seeding found no path that carries light, and there is no direct light either.
    #[error(
        "{0}: the picture would be black; is a light switched on, and does the camera see anything that it reaches? If it is a \
         very rare path, raise mlt.seeding.max_samples"
    )]
    Dark(String),
    /// No worker threads.
    #[error("cannot start {threads} threads: {reason}; give a smaller number")]
    Threads {
        /// How many were asked for.
        threads: usize,
        /// What the system said.
        reason: String,
    },
}

/// Number of parts into which work is cut, or fewer if there are fewer chains or rows: two for each of 64 threads. It depends
/// neither on the number of threads nor on the size of the picture.
pub(crate) const BATCHES: usize = 128;

/// Metropolis light transport with any mixture of path mutations, in the current rayon pool; `names` has one entry for
/// each member. What [`render`] does for the mixture of the settings.
///
/// # Errors
///
/// Settings out of range.
pub fn render_with_mixture<M>(
    scene: &Scene,
    settings: &Settings,
    mixture: &Mixture<M>,
    names: &[&'static str],
    observer: &dyn Observer,
) -> Result<Rendering, RenderError>
where
    M: Mutation<Space = PathSpace, State = Path, Plan = Splice, Failure = Rejection> + Sync,
{
    settings.validate().map_err(RenderError::Settings)?;
    let start = Instant::now();
    let mut rendering = metropolis(scene, settings, mixture, names, start, observer)?;
    rendering.seconds = start.elapsed().as_secs_f64();
    rendering.threads = rayon::current_num_threads();
    Ok(rendering)
}

/// Renders `scene` as `settings` say. The scene must have been built for the settings' view.
///
/// # Errors
///
/// Settings out of range, or threads that cannot be started.
pub fn render(scene: &Scene, settings: &Settings, observer: &dyn Observer) -> Result<Rendering, RenderError> {
    settings.validate().map_err(RenderError::Settings)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(settings.threads)
        .build()
        .map_err(|e| RenderError::Threads { threads: settings.threads, reason: e.to_string() })?;
    let start = Instant::now();
    let processor_start = processor_seconds(&pool);
    let mut rendering = pool.install(|| scene.within(Render { settings, start, observer }))?;
    rendering.seconds = start.elapsed().as_secs_f64();
    rendering.processor_seconds = processor_seconds(&pool) - processor_start;
    rendering.threads = pool.current_num_threads();
    Ok(rendering)
}

/// What [`render`] does in its pool of threads.
struct Render<'a> {
    settings: &'a Settings,
    start: Instant,
    observer: &'a dyn Observer,
}

impl Within for Render<'_> {
    type Output = Result<Rendering, RenderError>;

    fn run<R: Repertoire>(self, scene: &Scene<R>) -> Self::Output {
        let Self { settings, start, observer } = self;
        match settings.method {
            Method::Path => {
                let estimator = PathTracer::new(settings.lengths(), settings.roulette.roulette());
                Ok(independent(scene, &estimator, settings, Purpose::PathTracer, observer))
            }
            Method::Bidirectional => {
                let estimator = BidirectionalPathTracer::new(settings.lengths(), settings.roulette.roulette());
                Ok(independent(scene, &estimator, settings, Purpose::Bidirectional, observer))
            }
            Method::Mlt => {
                let mutations = settings.mlt.mutations_for(scene.effects());
                let names = mutations.iter().map(|(_, mutation)| mutation.name()).collect::<Vec<_>>();
                let mixture = InRepertoire::mixture(mutations)?;
                metropolis(scene, settings, &mixture, &names, start, observer)
            }
            Method::Pssmlt => {
                let (lengths, roulette) = (chain_lengths(settings), settings.roulette.roulette());
                let rendered = match settings.primary.sampler {
                    PrimarySampler::Path => {
                        primary::render(scene, settings, &PathTracer::new(lengths, roulette), start, observer)
                    }
                    PrimarySampler::Bidirectional => {
                        let estimator = BidirectionalPathTracer::new(lengths, roulette);
                        primary::render(scene, settings, &estimator, start, observer)
                    }
                }?;
                Ok(by_chains(scene, settings, rendered))
            }
            Method::Mmlt => {
                let watch = until_part(settings, start, observer, primary::PILOT_PART_OF_SEEDING);
                let (estimator, counts) =
                    counted(|| Multiplexed::until(scene, chain_lengths(settings), settings.seed, &watch));
                let mut rendered = primary::render(scene, settings, &estimator, start, observer)?;
                rendered.counts += counts;
                Ok(by_chains(scene, settings, rendered))
            }
        }
    }
}

/// Processor time that the threads of a pool have taken so far, in seconds.
fn processor_seconds(pool: &rayon::ThreadPool) -> f64 {
    let of_thread = |_: rayon::BroadcastContext<'_>| {
        cpu_time::ThreadTime::try_now().map_or(0.0, |time| time.as_duration().as_secs_f64())
    };
    pool.broadcast(of_thread).iter().sum()
}

fn independent<E: Estimator + Sync>(
    scene: &Scene<E::Repertoire>,
    estimator: &E,
    settings: &Settings,
    purpose: Purpose,
    observer: &dyn Observer,
) -> Rendering {
    let sampled = sample_image(
        scene,
        estimator,
        settings.film_size(),
        settings.filter.filter(),
        settings.budget,
        (settings.seed, purpose),
        (Stage::Rendering, observer),
    );
    Rendering {
        picture: sampled.picture(scene),
        method: settings.method,
        seconds: 0.0,
        processor_seconds: 0.0,
        threads: 0,
        instructions: scene.world().isa().name(),
        counts: sampled.counts,
        samples_per_pixel: sampled.passes as f64,
        mlt: None,
    }
}

fn metropolis<R, M>(
    scene: &Scene<R>,
    settings: &Settings,
    mixture: &Mixture<M>,
    names: &[&'static str],
    start: Instant,
    observer: &dyn Observer,
) -> Result<Rendering, RenderError>
where
    R: Repertoire,
    M: Mutation<Space = PathSpace<R>, State = Path<R>, Plan = Splice, Failure = Rejection> + Sync,
{
    Ok(by_chains(scene, settings, mlt::render(scene, settings, mixture, names, start, observer)?))
}

fn by_chains<R: Repertoire>(scene: &Scene<R>, settings: &Settings, rendered: Rendered) -> Rendering {
    Rendering {
        picture: rendered.picture,
        method: settings.method,
        seconds: 0.0,
        processor_seconds: 0.0,
        threads: 0,
        instructions: scene.world().isa().name(),
        counts: rendered.counts,
        samples_per_pixel: rendered.report.mutations as f64 / scene.camera().image_area_pixels(),
        mlt: Some(rendered.report),
    }
}
