//! Errors of pictures that the test against a stored reference must catch, at the power it claims; and none where there is
//! none.

use ergodic_assess::{Image, Reference, ReplicaTest, Verdict, test_replicas};
use ergodic_laws::faults::Scaled;
use ergodic_metropolis::{Mixture, RandomSource};
use ergodic_mutations::{AnyMutation, Splice};
use ergodic_pathspace::{BidirectionalSampler, Lengths, Path, Roulette, Scene};
use ergodic_render::{
    Budget, Direct, Estimator, Life, Method, Purpose, Settings, Stage, Unobserved, render_replicas,
    render_with_mixture, sample_image,
};
use ergodic_scattering::{Everything, Filter, Rgb};
use ergodic_tests::{description, image, nightly, root, view_of};
use glam::DVec2;

/// The level of a single case of `ergodic verify`.
const ALPHA: f64 = 1e-4;
const REPLICAS: u64 = 32;

fn reference(name: &str) -> Reference {
    Reference::read(&root().join("reference").join(format!("{name}.exr"))).unwrap_or_else(|e| panic!("{e}"))
}

fn scene(name: &str) -> Scene {
    let image = reference(name).mean;
    view_of(description(name), (image.width, image.height))
}

fn test(name: &str, replicas: &[Image]) -> ReplicaTest {
    test_replicas(replicas, &reference(name)).unwrap_or_else(|e| panic!("{e}"))
}

fn settings(method: Method, samples: f64, seed: u64) -> Settings {
    let mut settings =
        Settings { method, size: (64, 64), seed, budget: Budget::SamplesPerPixel(samples), ..Settings::default() };
    settings.mlt.direct = Direct::InChain;
    settings.mlt.chains = 64;
    // As in `verify`.
    settings.mlt.life = Life::Mutations(4096);
    settings.mlt.seeding.max_samples = 16_384;
    settings
}

#[test]
fn one_percent_of_the_total_is_caught_and_nothing_is_not() {
    let scene = scene("cornell");
    let mut caught = 0;
    let rounds = nightly(3, 20);
    for round in 0..rounds {
        let settings = settings(Method::Bidirectional, 4.0, 1000 * (round + 1));
        let renderings = render_replicas(&scene, &settings, REPLICAS as usize, &Unobserved).expect("valid settings");
        let mut replicas: Vec<Image> = renderings.iter().map(|r| image(&r.picture)).collect();
        let right = test("cornell", &replicas);
        assert_eq!(right.verdict(ALPHA), Verdict::Holds, "{:?}", right.total);
        for value in replicas.iter_mut().flat_map(|r| &mut r.pixels).flatten() {
            *value *= 1.01;
        }
        let wrong = test("cornell", &replicas);
        println!("right {:?}, wrong {:?}", right.total, wrong.total);
        caught += u32::from(wrong.verdict(ALPHA) == Verdict::Fails);
    }
    println!("caught in {caught} of {rounds} seeds");
    assert!(caught >= nightly(3, 19));
}

/// Bidirectional path tracing of the paths of one class only.
#[derive(Clone)]
struct OneClass {
    sampler: BidirectionalSampler,
    path: Path,
    class: &'static str,
}

impl Estimator for OneClass {
    type Repertoire = Everything;

    fn sample(&mut self, scene: &Scene, rng: &mut impl RandomSource, mut splat: impl FnMut(DVec2, Rgb)) {
        let Self { sampler, path, class } = self;
        sampler.sample(scene, rng, |sampler, c| {
            sampler.assemble(scene, c.s, c.t, path);
            if path.class().to_string() == *class {
                splat(c.raster, c.contribution());
            }
        });
    }
}

#[test]
fn a_caustic_ten_percent_too_bright_is_caught() {
    let scene = scene("glass");
    let class = "LSSDE";
    let caustic = OneClass {
        sampler: BidirectionalSampler::new(Lengths { min_edges: 4, max_edges: 4 }, Roulette::OFF),
        path: Path::default(),
        class,
    };
    let (rounds, mut caught) = (nightly(1, 20), 0);
    for round in 0..rounds {
        // As many samples as the second look of `ergodic verify` takes.
        let settings = settings(Method::Bidirectional, 48.0, 500 + 1000 * round);
        let renderings = render_replicas(&scene, &settings, REPLICAS as usize, &Unobserved).expect("valid settings");
        let right: Vec<Image> = renderings.iter().map(|r| image(&r.picture)).collect();
        let mut wrong = right.clone();
        for (replica, seed) in wrong.iter_mut().zip(10_500 + 1000 * round..) {
            let sampled = sample_image(
                &scene,
                &caustic,
                (64, 64),
                Filter::Box,
                Budget::SamplesPerPixel(8.0),
                (seed, Purpose::Bidirectional),
                (Stage::Rendering, &Unobserved),
            );
            for (pixel, more) in replica.pixels.iter_mut().zip(&sampled.picture(&scene).pixels) {
                *pixel = (Rgb::from_array(*pixel) + 0.1 * *more).to_array();
            }
        }
        let (right, wrong) = (test("glass", &right), test("glass", &wrong));
        println!("right p = {:.1e}, wrong p = {:.1e}, {:?}", right.p(), wrong.p(), wrong.worst());
        assert_ne!(right.verdict(ALPHA), Verdict::Fails, "{:?}", right.worst());
        caught += u32::from(wrong.verdict(ALPHA) == Verdict::Fails);
    }
    println!("{class} 10 % too bright: caught in {caught} of {rounds} seeds");
    assert!(caught >= nightly(1, 19));
}

#[test]
fn a_mutation_with_a_slightly_wrong_density_is_caught() {
    let scene = scene("cornell");
    let replicas = |factor: f64, round: u64| -> Vec<Image> {
        let members = AnyMutation::all().into_iter().map(|mutation| {
            let fault = if mutation.is_ergodic() { 1.0 } else { factor };
            // Off on one side of the image only.
            let factor = move |_: &Path, to: &Path, _: Splice| {
                if to.vertices[to.length() - 1].position.x > 0.0 { fault } else { 1.0 }
            };
            (1.0, Scaled { mutation, factor })
        });
        let mixture = Mixture::new(members.collect()).expect("weights are positive");
        let names: Vec<_> = AnyMutation::all().iter().map(AnyMutation::name).collect();
        let one = |seed: u64| {
            let settings = settings(Method::Mlt, 48.0, seed);
            let rendering = render_with_mixture(&scene, &settings, &mixture, &names, &Unobserved);
            image(&rendering.expect("valid settings").picture)
        };
        (0..REPLICAS).map(|i| one(9000 + 1000 * round + i)).collect()
    };
    let (rounds, mut caught) = (nightly(1, 20), 0);
    for round in 0..rounds {
        let right = test("cornell", &replicas(1.0, round));
        let wrong = test("cornell", &replicas(1.5, round));
        println!("right p = {:.1e}, wrong p = {:.1e}, {:?}", right.p(), wrong.p(), wrong.worst());
        assert_eq!(right.verdict(ALPHA), Verdict::Holds, "{:?}", right.worst());
        caught += u32::from(wrong.verdict(ALPHA) == Verdict::Fails);
        // The total is b, which knows nothing of the chains: it cannot tell.
        assert!(wrong.total.2 > 1e-4, "{:?}", wrong.total);
    }
    println!("caught in {caught} of {rounds} seeds");
    assert!(caught >= nightly(1, 19));
}
