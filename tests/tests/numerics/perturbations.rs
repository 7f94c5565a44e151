//! Perturbations at the limits of their ranges, and scenes in other units.

use ergodic_metropolis::Mutation;
use ergodic_mutations::{AnyMutation, Caustic, Lens, MultiChain};
use ergodic_pathspace::{BidirectionalSampler, Lengths, Path, PathSpace, Roulette, contribution};
use ergodic_render::{Purpose, stream};
use ergodic_scattering::luminance;
use ergodic_tests::{PathSource, description, nightly, space, view_of};
use glam::DVec3;

use super::units::in_units;
use crate::mutation_laws::{ALPHA, LENGTHS, SIZE, drifts};

#[test]
fn jumps_from_a_billionth_of_a_pixel_to_the_whole_image() {
    for name in ["cornell", "glass", "pool"] {
        let space = space(name, SIZE, LENGTHS);
        for (min_pixels, image_share, min_angle, max_angle) in
            [(1e-9, 1.0, 1e-12, 1.5), (1e-9, 1e-12, 1e-12, 1e-11), (40.0, 1.0, 1.0, 1.5)]
        {
            let kernels = [
                AnyMutation::Lens(Lens { min_pixels, image_share }),
                AnyMutation::Caustic(Caustic { min_pixels, image_share }),
                AnyMutation::MultiChain(MultiChain { min_pixels, image_share, min_angle, max_angle }),
            ];
            for (kernel, (law, _)) in kernels.iter().zip(drifts(&space, &kernels, nightly(40_000, 1_000_000), 51)) {
                let (steps, moves, faults) = law.counts();
                if moves == 0 && faults == 0 {
                    continue;
                }
                let verdict = law.verdict(ALPHA);
                println!(
                    "{name} {}, from {min_pixels:e} px to {image_share:e} of the image: max |t| = {:.2} of {:.2}, {moves} \
                     moves in {steps} steps, {faults} faults",
                    kernel.name(),
                    verdict.max_t,
                    verdict.limit
                );
                assert!(verdict.holds && faults == 0, "{name} {kernel:?}: {faults} faults, {verdict:?}");
            }
        }
    }
}

/// What a sample of a scene is, without its unit of length.
struct Seen {
    strategy: (usize, usize),
    numbers: Vec<f64>,
}

/// Bidirectional samples and proposals, from the same random numbers in every unit; `ln_unit` is the logarithm of the unit of
/// the scene's own space.
fn samples(space: &PathSpace, ln_unit: f64, count: u64) -> Vec<Vec<Seen>> {
    let scene = &space.scene;
    let mut sampler = BidirectionalSampler::new(space.lengths, Roulette::OFF);
    let mut source = PathSource::new(space);
    let (mut path, mut y) = (Path::default(), Path::default());
    (0..count)
        .map(|index| {
            let mut seen = Vec::new();
            sampler.sample(scene, &mut stream(1, Purpose::Bidirectional, index), |sampler, c| {
                sampler.assemble(scene, c.s, c.t, &mut path);
                // f has one 1 / length² for each edge.
                let ln_f = contribution(&path).ln_luminance() + 2.0 * path.length() as f64 * ln_unit;
                seen.push(Seen { strategy: (c.s, c.t), numbers: vec![luminance(c.estimate).ln(), c.weight, ln_f] });
            });
            let mut rng = stream(2, Purpose::Chain, index);
            if source.draw(&mut path, &mut rng).is_some() {
                for (i, mutation) in AnyMutation::all().iter().enumerate() {
                    let mut rng = stream(3 + i as u64, Purpose::Chain, index);
                    let Ok(plan) = mutation.propose(space, &path, &mut y, &mut rng) else { continue };
                    // T is per area of every new vertex.
                    let new = (y.vertices.len() - plan.prefix - plan.suffix) as f64;
                    let ln_t = mutation.ln_density(space, &path, &y, plan) + 2.0 * new * ln_unit;
                    seen.push(Seen { strategy: (i, 1000), numbers: vec![ln_t] });
                }
            }
            seen
        })
        .collect()
}

#[test]
fn densities_do_not_depend_on_the_unit_of_length() {
    let lengths = Lengths { min_edges: 1, max_edges: 8 };
    for name in ["cornell", "glass"] {
        let here = PathSpace { scene: view_of(description(name), (32, 32)), lengths };
        let count = nightly(2_000, 50_000);
        let expected = samples(&here, 0.0, count);
        for (scale, offset) in [
            (1e-6, DVec3::ZERO),
            (1e-3, DVec3::ZERO),
            (1e3, DVec3::ZERO),
            (1e6, DVec3::ZERO),
            (1.0, DVec3::new(1e6, -1e6, 5e5)),
        ] {
            let scene = view_of(in_units(description(name), scale, offset), (32, 32));
            let ln_unit = (scene.scale() * scale / here.scene.scale()).ln();
            let found = samples(&PathSpace { scene, lengths }, ln_unit, count);
            let (mut worst, mut other_ways, mut compared) = (0.0f64, 0, 0);
            for (a, b) in expected.iter().zip(&found) {
                if a.len() != b.len() || a.iter().zip(b).any(|(a, b)| a.strategy != b.strategy) {
                    // Rounding decided otherwise at the edge of something.
                    other_ways += 1;
                    continue;
                }
                for (a, b) in a.iter().zip(b).flat_map(|(a, b)| a.numbers.iter().zip(&b.numbers)) {
                    compared += 1;
                    if a != b {
                        worst = worst.max((a - b).abs());
                    }
                }
            }
            println!(
                "{name} scaled by {scale:e}, moved by {offset}: {compared} numbers differ by {worst:.1e} at most; {other_ways} of {count} samples went another way"
            );
            // A file that lies a million units away has lost digits itself: 1e-10 of the distance between its vertices.
            let tolerance = if offset == DVec3::ZERO { 1e-6 } else { 1e-3 };
            assert!(worst < tolerance, "{name}, scale {scale}, moved by {offset}: {worst}");
            // Inside glass a path that differs by rounding soon meets another facet.
            assert!(other_ways <= count / 20, "{other_ways}");
            assert!(compared > count as usize);
        }
    }
}
