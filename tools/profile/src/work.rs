//! What is measured: chains of the default mixture on one scene, in one thread, as a render runs them.

use std::path::Path;
use std::time::Instant;

use cpu_time::ThreadTime;
use ergodic_metropolis::Mixture;
use ergodic_mutations::{AnyMutation, InRepertoire};
use ergodic_pathspace::{Lengths, PathSpace, Roulette, Scene};
use ergodic_render::{ChainRunner, Film, Ledger, Purpose, Seeding, Seeds, Settings, Unobserved, stream};
use ergodic_scattering::Repertoire;

/// Width and height of the picture.
const SIZE: u32 = 256;
/// Chains, which take turns.
const CHAINS: usize = 64;
/// Mutations of a turn, as in a render.
const TURN: u64 = 256;
/// Turns of each chain in one round.
const TURNS: u64 = 12;
/// Edges of the shortest path that chains sample while direct light is sampled apart, as by default.
const MIN_EDGES: usize = 3;
/// Rounds that are measured at least.
const LEAST_ROUNDS: usize = 3;

/// Mutations of one round.
pub const MUTATIONS: u64 = CHAINS as u64 * TURN * TURNS;

/// Chains past their burn-in, ready to make the same round again and again.
pub struct Work<R: Repertoire> {
    space: PathSpace<R>,
    mixture: Mixture<InRepertoire<AnyMutation, R>>,
    chains: Vec<ChainRunner<ergodic_pathspace::Path<R>>>,
    ledger: Ledger,
    film: Film,
}

/// The settings of what is measured.
fn settings() -> Settings {
    Settings { size: (SIZE, SIZE), ..Settings::default() }
}

/// Loads a scene.
///
/// # Errors
///
/// A scene that cannot be read.
pub fn load(file: &Path) -> Result<Scene, String> {
    let asset = ergodic_assets::load(file).map_err(|e| e.to_string())?;
    let (camera, _) = asset.camera("", 1.0).map_err(|e| format!("{}: {e}", file.display()))?;
    Scene::new(asset.description, &settings().view(camera)).map_err(|e| format!("{}: {e}", file.display()))
}

impl<R: Repertoire> Work<R> {
    /// Brings the chains under way.
    ///
    /// # Errors
    ///
    /// A scene that has no light that chains could find.
    pub fn new(scene: &Scene<R>) -> Result<Self, String> {
        let settings = settings();
        let lengths = Lengths { min_edges: MIN_EDGES, max_edges: settings.max_edges };
        // As a render has it: without what can never apply.
        let members = settings.mlt.mutations_for(scene.effects());
        let names: Vec<_> = members.iter().map(|(_, mutation)| mutation.name()).collect();
        let mixture = InRepertoire::mixture(members).map_err(|e| e.to_string())?;

        let roulette = Roulette { start: settings.roulette.start, survival: settings.roulette.survival };
        let seeding = Seeding { relative_error: 0.02, max_samples: 500_000 };
        let seeds = Seeds::draw(scene, lengths, roulette, &seeding, settings.seed, &Unobserved);
        let starts = seeds.starts(scene, CHAINS);
        if starts.is_empty() {
            return Err(format!("no path of {MIN_EDGES} or more edges carries light; is a light switched on?"));
        }
        let space = PathSpace { scene: scene.clone(), lengths };
        let chains = (0u64..)
            .zip(starts)
            .map(|(index, path)| ChainRunner::new(index, path, stream(settings.seed, Purpose::Chain, index)));
        let mut chains: Vec<_> = chains.collect();
        let mut ledger = Ledger::new(&settings, &names);
        let mut film = Film::new(SIZE, SIZE, settings.filter.filter());
        for chain in &mut chains {
            ledger.make_room(TURN, &mut film);
            chain.run(TURN, &mixture, &space, &mut ledger);
        }
        Ok(Self { space, mixture, chains, ledger, film })
    }

    /// The scene.
    #[cfg(feature = "record")]
    pub fn scene(&self) -> &Scene<R> {
        &self.space.scene
    }

    /// The round, which is the same every time: the chains are copied first. `watch` is given what makes the mutations and
    /// nothing else.
    pub fn round<T>(&self, watch: impl FnOnce(&mut dyn FnMut()) -> T) -> T {
        let (mut chains, mut ledger, mut film) = (self.chains.clone(), self.ledger.clone(), self.film.clone());
        watch(&mut || {
            for _ in 0..TURNS {
                for chain in &mut chains {
                    ledger.make_room(TURN, &mut film);
                    chain.run(TURN, &self.mixture, &self.space, &mut ledger);
                }
            }
        })
    }
}

/// Nanoseconds of this thread's processor time that `work` takes, by mutations of a round.
pub fn per_mutation(work: impl FnOnce()) -> f64 {
    let start = ThreadTime::now();
    work();
    start.elapsed().as_nanos() as f64 / MUTATIONS as f64
}

/// Does `round` until the seconds are over.
pub fn rounds<T>(seconds: f64, mut round: impl FnMut() -> T) -> Vec<T> {
    let start = Instant::now();
    // The first round warms the caches.
    round();
    let mut rounds = Vec::new();
    while rounds.len() < LEAST_ROUNDS || start.elapsed().as_secs_f64() < seconds {
        rounds.push(round());
    }
    rounds
}

/// The middle one of some values.
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    let n = values.len();
    (values[(n - 1) / 2] + values[n / 2]) / 2.0
}
