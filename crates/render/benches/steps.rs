//! Processor time of what a mutation is made of, on the scenes of `scenes/`: `cargo bench -p ergodic-render`, or a part of it, as in
//! `cargo bench -p ergodic-render -- cornell/step`.
//!
//! The paths are those of chains that have run for a while, so they are as frequent as in a render.

#[path = "../../geometry/benches/processor_time/mod.rs"]
mod processor_time;

use std::fs;
use std::hint::black_box;
use std::path::{Path as FilePath, PathBuf};
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ergodic_metropolis::{Mixture, Mutation};
use ergodic_mutations::{AnyMutation, Splice};
use ergodic_pathspace::{Edge, Lengths, Path, PathSpace, Roulette, Scene};
use ergodic_render::{
    BidirectionalPathTracer, ChainRunner, Estimator, Film, Ledger, PathTracer, Purpose, Seeding, Seeds, Settings,
    Unobserved, stream,
};
use processor_time::ProcessorTime;

/// Chains whose paths are used.
const CHAINS: usize = 256;
/// Steps of each before its path is typical.
const BURN_IN: u64 = 200;
/// Mutations of one iteration of a full step.
const STEPS: u64 = 256;

/// All scenes, by name.
fn scenes() -> Vec<(String, PathBuf)> {
    let folder = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let entries = fs::read_dir(folder).expect("the project has a folder of scenes");
    let mut scenes: Vec<_> = entries
        .flatten()
        .map(|entry| (entry.file_name().to_string_lossy().into_owned(), entry.path().join("scene.glb")))
        .filter(|(_, file)| file.exists())
        .collect();
    scenes.sort();
    scenes
}

fn settings() -> Settings {
    Settings { size: (256, 256), ..Settings::default() }
}

fn load(file: &FilePath, settings: &Settings) -> Scene {
    let asset = ergodic_assets::load(file).expect("a stored scene is sound");
    let (camera, _) = asset.camera("", 1.0).expect("a stored scene has a camera");
    Scene::new(asset.description, &settings.view(camera)).expect("a stored scene is sound")
}

/// What chains leave their results in.
fn ledger(settings: &Settings) -> Ledger {
    let names: Vec<_> = settings.mlt.mutations.iter().map(|(_, mutation)| mutation.name()).collect();
    Ledger::new(settings, &names)
}

fn film(settings: &Settings) -> Film {
    Film::new(settings.film_size().0, settings.film_size().1, settings.filter.filter())
}

/// Chains of the default mixture, past their burn-in.
fn chains(space: &PathSpace, mixture: &Mixture<AnyMutation>, settings: &Settings) -> Vec<ChainRunner> {
    let seeding = Seeding { relative_error: 0.05, max_samples: 200_000 };
    let roulette = Roulette { start: settings.roulette.start, survival: settings.roulette.survival };
    let seeds = Seeds::draw(&space.scene, space.lengths, roulette, &seeding, settings.seed, &Unobserved);
    let mut ledger = ledger(settings);
    let mut film = film(settings);
    let starts = seeds.starts(&space.scene, CHAINS).into_iter();
    (0u64..)
        .zip(starts)
        .map(|(index, path)| {
            let mut chain = ChainRunner::new(index, path, stream(settings.seed, Purpose::Chain, index));
            ledger.make_room(BURN_IN, &mut film);
            chain.run(BURN_IN, mixture, space, &mut ledger);
            chain
        })
        .collect()
}

/// A proposal that was built: from, to, plan.
type Proposal = (Path, Path, Splice);

fn proposals(space: &PathSpace, mutation: &AnyMutation, paths: &[Path]) -> Vec<Proposal> {
    let mut rng = stream(1, Purpose::Chain, 0);
    let mut made = Vec::new();
    for x in paths.iter().cycle().take(32 * paths.len()) {
        let mut y = Path::default();
        if mutation.suitability(space, x) > 0.0
            && let Ok(plan) = mutation.propose(space, x, &mut y, &mut rng)
        {
            made.push((x.clone(), y, plan));
            if made.len() == paths.len() {
                break;
            }
        }
    }
    made
}

fn scene(criterion: &mut Criterion<ProcessorTime>, name: &str, file: &FilePath) {
    let settings = settings();
    let scene = load(file, &settings);
    // Paths of three or more edges, as in a render whose direct light is sampled apart.
    let lengths = Lengths { min_edges: 3, max_edges: settings.max_edges };
    let space = PathSpace { scene: scene.clone(), lengths };
    let mixture = Mixture::new(settings.mlt.mutations.clone()).expect("the default mixture has members");
    let mut chains = chains(&space, &mixture, &settings);
    let paths: Vec<Path> = chains.iter().map(|chain| chain.path().clone()).collect();

    let mut group = criterion.benchmark_group(name);
    group.warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(500)).sample_size(20);

    let pairs: Vec<_> = paths.iter().flat_map(|path| path.vertices.windows(2)).collect();
    group.throughput(Throughput::Elements(pairs.len() as u64));
    group.bench_function("connection", |bencher| {
        bencher.iter(|| {
            for pair in &pairs {
                black_box(scene.mutually_visible(&pair[0], &pair[1]));
                black_box(Edge::new(&scene, &pair[0], &pair[1]));
            }
        });
    });

    for mutation in AnyMutation::all() {
        let suitable: Vec<&Path> = paths.iter().filter(|x| mutation.suitability(&space, x) > 0.0).collect();
        if suitable.is_empty() {
            continue;
        }
        let mut rng = stream(2, Purpose::Chain, 0);
        let mut y = Path::with_capacity(settings.max_edges);
        group.throughput(Throughput::Elements(suitable.len() as u64));
        group.bench_function(format!("propose/{}", mutation.name()), |bencher| {
            bencher.iter(|| {
                for x in &suitable {
                    let _ = black_box(mutation.propose(&space, x, &mut y, &mut rng));
                }
            });
        });
        let made = proposals(&space, &mutation, &paths);
        if made.is_empty() {
            continue;
        }
        group.throughput(Throughput::Elements(made.len() as u64));
        group.bench_function(format!("ln_density/{}", mutation.name()), |bencher| {
            bencher.iter(|| {
                for (x, y, plan) in &made {
                    black_box(mutation.ln_density(&space, x, y, *plan));
                }
            });
        });
    }

    let mut ledger = ledger(&settings);
    let mut film = film(&settings);
    let mut next = (0..chains.len()).cycle();
    group.throughput(Throughput::Elements(STEPS));
    group.bench_function("step", |bencher| {
        bencher.iter(|| {
            let index = next.next().unwrap_or(0);
            ledger.make_room(STEPS, &mut film);
            chains[index].run(STEPS, &mixture, &space, &mut ledger);
        });
    });

    let whole = settings.lengths();
    let roulette = Roulette { start: settings.roulette.start, survival: settings.roulette.survival };
    let mut rng = stream(3, Purpose::PathTracer, 0);
    group.throughput(Throughput::Elements(1));
    let mut path_tracer = PathTracer::new(whole, roulette);
    group.bench_function("sample/path", |bencher| {
        bencher.iter(|| {
            path_tracer.sample(&scene, &mut rng, |raster, color| {
                black_box((raster, color));
            })
        });
    });
    let mut bidirectional = BidirectionalPathTracer::new(whole, roulette);
    group.bench_function("sample/bidirectional", |bencher| {
        bencher.iter(|| {
            bidirectional.sample(&scene, &mut rng, |raster, color| {
                black_box((raster, color));
            })
        });
    });
    group.finish();
}

fn all(criterion: &mut Criterion<ProcessorTime>) {
    for (name, file) in scenes() {
        scene(criterion, &name, &file);
    }
}

criterion_group! {
    name = benches;
    config = processor_time::criterion();
    targets = all
}
criterion_main!(benches);
