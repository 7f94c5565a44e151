//! The laws of every mutation on real scenes: the way back has support, detailed balance, the density is the sampler's,
//! and one step from exact samples leaves the target invariant; and planted faults that break them.

use std::f64::consts::PI;

use ergodic_geometry::Anchor;
use ergodic_laws::faults::Scaled;
use ergodic_laws::{Flow, FlowVerdict, Invariance};
use ergodic_metropolis::{Chain, Mixture, Mutation, RandomSource, Step, Target};
use ergodic_mutations::{AnyMutation, Bidirectional, Caustic, Lens, LensSubpath, MultiChain, Rejection, Splice};
use ergodic_pathspace::{Kind, Lengths, LuminanceTarget, Path, PathSpace, Vertex, contribution};
use ergodic_render::{Purpose, stream};
use ergodic_scattering::{Component, luminance};
use ergodic_tests::{PathSource, layered_room, nightly, space, view_of};
use glam::DVec3;

const SCENES: [&str; 5] = ["cornell", "ajar", "glass", "pool", "dusk"];
pub(crate) const SIZE: (u32, u32) = (64, 64);
pub(crate) const LENGTHS: Lengths = Lengths { min_edges: 1, max_edges: 8 };

pub(crate) fn members() -> Vec<AnyMutation> {
    AnyMutation::all()
}

pub(crate) fn mixture(members: Vec<AnyMutation>) -> Mixture<AnyMutation> {
    Mixture::new(members.into_iter().map(|m| (1.0, m)).collect()).expect("weights are positive")
}

/// ln C of a path from its points alone.
fn ln_target(x: &Path) -> f64 {
    let target = LuminanceTarget::default();
    <LuminanceTarget>::ln_density(&target.evaluate(x))
}

#[test]
fn the_way_back_has_support_and_balance_is_detailed() {
    for name in SCENES {
        check_balance(name, &space(name, SIZE, LENGTHS));
    }
    check_balance("layered", &PathSpace { scene: view_of(layered_room(), SIZE), lengths: LENGTHS });
}

pub(crate) fn check_balance(name: &str, space: &PathSpace) {
    for mutation in members() {
        let (mut tried, mut one_way, mut suitable, mut stale_is_seen) = (0u32, 0u32, 0u32, 0u32);
        let mut source = PathSource::new(space);
        let mut rng = stream(17, Purpose::Chain, 1);
        let (mut x, mut y) = (Path::default(), Path::default());
        for _ in 0..20_000 {
            if source.draw(&mut x, &mut rng).is_none() || mutation.suitability(space, &x) == 0.0 {
                continue;
            }
            suitable += 1;
            let Ok(plan) = mutation.propose(space, &x, &mut y, &mut rng) else { continue };
            let ln_fy = ln_target(&y);
            if ln_fy == f64::NEG_INFINITY {
                continue;
            }
            tried += 1;
            let forward = mutation.ln_density(space, &x, &y, plan);
            let backward = mutation.ln_density(space, &y, &x, plan);
            assert!(forward.is_finite(), "{name} {}: forward density {forward}", mutation.name());
            assert!(!backward.is_nan() && backward < f64::INFINITY, "{name} {}: {backward}", mutation.name());
            assert!(mutation.suitability(space, &y) > 0.0 || backward == f64::NEG_INFINITY);
            one_way += u32::from(backward == f64::NEG_INFINITY);
            // What the candidate has cached is what follows from its points, and the film sees it.
            let mut again = y.clone();
            again.derive(&space.scene);
            assert_eq!(again.edges, y.edges, "{name} {}", mutation.name());
            assert_eq!(again.scattering, y.scattering, "{name} {}", mutation.name());
            assert!(y.raster.is_some() && again.raster == y.raster);
            // The ends are those of x, whatever the buffer held before.
            let kept = |a: &Vertex, b: &Vertex| a.position == b.position && a.interaction.ng == b.interaction.ng;
            let ends = |path: &Path| path.vertices.len() - plan.suffix;
            assert!(x.vertices[..plan.prefix].iter().zip(&y.vertices).all(|(a, b)| kept(a, b)));
            assert!(x.vertices[ends(&x)..].iter().zip(&y.vertices[ends(&y)..]).all(|(a, b)| kept(a, b)));
            // What was kept of x where it no longer holds would be seen.
            stale_is_seen += u32::from(again.scattering != x.scattering && again.edges != x.edges);
            if backward == f64::NEG_INFINITY {
                continue;
            }
            // K(x, y) C(x) == K(y, x) C(y), the acceptance computed once from either side.
            let ln_fx = ln_target(&x);
            let ratio = (ln_fy - forward) - (ln_fx - backward);
            let flow_there = ln_fx + forward + ratio.min(0.0);
            let ratio_back = (ln_target(&x) - mutation.ln_density(space, &y, &x, plan))
                - (ln_target(&again) - mutation.ln_density(space, &x, &again, plan));
            let flow_back = ln_target(&again) + backward + ratio_back.min(0.0);
            assert!(
                (flow_there - flow_back).abs() <= 1e-9 * flow_there.abs().max(1.0),
                "{name} {}: {flow_there} {flow_back}",
                mutation.name()
            );
        }
        assert!(20 * stale_is_seen >= tried, "{name} {}: {stale_is_seen} of {tried}", mutation.name());
        println!("{name} {}: {suitable} suitable, {tried} tried, {one_way} without a way back", mutation.name());
        // Only the caustic perturbation has ranges that depend on the path, so only it may lose the way back.
        let allowed = if matches!(mutation, AnyMutation::Caustic(_)) { tried / 5 } else { 0 };
        assert!(one_way <= allowed, "{name} {}: {one_way} of {tried} have no way back", mutation.name());
    }
}

/// Test functions of a path: image cells, length, brightness, places along the path, which light, which component.
const FUNCTIONS: usize = 32;

fn functions(x: &Path, out: &mut [f64; FUNCTIONS]) {
    out.fill(0.0);
    let k = x.length();
    let (width, height) = (f64::from(SIZE.0), f64::from(SIZE.1));
    let r = x.raster.expect("paths of the space meet the image");
    let cell = |v: f64, n: f64| ((v / n * 4.0) as usize).min(3);
    out[cell(r.y, height) * 4 + cell(r.x, width)] = 1.0;
    if k <= 6 {
        out[15 + k] = 1.0;
    }
    out[22] = contribution(x).ln_luminance().clamp(-30.0, 30.0);
    let first = if x.vertices[0].is_surface() { x.vertices[0].position } else { DVec3::ZERO };
    out[23] = first.x;
    out[24] = x.vertices[1.min(k - 1)].position.y;
    out[25] = x.vertices[k - 1].position.x;
    out[26] = x.vertices[k - 1].position.z;
    out[27] = x.vertices[1..k].iter().filter(|v| v.component != Component::Rough).count() as f64;
    out[28] = x.vertices[1..k].iter().filter(|v| v.component == Component::DiracTransmission).count() as f64;
    out[29] = x.vertices[1.max(k / 2)].position.x;
    out[30] = x.edges[k - 1].direction.dot(x.edges[k / 2].direction);
    out[31] = f64::from(u8::from(matches!(x.vertices[0].kind, Kind::Surface))) * (first.z + x.edges[0].direction.y);
}

/// The cell of a path for the flow law: a quarter of the image, and whether the path is short. Few cells, because the law
/// takes z for normal, which needs many moves both ways between any two.
fn cell(x: &Path, h: &[f64; FUNCTIONS]) -> usize {
    let on_image = h[..16].iter().position(|v| *v > 0.0).unwrap_or(0);
    let (row, column) = (on_image / 4, on_image % 4);
    (row / 2 * 2 + column / 2) * 2 + usize::from(x.length() > 3)
}

/// The invariance law and the flow law of several kernels, from the same exact weighted samples.
pub(crate) fn drifts<M>(space: &PathSpace, kernels: &[M], samples: usize, seed: u64) -> Vec<(Invariance, Flow)>
where
    M: Mutation<Space = PathSpace, State = Path>,
{
    let mut laws = vec![(Invariance::new(FUNCTIONS), Flow::new()); kernels.len()];
    let mut source = PathSource::new(space);
    let mut rng = stream(seed, Purpose::Chain, 2);
    let mut x = Path::default();
    let (mut hx, mut hy) = ([0.0; FUNCTIONS], [0.0; FUNCTIONS]);
    let target = LuminanceTarget::default();
    for _ in 0..samples {
        let Some(weight) = source.draw(&mut x, &mut rng) else { continue };
        functions(&x, &mut hx);
        for (kernel, (law, flow)) in kernels.iter().zip(&mut laws) {
            if kernel.suitability(space, &x) == 0.0 {
                law.record_stay();
                continue;
            }
            let mut chain = Chain::new(x.clone(), &target);
            match chain.step(&target, kernel, space, &mut rng) {
                Step::NotProposed(_) => law.record_stay(),
                Step::Faulty { .. } => law.record_fault(),
                // A candidate that carries nothing has no test functions.
                Step::Tried { acceptance: 0.0, .. } => law.record_stay(),
                Step::Tried { acceptance, accepted, .. } => {
                    let y = if accepted { chain.current().0 } else { chain.other().0 };
                    functions(y, &mut hy);
                    law.record(weight, acceptance, &hx, &hy);
                    flow.record(weight * acceptance, cell(&x, &hx), cell(y, &hy));
                }
            }
        }
    }
    laws
}

/// For each kernel on each of the five scenes the law may fail once in this many runs by chance.
pub(crate) const ALPHA: f64 = 1e-5;

/// What a planted fault must reach, far above any limit.
pub(crate) const CAUGHT: f64 = 8.0;

/// The invariance law and the flow law of every mutation alone and of all together.
pub(crate) fn check_kernels(name: &str, space: &PathSpace, samples: usize) {
    let mut kernels: Vec<Mixture<AnyMutation>> = members().into_iter().map(|m| mixture(vec![m])).collect();
    kernels.push(mixture(members()));
    let found = drifts(space, &kernels, samples, 23);
    for (kernel, (law, flow)) in kernels.iter().zip(&found) {
        let names: Vec<_> = kernel.members().iter().map(|(_, m)| m.name()).collect();
        let (steps, moves, faults) = law.counts();
        if moves == 0 && faults == 0 {
            // Nothing in this scene suits the mutation.
            println!("{name} {names:?}: no moves in {steps} steps");
            continue;
        }
        let verdict = law.verdict(ALPHA);
        let balance = flow.verdict();
        println!(
            "{name} {names:?}: max |t| = {:.2} of {:.2}, Q = {:.0} of {:.0}, {moves} moves",
            verdict.max_t, verdict.limit, balance.q, balance.limit
        );
        assert!(verdict.holds, "{name} {names:?}: {verdict:?}, {:?}", law.t());
        assert!(balance.holds || balance.dof == 0, "{name} {names:?}: {balance:?}");
    }
}

fn check_invariance(name: &str, samples: usize) {
    check_kernels(name, &space(name, SIZE, LENGTHS), samples);
}

#[test]
fn one_step_leaves_the_target_invariant_in_cornell() {
    check_invariance("cornell", nightly(150_000, 4_000_000));
}

#[test]
fn one_step_leaves_the_target_invariant_in_ajar() {
    check_invariance("ajar", nightly(150_000, 4_000_000));
}

#[test]
fn one_step_leaves_the_target_invariant_in_glass() {
    check_invariance("glass", nightly(150_000, 4_000_000));
}

#[test]
fn one_step_leaves_the_target_invariant_in_dusk() {
    check_invariance("dusk", nightly(150_000, 4_000_000));
}

#[test]
fn one_step_leaves_the_target_invariant_in_pool() {
    check_invariance("pool", nightly(150_000, 4_000_000));
}

/// What a fault multiplies a density by, given both paths and the plan: the logarithm.
pub(crate) type LnFactor<'a> = dyn Fn(&Path, &Path, (usize, Splice)) -> f64 + 'a;

/// The largest |t| of a mixture whose density is wrong by a factor, and what the flow law says.
fn fault_drift(
    space: &PathSpace,
    members: Vec<AnyMutation>,
    samples: usize,
    ln_factor: &LnFactor,
) -> (f64, FlowVerdict) {
    let factor = |from: &Path, to: &Path, plan| ln_factor(from, to, plan).exp();
    let (law, flow) = &drifts(space, &[Scaled { mutation: mixture(members), factor }], samples, 29)[0];
    let (z, balance) = (law.verdict(ALPHA).max_t, flow.verdict());
    println!("planted fault: max |t| = {z:.1}, Q = {:.0} of {:.0}", balance.q, balance.limit);
    (z, balance)
}

/// The largest |t| of a mixture whose density is wrong by a factor.
pub(crate) fn drift_of(space: &PathSpace, members: Vec<AnyMutation>, samples: usize, ln_factor: &LnFactor) -> f64 {
    fault_drift(space, members, samples, ln_factor).0
}

/// A scene with short paths only: longer ones come with weights so uneven that they hide what faults show.
fn short(scene: &str) -> PathSpace {
    space(scene, SIZE, Lengths { min_edges: 1, max_edges: 5 })
}

/// Mutations whose choice depends much on the path. Lens subpaths suit the paths that the lens perturbation suits, which makes it more even.
fn uneven() -> Vec<AnyMutation> {
    members().into_iter().filter(|mutation| !matches!(mutation, AnyMutation::LensSubpath(_))).collect()
}

#[test]
fn a_forgotten_choice_probability_is_caught() {
    let (all, space) = (mixture(uneven()), short("cornell"));
    let z = drift_of(&space, uneven(), 100_000, &|from, _, (index, _)| -all.probability(index, &space, from).ln());
    assert!(z > CAUGHT, "z = {z}");
}

#[test]
fn a_probability_read_from_the_wrong_path_is_caught() {
    let (all, space) = (mixture(uneven()), short("cornell"));
    let (z, balance) = fault_drift(&space, uneven(), 100_000, &|from, to, (index, _)| {
        all.probability(index, &space, to).ln() - all.probability(index, &space, from).ln()
    });
    assert!(z > CAUGHT && !balance.holds, "z = {z}, {balance:?}");
}

#[test]
fn a_lost_jacobian_is_caught() {
    // The step from solid angle to area at the vertex that the lens perturbation connects.
    let space = short("cornell");
    let z = drift_of(&space, vec![AnyMutation::Lens(Lens::default())], 100_000, &|_, to, (_, plan)| {
        -to.edges[plan.prefix].to_light_side.ln()
    });
    assert!(z > CAUGHT, "z = {z}");
    // The same of the caustic perturbation.
    let z = drift_of(&space, vec![AnyMutation::Caustic(Caustic::default())], 100_000, &|_, to, (_, plan)| {
        -to.edges[plan.prefix - 1].to_eye_side.ln()
    });
    assert!(z > CAUGHT, "z = {z}");
}

#[test]
fn a_missing_eta_squared_is_caught() {
    // The bidirectional mutation's new Dirac transmissions without n²: the product over the way in and the way out of a solid.
    // Few mutations change the number of refractions, hence the many samples.
    let (z, balance) = fault_drift(
        &short("glass"),
        vec![AnyMutation::Bidirectional(Bidirectional {})],
        1_000_000,
        &|_, to, (_, plan)| {
            let changed = plan.prefix.max(1)..to.vertices.len() - plan.suffix;
            let refractions = to.vertices[changed].iter().filter(|v| v.component == Component::DiracTransmission);
            -refractions.map(|v| v.interaction.index_below().ln()).sum::<f64>()
        },
    );
    assert!(z > CAUGHT && !balance.holds, "z = {z}, {balance:?}");
}

/// The caustic perturbation with the range of angles not recomputed for the way back: where the true density is 0 because
/// the angle lies outside the other path's range, the fault has one all the same.
#[derive(Clone, Copy)]
struct StaleRange;

impl Mutation for StaleRange {
    type Space = PathSpace;
    type State = Path;
    type Plan = Splice;
    type Failure = Rejection;

    fn suitability(&self, space: &PathSpace, x: &Path) -> f64 {
        narrow().suitability(space, x)
    }

    fn propose(
        &self,
        space: &PathSpace,
        x: &Path,
        y: &mut Path,
        rng: &mut impl RandomSource,
    ) -> Result<Splice, Rejection> {
        narrow().propose(space, x, y, rng)
    }

    fn ln_density(&self, space: &PathSpace, from: &Path, to: &Path, plan: Splice) -> f64 {
        let (narrow, wide) = (narrow(), wide());
        let density = narrow.ln_density(space, from, to, plan);
        if density > f64::NEG_INFINITY {
            return density;
        }
        // 1 / (2π θ sin θ ln(θ₂/θ₁)) differs between the two ranges by the logarithm alone.
        let ln_ratio = |c: &Caustic| {
            let pixels = f64::from(SIZE.0) * f64::from(SIZE.1);
            ((c.image_share * pixels / PI).sqrt() / c.min_pixels).ln()
        };
        wide.ln_density(space, from, to, plan) + (ln_ratio(&wide) / ln_ratio(&narrow)).ln()
    }
}

fn narrow() -> Caustic {
    Caustic { min_pixels: 1.0, image_share: 0.002 }
}

fn wide() -> Caustic {
    Caustic { min_pixels: 1e-4, image_share: 1.0 }
}

#[test]
fn a_range_of_angles_that_is_not_recomputed_is_caught() {
    let space = space("cornell", SIZE, LENGTHS);
    let right = drifts(&space, &[narrow()], 150_000, 31)[0].0.verdict(ALPHA);
    let wrong = drifts(&space, &[StaleRange], 150_000, 31)[0].0.verdict(ALPHA);
    println!("right {:.1}, wrong {:.1}", right.max_t, wrong.max_t);
    assert!(right.holds, "{right:?}");
    assert!(wrong.max_t > CAUGHT, "{wrong:?}");
}

/// Over proposals, E[1/T; plan, y in a region] is the measure of the region: its area when one rough vertex moves (the
/// volume law). `region` says whether the moved vertex lies in it.
fn volume(
    space: &PathSpace,
    mutation: &AnyMutation,
    x: &Path,
    plan: Splice,
    proposals: u32,
    region: impl Fn(DVec3) -> bool,
    fault: impl Fn(&Path) -> f64,
) -> (f64, f64) {
    let mut rng = stream(37, Purpose::Chain, 3);
    let mut y = Path::default();
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..proposals {
        if mutation.propose(space, x, &mut y, &mut rng) != Ok(plan) || y.vertices.len() != x.vertices.len() {
            continue;
        }
        if region(y.vertices[plan.prefix].position) {
            let w = (-mutation.ln_density(space, x, &y, plan)).exp() * fault(&y);
            sum += w;
            squares += w * w;
        }
    }
    let n = f64::from(proposals);
    let mean = sum / n;
    (mean, ((squares / n - mean * mean) / n).sqrt())
}

#[test]
fn the_density_is_that_of_the_sampler_by_volume() {
    let space = space("cornell", SIZE, Lengths { min_edges: 2, max_edges: 2 });
    // A path light -> floor -> eye whose floor vertex has open floor beside it.
    let mut source = PathSource::new(&space);
    let mut rng = stream(41, Purpose::Chain, 4);
    let mut x = Path::default();
    let (floor, _) = space.scene.world().bounds();
    let on_floor = |p: DVec3| (p.y - floor.y).abs() < 1e-9;
    let half = 0.025;
    let mut middle = DVec3::ZERO;
    let found = (0..100_000).any(|_| {
        if source.draw(&mut x, &mut rng).is_none() || x.length() != 2 || !on_floor(x.vertices[1].position) {
            return false;
        }
        // A patch beside the vertex, farther than the smallest jump, all of it seen by the eye and by the light's point.
        middle = x.vertices[1].position + DVec3::new(0.05, 0.0, 0.0);
        let free = |p: DVec3| Anchor { position: p, normal: DVec3::ZERO };
        let seen = |p: DVec3| {
            let p = Anchor { position: p, normal: DVec3::Y };
            let world = space.scene.world();
            world.visible(&p, &free(x.vertices[2].position)) && world.visible(&p, &x.vertices[0].anchor())
        };
        let grid = |i: i32| f64::from(i) / 4.0 * half;
        (-4..=4).all(|i| (-4..=4).all(|j| seen(middle + DVec3::new(grid(i), 0.0, grid(j)))))
    });
    assert!(found, "no path over an open part of the floor");
    let in_patch = |p: DVec3| on_floor(p) && (p.x - middle.x).abs() < half && (p.z - middle.z).abs() < half;
    let area = 4.0 * half * half;
    let plan = Splice { prefix: 1, suffix: 1 };
    for (mutation, proposals) in [
        (AnyMutation::Lens(Lens::default()), 1_000_000),
        (AnyMutation::Caustic(Caustic::default()), 1_000_000),
        (AnyMutation::Bidirectional(Bidirectional {}), 6_000_000),
        (AnyMutation::LensSubpath(LensSubpath {}), 1_000_000),
    ] {
        let (measured, error) = volume(&space, &mutation, &x, plan, proposals, in_patch, |_| 1.0);
        println!("{}: {measured:.3e} +- {error:.1e}, area {area:.3e}", mutation.name());
        assert!(error < 0.08 * area, "{}: too few samples, {error}", mutation.name());
        assert!((measured - area).abs() < 5.0 * error, "{}: {measured} +- {error}, want {area}", mutation.name());
        // The law can fail: without the cosine at the new vertex the volume is another.
        let faulty = |y: &Path| y.vertices[1].interaction.ng.dot(y.edges[1].direction).abs();
        let (measured, error) = volume(&space, &mutation, &x, plan, proposals, in_patch, faulty);
        assert!((measured - area).abs() > 5.0 * error, "{}: the planted fault passes", mutation.name());
    }
}

/// Perturbations through several chains move only paths that have them; everything moves by the bidirectional mutation.
#[test]
fn every_path_can_be_moved() {
    for name in SCENES {
        let space = space(name, SIZE, LENGTHS);
        let mut source = PathSource::new(&space);
        let mut rng = stream(43, Purpose::Chain, 5);
        let (mut x, mut y) = (Path::default(), Path::default());
        let bidirectional = AnyMutation::Bidirectional(Bidirectional {});
        let mut multi_chain = 0;
        for _ in 0..300 {
            if source.draw(&mut x, &mut rng).is_none() {
                continue;
            }
            multi_chain += usize::from(AnyMutation::MultiChain(MultiChain::default()).suitability(&space, &x) > 0.0);
            let moved = (0..100_000).any(|_| {
                bidirectional.propose(&space, &x, &mut y, &mut rng).is_ok_and(|plan| {
                    ln_target(&y) > f64::NEG_INFINITY
                        && bidirectional.ln_density(&space, &y, &x, plan) > f64::NEG_INFINITY
                        && luminance(contribution(&y).rgb) > 0.0
                })
            });
            assert!(moved, "{name}: stuck at {}", x.class());
        }
        println!("{name}: {multi_chain} of 300 suit the multi-chain perturbation");
    }
}
