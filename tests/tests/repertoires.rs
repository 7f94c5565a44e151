//! Code that is compiled for fewer effects gives the same bits as code that has all of them, for every method, and is chosen for scenes
//! only that have no other effects.

use ergodic_mutations::InRepertoire;
use ergodic_pathspace::{Effect, Forced, Lengths, PathSpace, Roulette, Scene, Within};
use ergodic_render::{
    BidirectionalPathTracer, ChainRunner, Estimator, Film, Ledger, Multiplexed, PathTracer, Purpose, Seeding, Seeds,
    Settings, Unobserved, stream,
};
use ergodic_scattering::{Everything, Filter, Repertoire};

use crate::effects::scene;

const LENGTHS: Lengths = Lengths { min_edges: 1, max_edges: 10 };
const ROULETTE: Roulette = Roulette { start: 4, survival: 0.9 };

/// Samples of every estimator, and the film that chains of all mutations leave.
struct Bits {
    seed: u64,
}

fn samples<E: Estimator>(scene: &Scene<E::Repertoire>, mut estimator: E, seed: u64, bits: &mut Vec<u64>) {
    for index in 0..2000 {
        estimator.sample(scene, &mut stream(seed, Purpose::Pilot, index), |raster, color| {
            bits.extend(raster.to_array().into_iter().chain(color.to_array()).map(f64::to_bits));
        });
    }
}

impl Within for Bits {
    type Output = Vec<u64>;

    fn run<R: Repertoire>(self, scene: &Scene<R>) -> Vec<u64> {
        let Self { seed } = self;
        let mut bits = Vec::new();
        samples(scene, PathTracer::new(LENGTHS, ROULETTE), seed, &mut bits);
        samples(scene, BidirectionalPathTracer::new(LENGTHS, ROULETTE), seed, &mut bits);
        samples(scene, Multiplexed::new(scene, LENGTHS, seed), seed, &mut bits);

        let settings = Settings { size: (32, 32), max_edges: LENGTHS.max_edges, ..Settings::default() };
        let mutations = ergodic_mutations::AnyMutation::all();
        let names: Vec<_> = mutations.iter().map(|mutation| mutation.name()).collect();
        let mixture = InRepertoire::mixture(mutations.into_iter().map(|mutation| (1.0, mutation)).collect())
            .expect("there are mutations");
        let seeding = Seeding { relative_error: 0.1, max_samples: 20_000 };
        let seeds = Seeds::draw(scene, LENGTHS, ROULETTE, &seeding, seed, &Unobserved);
        bits.push(seeds.b.to_bits());
        let space = PathSpace { scene: scene.clone(), lengths: LENGTHS };
        let mut film = Film::new(32, 32, Filter::Box);
        let mut ledger = Ledger::new(&settings, &names);
        for (index, start) in (0..).zip(seeds.starts(scene, 16)) {
            let mut chain = ChainRunner::new(index, start, stream(seed, Purpose::Chain, index));
            for _ in 0..20 {
                ledger.make_room(100, &mut film);
                chain.run(100, &mixture, &space, &mut ledger);
            }
        }
        film.take(&mut ledger.splats);
        bits.extend(film.develop(1.0).pixels.iter().flat_map(|pixel| pixel.to_array()).map(f64::to_bits));
        bits
    }
}

#[test]
fn every_repertoire_gives_the_bits_of_everything() {
    for (name, repertoire) in
        [("cornell", "matte"), ("glass", "core"), ("ajar", "core"), ("pool", "core"), ("ring", "core")]
    {
        let scene = scene(name, &Forced::default());
        assert_eq!(scene.repertoire().name(), repertoire, "{name}");
        let bits = scene.within(Bits { seed: 1 });
        assert!(bits.len() > 10_000, "{name}: nothing was compared");
        assert!(bits == Bits { seed: 1 }.run::<Everything>(&scene), "{name}: not the same bits");
        // The comparison sees a difference where there is one.
        assert!(bits != Bits { seed: 2 }.run::<Everything>(&scene), "{name}: the seed makes no difference");
    }
}

/// An effect that a repertoire lacks is not compiled, so its scene must not be rendered by it.
#[test]
fn a_scene_is_rendered_by_code_that_has_all_its_effects() {
    use Effect::*;
    for effect in Effect::ALL.iter().copied() {
        let forced = Forced { on: vec![effect], off: Vec::new() };
        let expected = match effect {
            EmittingSurfaces | Instances => "matte",
            GlossyReflection | MirrorReflection | RoughTransmission | ClearTransmission | Absorption => "core",
            _ => "everything",
        };
        assert_eq!(scene("cornell", &forced).repertoire().name(), expected, "{effect:?}");
    }
    let all = Forced { on: Effect::ALL.to_vec(), off: Vec::new() };
    assert_eq!(scene("glass", &all).repertoire().name(), "everything");
}
