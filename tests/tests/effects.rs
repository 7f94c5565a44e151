//! The census finds what scenes have; being ready for more changes no picture; what is left out is missed.

use ergodic_pathspace::{Census, Effect, Effects, Forced, Scene};
use ergodic_render::{Method, Settings};
use ergodic_tests::{description, nightly};

use crate::rendering::{LIMIT, disagreement, replicate, settings};

fn effects_of(name: &str) -> Effects {
    let description = description(name);
    Census::of(&description, description.cameras.first()).effects()
}

#[test]
fn scenes_have_the_effects_that_they_were_made_for() {
    use Effect::*;
    let set = |effects: &[Effect]| effects.iter().copied().collect::<Effects>();
    assert_eq!(effects_of("cornell"), set(&[EmittingSurfaces]));
    let glass = effects_of("glass");
    assert_eq!(glass, set(&[MirrorReflection, ClearTransmission, Absorption, EmittingSurfaces]));
    assert!(effects_of("ring").has(MirrorReflection) || effects_of("ring").has(GlossyReflection));
    // Nothing is both found and missing, and the set of all has them all.
    for effect in Effect::ALL {
        assert!(Effects::all().has(*effect), "{effect:?}");
        assert!(!effect.name().is_empty() && !effect.when_on().is_empty() && !effect.when_off().is_empty());
    }
}

#[test]
fn a_material_that_nothing_has_calls_for_nothing() {
    let mut description = description("glass");
    let glass = description.materials.iter().position(|material| material.transmission > 0.0).expect("there is glass");
    description.placements.retain(|placement| placement.material != glass);
    let found = Census::of(&description, description.cameras.first()).effects();
    assert!(!found.has_specular() && !found.has(Effect::Absorption), "{found:?}");
}

pub(crate) fn scene(name: &str, forced: &Forced) -> Scene {
    let mut description = description(name);
    let camera = description.cameras[0].clone();
    let mut view = Settings { size: (32, 32), ..Settings::default() }.view(camera);
    description.plan(&mut view.camera, forced);
    Scene::new(description, &view).expect("a sound scene")
}

const REPLICAS: u64 = 8;

#[test]
fn being_ready_for_every_effect_changes_no_picture() {
    for name in ["cornell", "glass"] {
        let plain = scene(name, &Forced::default());
        let ready = scene(name, &Forced { on: Effect::ALL.to_vec(), off: Vec::new() });
        assert_eq!(ready.effects(), Effects::all());
        for (method, samples) in [(Method::Bidirectional, 24.0), (Method::Mlt, nightly(150.0, 600.0))] {
            let settings = settings(method, (32, 32), samples);
            let t = disagreement(&replicate(&plain, &settings, REPLICAS), &replicate(&ready, &settings, REPLICAS));
            println!("{name}, {method:?}: max |t| {t:.1}");
            assert!(t < LIMIT, "{name} {method:?}: {t}");
        }
    }
}

#[test]
fn what_is_forced_off_is_missed() {
    let plain = scene("glass", &Forced::default());
    let settings = settings(Method::Bidirectional, (32, 32), 48.0);
    let without = |off: &[Effect]| scene("glass", &Forced { on: Vec::new(), off: off.to_vec() });
    let clear = without(&[Effect::Absorption]);
    assert!(!clear.effects().has(Effect::Absorption));
    let t = disagreement(&replicate(&plain, &settings, REPLICAS), &replicate(&clear, &settings, REPLICAS));
    println!("without absorption: max |t| {t:.1}");
    assert!(t > LIMIT, "{t}");
    // What is specular becomes as smooth as it can be without being it.
    let rough = without(&[Effect::MirrorReflection, Effect::ClearTransmission]);
    assert!(!rough.effects().has_specular() && rough.effects().has(Effect::RoughTransmission), "{:?}", rough.effects());
}

/// A mutation that the plan leaves out is one that no path of the scene can use.
#[test]
fn mutations_that_never_apply_are_suitable_for_no_path() {
    use ergodic_metropolis::Mutation;
    use ergodic_mutations::AnyMutation;
    use ergodic_pathspace::{Lengths, Path};
    use ergodic_render::{Purpose, stream};
    use ergodic_tests::{PathSource, space};

    let mut left_out = 0;
    for name in ["cornell", "glass"] {
        let space = space(name, (32, 32), Lengths { min_edges: 1, max_edges: 7 });
        let mut source = PathSource::new(&space);
        let mut rng = stream(5, Purpose::Chain, 3);
        let mut x = Path::default();
        let idle: Vec<AnyMutation> =
            AnyMutation::all().into_iter().filter(|m| m.never_applies(space.scene.effects()).is_some()).collect();
        left_out += idle.len();
        for _ in 0..5_000 {
            if source.draw(&mut x, &mut rng).is_some() {
                assert!(idle.iter().all(|mutation| mutation.suitability(&space, &x) == 0.0), "{name}");
            }
        }
    }
    assert!(left_out > 0, "no mutation is ever left out");
}
