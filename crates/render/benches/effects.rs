//! What effects cost: every scene of `scenes/` with the plan of its census, with every effect forced on, and with one at a time:
//! `cargo bench -p ergodic-render --bench effects`, or for some scenes, as in `... --bench effects -- cornell ajar`.
//!
//! Times are processor time of one thread per mutation, as in a render; the variants take turns, and medians are shown. The picture
//! must not change: the mean of the picture is compared over replicas.

use std::fs;
use std::path::{Path, PathBuf};

use cpu_time::ThreadTime;
use ergodic_mutations::InRepertoire;
use ergodic_pathspace::{Effect, Forced, Lengths, PathSpace, Roulette, Scene, Within};
use ergodic_render::{
    Budget, ChainRunner, Film, Ledger, Purpose, Seeding, Seeds, Settings, Unobserved, render_replicas, stream,
};
use ergodic_scattering::Repertoire;

/// Chains, mutations of a turn, turns of a round, rounds.
const CHAINS: usize = 64;
const TURN: u64 = 256;
const TURNS: u64 = 6;
const ROUNDS: usize = 9;

/// Replicas of a picture.
const REPLICAS: usize = 16;

/// All scenes, by name.
fn scenes() -> Vec<(String, PathBuf)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let wanted: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let entries = fs::read_dir(folder).expect("the project has a folder of scenes");
    let mut scenes: Vec<_> = entries
        .flatten()
        .map(|entry| (entry.file_name().to_string_lossy().into_owned(), entry.path().join("scene.glb")))
        .filter(|(name, file)| file.exists() && (wanted.is_empty() || wanted.contains(name)))
        .collect();
    scenes.sort();
    scenes
}

fn settings() -> Settings {
    Settings { size: (256, 256), ..Settings::default() }
}

/// The scene, ready for what it has and for `on`.
fn scene(file: &Path, settings: &Settings, on: &[Effect]) -> Scene {
    let asset = ergodic_assets::load(file).expect("a stored scene is sound");
    let (camera, _) = asset.camera("", 1.0).expect("a stored scene has a camera");
    let mut description = asset.description;
    let sky = file.with_file_name("sky.hdr");
    if sky.exists() {
        description.environment = Some(ergodic_assets::load_environment(&sky, 1.0, 0.0).expect("a sound map").0);
    }
    let mut view = settings.view(camera);
    description.plan(&mut view.camera, &Forced { on: on.to_vec(), off: Vec::new() });
    Scene::new(description, &view).expect("a stored scene is sound")
}

/// Makes chains on their way, by the code that a render of the scene runs: a function that makes a round and gives the nanoseconds of
/// a mutation in it.
struct Rounds<'a>(&'a Settings);

impl Within for Rounds<'_> {
    type Output = Box<dyn FnMut() -> f64>;

    fn run<R: Repertoire>(self, scene: &Scene<R>) -> Self::Output {
        let settings = self.0;
        let lengths = Lengths { min_edges: 3, max_edges: settings.max_edges };
        let members = settings.mlt.mutations_for(scene.effects());
        let names: Vec<_> = members.iter().map(|(_, mutation)| mutation.name()).collect();
        let mixture = InRepertoire::mixture(members).expect("the default mixture is sound");
        let roulette = Roulette { start: settings.roulette.start, survival: settings.roulette.survival };
        let seeding = Seeding { relative_error: 0.02, max_samples: 100_000 };
        let seeds = Seeds::draw(scene, lengths, roulette, &seeding, settings.seed, &Unobserved);
        let chain = |(index, path)| ChainRunner::new(index, path, stream(settings.seed, Purpose::Chain, index));
        let mut chains: Vec<_> = (0..).zip(seeds.starts(scene, CHAINS)).map(chain).collect();
        let space = PathSpace { scene: scene.clone(), lengths };
        let mut ledger = Ledger::new(settings, &names);
        let mut film = Film::new(settings.size.0, settings.size.1, settings.filter.filter());
        Box::new(move || {
            let start = ThreadTime::now();
            for _ in 0..TURNS {
                for chain in &mut chains {
                    ledger.make_room(TURN, &mut film);
                    chain.run(TURN, &mixture, &space, &mut ledger);
                }
            }
            start.elapsed().as_nanos() as f64 / (TURNS * TURN * CHAINS as u64) as f64
        })
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Mean of the picture and its standard error.
fn picture(scene: &Scene) -> (f64, f64) {
    let mut settings = Settings { size: (256, 256), budget: Budget::SamplesPerPixel(1.0), ..Settings::default() };
    settings.mlt.seeding.max_samples = 20_000;
    settings.mlt.chains = 64;
    settings.mlt.direct = ergodic_render::Direct::InChain;
    let renderings = render_replicas(scene, &settings, REPLICAS, &Unobserved).expect("sound settings");
    let means: Vec<f64> = renderings.iter().map(|r| ergodic_scattering::luminance(r.picture.mean())).collect();
    let n = means.len() as f64;
    let mean = means.iter().sum::<f64>() / n;
    let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

fn main() {
    // `cargo test --benches` and the like only want to know whether it builds.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    println!(
        "| scene | effects | repertoire | census plan, ns | all forced on, ns | ratio | the picture's mean changes by |"
    );
    println!("|---|---|---|---|---|---|---|");
    let mut alone = Vec::new();
    for (name, file) in scenes() {
        let settings = settings();
        let every: Vec<Effect> = Effect::ALL.to_vec();
        let (plain, full) = (scene(&file, &settings, &[]), scene(&file, &settings, &every));
        let has = plain.effects();
        let others: Vec<(Effect, Scene)> = Effect::ALL
            .iter()
            .filter(|effect| !has.has(**effect))
            .map(|effect| (*effect, scene(&file, &settings, &[*effect])))
            .collect();
        let mut work: Vec<_> = [&plain, &full]
            .into_iter()
            .chain(others.iter().map(|(_, scene)| scene))
            .map(|scene| scene.within(Rounds(&settings)))
            .collect();
        let mut times = vec![Vec::new(); work.len()];
        for round in 0..=ROUNDS {
            for (work, times) in work.iter_mut().zip(&mut times) {
                let time = work();
                // The first round warms the caches.
                if round > 0 {
                    times.push(time);
                }
            }
        }
        let times: Vec<f64> = times.into_iter().map(median).collect();
        let ((a, ea), (b, eb)) = (picture(&plain), picture(&full));
        println!(
            "| {name} | {} of {} | {} | {:.0} | {:.0} | {:.3} | {:+.2} % +- {:.2} % |",
            has.iter().count(),
            Effect::ALL.len(),
            plain.repertoire().name(),
            times[0],
            times[1],
            times[1] / times[0],
            100.0 * (b / a - 1.0),
            100.0 * (ea * ea + eb * eb).sqrt() / a
        );
        alone.extend(others.iter().zip(&times[2..]).map(|((effect, _), t)| (name.clone(), *effect, t - times[0])));
    }
    println!("\n| effect forced on | ns a mutation, by scene |\n|---|---|");
    for effect in Effect::ALL {
        let of: Vec<String> = alone
            .iter()
            .filter(|(_, e, _)| e == effect)
            .map(|(scene, _, more)| format!("{scene} {more:+.0}"))
            .collect();
        if !of.is_empty() {
            println!("| {} | {} |", effect.name(), of.join(", "));
        }
    }
}
