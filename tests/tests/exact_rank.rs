//! The exact rank test (Gandy and Scott 2021, algorithm 2): a chain in equilibrium does not know where it began.
//!
//! One state is drawn exactly from the target and put at a random place of a run of L states; the others are made from it by
//! the kernel, forward and, because a reversible kernel is its own reverse, backward. Whatever is measured of the states, the
//! rank of the first one among them is uniform if and only if the kernel is reversible for the target.

use ergodic_laws::{chi_square, faults::Scaled};
use ergodic_metropolis::{Chain, Mutation, RandomSource, Target};
use ergodic_mutations::Splice;
use ergodic_pathspace::{BidirectionalSampler, Lengths, LuminanceTarget, Path, PathSpace, Roulette};
use ergodic_render::{Purpose, stream};
use ergodic_scattering::luminance;
use ergodic_tests::{Eye, cuboid, diffuse, nightly, scene_of};
use glam::DVec3;
use rand_pcg::Pcg64Dxsm;

use crate::mutation_laws::{members, mixture};

/// States of a run.
const LENGTH: usize = 8;

/// Quantities whose ranks are looked at.
const QUANTITIES: usize = 4;

/// A room that emits more on one side; paths of up to three edges carry bounded contributions.
fn room() -> PathSpace {
    let mut things = vec![(cuboid(DVec3::new(1.0, 1.0, 0.5), true), diffuse(0.7, 1.0))];
    let mut block = cuboid(DVec3::splat(0.3), false);
    block.positions.iter_mut().for_each(|p| *p += DVec3::new(-0.4, 0.5, -0.2));
    things.push((block, diffuse(0.5, 3.0)));
    let eye = Eye { from: DVec3::new(0.6, -0.6, 0.1), at: DVec3::new(-0.6, 0.6, -0.2), up: DVec3::Z, fov: 1.2 };
    PathSpace { scene: scene_of(things, Vec::new(), &eye, 32), lengths: Lengths { min_edges: 1, max_edges: 3 } }
}

/// Exact draws from the target by rejection: bidirectional samples, kept with probability proportional to their weight.
struct Exact<'a> {
    space: &'a PathSpace,
    sampler: BidirectionalSampler,
    bound: f64,
}

impl<'a> Exact<'a> {
    fn new(space: &'a PathSpace) -> Self {
        let mut sampler = BidirectionalSampler::new(space.lengths, Roulette::OFF);
        let mut rng = stream(1, Purpose::Seeding, 0);
        let most = (0..300_000).map(|_| Self::weigh(&mut sampler, space, &mut rng)).fold(0.0, f64::max);
        Self { space, sampler, bound: 1.5 * most }
    }

    fn weigh(sampler: &mut BidirectionalSampler, space: &PathSpace, rng: &mut Pcg64Dxsm) -> f64 {
        let mut sum = 0.0;
        sampler.sample(&space.scene, rng, |_, c| sum += luminance(c.contribution()));
        sum
    }

    fn draw(&mut self, rng: &mut Pcg64Dxsm) -> Path {
        loop {
            let before = rng.clone();
            let weight = Self::weigh(&mut self.sampler, self.space, rng);
            assert!(weight <= self.bound, "{weight} exceeds the bound {}", self.bound);
            if rng.uniform() * self.bound >= weight {
                continue;
            }
            // The same sample again, for one of its connections.
            let (mut again, mut remaining) = (before, rng.uniform() * weight);
            let mut path = Path::default();
            self.sampler.sample(&self.space.scene, &mut again, |sampler, c| {
                let of_this = luminance(c.contribution());
                if of_this > 0.0 && remaining >= 0.0 {
                    sampler.assemble(&self.space.scene, c.s, c.t, &mut path);
                    remaining -= of_this;
                }
            });
            return path;
        }
    }
}

fn quantities(x: &Path) -> [f64; QUANTITIES] {
    let at = x.raster.expect("paths of the space meet the image");
    let brightness = <LuminanceTarget>::ln_density(&LuminanceTarget::default().evaluate(x));
    [at.x, x.length() as f64, brightness, x.vertices[0].position.z]
}

/// Probabilities that the ranks of each quantity are uniform.
fn ranks<M>(space: &PathSpace, kernel: &M, runs: usize, seed: u64) -> [f64; QUANTITIES]
where
    M: Mutation<Space = PathSpace, State = Path>,
{
    let target = LuminanceTarget::default();
    let mut exact = Exact::new(space);
    let mut rng = stream(seed, Purpose::Chain, 21);
    let mut counts = [[0u64; LENGTH]; QUANTITIES];
    for _ in 0..runs {
        let start = exact.draw(&mut rng);
        let here = quantities(&start);
        let place = rng.below(LENGTH);
        let mut less = [0usize; QUANTITIES];
        let mut equal = [0usize; QUANTITIES];
        for steps in [place, LENGTH - 1 - place] {
            let mut chain = Chain::new(start.clone(), &target);
            for _ in 0..steps {
                chain.step(&target, kernel, space, &mut rng);
                for (i, value) in quantities(chain.current().0).into_iter().enumerate() {
                    less[i] += usize::from(value < here[i]);
                    equal[i] += usize::from(value == here[i]);
                }
            }
        }
        for i in 0..QUANTITIES {
            // Ties are broken at random.
            counts[i][less[i] + rng.below(equal[i] + 1)] += 1;
        }
    }
    let expected = [runs as f64 / LENGTH as f64; LENGTH];
    counts.map(|counts| chi_square(&counts, &expected, 5.0).map_or(0.0, |test| test.p_value))
}

#[test]
fn a_chain_does_not_know_where_it_began() {
    let space = room();
    let runs = nightly(4_000, 100_000);
    let mut kernels: Vec<_> = members().into_iter().map(|m| mixture(vec![m])).collect();
    kernels.push(mixture(members()));
    for kernel in &kernels {
        let names: Vec<_> = kernel.members().iter().map(|(_, m)| m.name()).collect();
        let found = ranks(&space, kernel, runs, 61);
        println!("{names:?}: p = {found:.3?}");
        // Some 20 ranks at 1e-5 for all of them.
        assert!(found.iter().all(|p| *p > 5e-7), "{names:?}: {found:?}");
    }
}

#[test]
fn a_chain_without_hastings_ratio_is_caught() {
    let space = room();
    // Every proposal is taken for symmetric.
    let right = mixture(members());
    let factor = |from: &Path, to: &Path, plan: (usize, Splice)| (-right.ln_density(&space, from, to, plan)).exp();
    let faulty = Scaled { mutation: mixture(members()), factor };
    let found = ranks(&space, &faulty, nightly(4_000, 100_000), 61);
    println!("without Hastings' ratio: p = {found:?}");
    assert!(found.iter().any(|p| *p < 1e-9), "{found:?}");
}
