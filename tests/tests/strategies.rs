//! Strategies of bidirectional sampling against each other and against densities computed from outside (Veach 10).

use ergodic_metropolis::RandomSource;
use ergodic_pathspace::{
    BidirectionalSampler, Lengths, Path, PathSpace, Roulette, contribution, density::ln_strategy_densities, raster,
};
use ergodic_render::{Purpose, stream};
use ergodic_scattering::luminance;
use ergodic_tests::{PathSource, space};

const SCENES: [&str; 5] = ["cornell", "ajar", "ring", "glass", "pool"];
const LENGTHS: Lengths = Lengths { min_edges: 1, max_edges: 8 };

fn relative(a: f64, b: f64) -> f64 {
    (a - b).abs() / a.abs().max(b.abs()).max(f64::MIN_POSITIVE)
}

/// What a sampler says of each of its paths against what the path alone says: estimate times density is f, the weight is
/// that of the power heuristic over all strategies, and so the weights of all strategies sum to 1.
fn check_connections(space: &PathSpace, roulette: Roulette, seed: u64, pairs: usize) -> (usize, f64, f64) {
    let scene = &*space.scene;
    let mut sampler = BidirectionalSampler::new(space.lengths, roulette);
    let mut rng = stream(seed, Purpose::Bidirectional, 1);
    let mut path = Path::default();
    let (mut checked, mut worst_estimate, mut worst_weight) = (0, 0.0f64, 0.0f64);
    for _ in 0..pairs {
        sampler.sample(scene, &mut rng, |sampler, c| {
            sampler.assemble(scene, c.s, c.t, &mut path);
            let k = path.length();
            let survive = |s: usize| -> f64 {
                (0..s).map(|i| roulette.survival(i).ln()).sum::<f64>()
                    + (0..k + 1 - s).map(|i| roulette.survival(i).ln()).sum::<f64>()
            };
            let ln_p: Vec<f64> =
                ln_strategy_densities(scene, &path).iter().enumerate().map(|(s, p)| p + survive(s)).collect();
            let f = contribution(scene, &path);
            let expected = (f.ln_luminance() - ln_p[c.s]).exp();
            worst_estimate = worst_estimate.max(relative(luminance(c.estimate), expected));
            let sum: f64 = ln_p.iter().map(|p| (2.0 * (p - ln_p[c.s])).exp()).sum();
            worst_weight = worst_weight.max((c.weight - 1.0 / sum).abs());
            assert_eq!(raster(scene, &path).map(|r| r.distance(c.raster) < 1e-6), Some(true));
            checked += 1;
        });
    }
    (checked, worst_estimate, worst_weight)
}

#[test]
fn every_connection_agrees_with_the_path_seen_from_outside() {
    for name in SCENES {
        let space = space(name, (32, 32), LENGTHS);
        for roulette in [Roulette::OFF, Roulette { start: 3, survival: 0.6 }] {
            let (checked, estimate, weight) = check_connections(&space, roulette, 11, 6000);
            println!("{name}: {checked} connections, estimate {estimate:.1e}, weight {weight:.1e}");
            assert!(checked > 1000, "{name}: only {checked} connections");
            assert!(estimate < 1e-6, "{name}: estimate and f / p differ by {estimate}");
            assert!(weight < 1e-6, "{name}: weights do not sum to 1, by {weight}");
        }
    }
}

#[test]
fn paths_are_unoccluded_and_their_edges_can_be_dropped() {
    for name in SCENES {
        let space = space(name, (32, 32), LENGTHS);
        let mut source = PathSource::new(&space);
        let mut rng = stream(3, Purpose::Bidirectional, 2);
        let mut path = Path::default();
        let mut blocked = 0;
        for _ in 0..3000 {
            if source.draw(&mut path, &mut rng).is_none() {
                continue;
            }
            blocked += usize::from(!path.is_unoccluded(&space.scene));
            let kept = path.edges.clone();
            let before = contribution(&space.scene, &path);
            path.recompute_edges(&space.scene);
            assert_eq!(kept, path.edges);
            assert_eq!(before, contribution(&space.scene, &path));
        }
        // Tracing and connecting may disagree where an edge grazes an edge of a mesh, which is rare.
        assert!(blocked <= 2, "{name}: {blocked} paths have a blocked edge");
    }
}

/// Each single strategy estimates the same integral wherever it can make the paths (T9).
#[test]
fn single_strategies_agree_per_length() {
    let space = space("cornell", (32, 32), Lengths { min_edges: 1, max_edges: 4 });
    let scene = &*space.scene;
    let mut sampler = BidirectionalSampler::new(space.lengths, Roulette::OFF);
    let mut rng = stream(5, Purpose::Bidirectional, 3);
    let n = 400_000;
    let mut sums = vec![vec![(0.0f64, 0.0f64); 6]; 6];
    for _ in 0..n {
        sampler.sample(scene, &mut rng, |_, c| {
            let value = luminance(c.estimate);
            let entry = &mut sums[c.s + c.t - 1][c.s];
            entry.0 += value;
            entry.1 += value * value;
        });
    }
    let n = f64::from(n);
    for (k, by_s) in sums.iter().enumerate().take(5).skip(2) {
        // Strategies with a bounded integrand: s from 1 to k - 1, and s = k (light image).
        let estimates: Vec<(usize, f64, f64)> = (0..=k)
            .map(|s| {
                let (sum, squares) = by_s[s];
                let mean = sum / n;
                (s, mean, ((squares / n - mean * mean) / n).sqrt())
            })
            .collect();
        for &(s, mean, error) in &estimates {
            println!("length {k}, s = {s}: {mean:.5} +- {error:.5}");
        }
        for &(s, a, ea) in &estimates {
            for &(u, b, eb) in &estimates {
                let z = (a - b) / (ea * ea + eb * eb).sqrt();
                assert!(z.abs() < 5.0, "length {k}: strategies {s} and {u} differ: {a} +- {ea}, {b} +- {eb}");
            }
        }
    }
}

/// A planted fault shows that the comparison above can fail: a fault of 3 % in one strategy is seen.
#[test]
fn a_strategy_with_a_wrong_density_is_caught() {
    let space = space("cornell", (32, 32), Lengths { min_edges: 2, max_edges: 2 });
    let mut sampler = BidirectionalSampler::new(space.lengths, Roulette::OFF);
    let mut rng = stream(6, Purpose::Bidirectional, 4);
    let n = 500_000;
    let mut sums = [(0.0f64, 0.0f64); 3];
    for _ in 0..n {
        sampler.sample(&space.scene, &mut rng, |_, c| {
            let fault = if c.s == 1 { 1.03 } else { 1.0 };
            let value = luminance(c.estimate) * fault;
            sums[c.s].0 += value;
            sums[c.s].1 += value * value;
        });
    }
    let n = f64::from(n);
    let estimate = |s: usize| {
        let mean = sums[s].0 / n;
        (mean, (sums[s].1 / n - mean * mean) / n)
    };
    let ((a, va), (b, vb)) = (estimate(1), estimate(2));
    let z = (a - b) / (va + vb).sqrt();
    assert!(z.abs() > 5.0, "z = {z}");
}

#[test]
fn the_random_source_of_a_walk_is_one_stream() {
    // The same stream gives the same paths: nothing else is drawn from.
    let space = space("cornell", (16, 16), LENGTHS);
    let draw = || {
        let mut rng = stream(9, Purpose::Bidirectional, 5);
        let mut source = PathSource::new(&space);
        let mut path = Path::default();
        let weights: Vec<_> = (0..200).map(|_| source.draw(&mut path, &mut rng)).collect();
        (weights, rng.uniform())
    };
    assert_eq!(draw(), draw());
}
