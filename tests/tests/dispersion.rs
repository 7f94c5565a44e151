//! Light of many wavelengths: the laws of mutations where paths have one, agreement of all methods, the limit without dispersion,
//! and a prism against Snell's law; with faults that each must notice.

use ergodic_geometry::Mesh;
use ergodic_laws::faults::Scaled;
use ergodic_laws::{Invariance, detailed_balance, one_step_invariance, way_back};
use ergodic_metropolis::{Mixture, Mutation, RandomSource};
use ergodic_mutations::{AnyMutation, Bidirectional, Lens, Rejection, Splice};
use ergodic_pathspace::{LuminanceTarget, Path, PathSpace, Roulette, Scene, contribution};
use ergodic_render::{
    BidirectionalPathTracer, Method, Multiplexed, PathTracer, Picture, Purpose, Settings, Unobserved, render, stream,
};
use ergodic_scattering::{Component, Material, Rgb, Wavelength};
use ergodic_tests::{
    DISPERSIVE_INDEX, Estimate, Eye, PathSource, diffuse, dispersive_room, estimate, glass, nightly, quad, scene_of,
    settings, view_of,
};
use glam::DVec3;
use rand_pcg::Pcg64Dxsm;

use crate::mutation_laws::{ALPHA, CAUGHT, LENGTHS, SIZE, members, mixture};
use crate::primary_laws;

/// Far beyond any real glass, so that wavelengths part within a pixel's reach.
const DISPERSION: f64 = 4.0;

fn space() -> PathSpace {
    PathSpace { scene: view_of(dispersive_room(DISPERSION), SIZE), lengths: LENGTHS }
}

/// The index of the room's dispersive glass, from the extension's text with its rounded numbers.
fn index_by_the_text(wavelength: Wavelength) -> f64 {
    let square = wavelength.nanometres() * wavelength.nanometres();
    DISPERSIVE_INDEX + (DISPERSIVE_INDEX - 1.0) * DISPERSION / 20.0 * (523_655.0 / square - 1.5168)
}

/// How far the indices of a path's dispersive vertices are from that for its wavelength.
fn mismatch(x: &Path) -> f64 {
    let expected = index_by_the_text(x.wavelength);
    let vertices = x.vertices.iter().filter(|vertex| vertex.interaction.is_dispersive());
    let largest = vertices.map(|v| (v.interaction.index_below() - expected).abs()).fold(0.0, f64::max);
    // What the text's numbers are rounded by.
    if largest < 1e-4 { 0.0 } else { largest }
}

/// The mutations that have anything to do in the room; in media none.
fn suitable(space: &PathSpace) -> Vec<AnyMutation> {
    members().into_iter().filter(|mutation| mutation.never_applies(space.scene.effects()).is_none()).collect()
}

fn draw(space: &PathSpace) -> impl FnMut(&mut Pcg64Dxsm) -> Option<(Path, f64)> {
    let mut source = PathSource::new(space);
    move |rng| {
        let mut x = Path::default();
        source.draw(&mut x, rng).map(|weight| (x, weight))
    }
}

#[test]
fn the_way_back_has_support_and_balance_is_detailed_with_a_wavelength() {
    let space = space();
    let mut draw = draw(&space);
    let mut next = |rng: &mut Pcg64Dxsm| loop {
        if let Some((x, _)) = draw(rng) {
            return x;
        }
    };
    for mutation in suitable(&space) {
        let mut rng = stream(41, Purpose::Chain, 0);
        let back = way_back(&mutation, &space, &mut next, 20_000, &mut rng);
        // The caustic perturbation's range depends on the path.
        let one_way = if matches!(mutation, AnyMutation::Caustic(_)) { 0.2 } else { 0.0 };
        assert!(back.holds(one_way), "{}: {back:?}", mutation.name());
        let balance = detailed_balance(&LuminanceTarget::default(), &mutation, &space, &mut next, 20_000, &mut rng);
        assert!(balance.holds(1e-9), "{}: {balance:?}", mutation.name());

        let (mut moved, mut kept) = (0, 0);
        for _ in 0..20_000 {
            let x = next(&mut rng);
            let mut y = x.clone();
            assert_eq!(mismatch(&x), 0.0);
            let Ok(plan) = mutation.propose(&space, &x, &mut y, &mut rng) else { continue };
            assert_eq!(mismatch(&y), 0.0, "{}", mutation.name());
            let last = y.vertices.len() - plan.suffix;
            let keeps =
                y.vertices[..plan.prefix].iter().chain(&y.vertices[last..]).any(|v| v.interaction.is_dispersive());
            assert!(!keeps || x.wavelength == y.wavelength, "{}", mutation.name());
            kept += u32::from(keeps);
            moved += u32::from(x.wavelength != y.wavelength && y.response().is_some());
        }
        println!("{}: {moved} moves of a wavelength that matters, {kept} kept", mutation.name());
        assert!(moved > 20, "{}", mutation.name());
    }
}

/// Test functions of a path: its wavelength, and it together with where the path goes.
const FUNCTIONS: usize = 25;

/// Where the mismatch is among them.
const MISMATCH: usize = 24;

fn functions(x: &Path) -> [f64; FUNCTIONS] {
    let mut h = [0.0; FUNCTIONS];
    // A candidate that misses the image carries nothing.
    let Some(raster) = x.raster else { return h };
    let k = x.length();
    let share = (x.wavelength.nanometres() - Wavelength::SHORTEST) / (Wavelength::LONGEST - Wavelength::SHORTEST);
    let disperses = x.response().is_some();
    h[((share * 7.0) as usize).min(6) + if disperses { 7 } else { 0 }] = 1.0;
    let (across, down) = (raster.x / f64::from(SIZE.0), raster.y / f64::from(SIZE.1));
    h[14] = across;
    h[15] = down;
    h[16] = across * share;
    h[17] = down * share;
    h[18] = k as f64;
    h[19] = contribution(x).ln_luminance().clamp(-30.0, 30.0);
    h[20] = x.vertices[1..k].iter().filter(|v| v.interaction.is_dispersive()).count() as f64;
    h[21] = x.vertices[1..k].iter().filter(|v| v.component != Component::Rough).count() as f64;
    h[22] = x.vertices[1.min(k - 1)].position.x * share;
    h[23] = x.vertices[k - 1].position.z * share * f64::from(u8::from(disperses));
    h[MISMATCH] = mismatch(x);
    h
}

fn drift<M: Mutation<Space = PathSpace, State = Path>>(space: &PathSpace, kernel: &M, samples: u64) -> Invariance {
    let mut rng = stream(43, Purpose::Chain, 0);
    one_step_invariance(&LuminanceTarget::default(), kernel, space, draw(space), functions, samples, &mut rng)
}

#[test]
fn one_step_leaves_the_target_invariant_with_a_wavelength() {
    let space = space();
    let all = mixture(members());
    for kernel in suitable(&space).into_iter().map(|m| mixture(vec![m])).chain([all]) {
        let names: Vec<_> = kernel.members().iter().map(|(_, m)| m.name()).collect();
        let law = drift(&space, &kernel, nightly(200_000, 4_000_000));
        let verdict = law.verdict(ALPHA);
        println!("{names:?}: max |t| = {:.2} of {:.2}, {:?}", verdict.max_t, verdict.limit, law.counts());
        assert!(verdict.holds, "{names:?}: {verdict:?}, {:?}", law.t());
    }
}

#[test]
fn a_wavelength_in_the_wrong_measure_is_caught() {
    // As if it were uniform in frequency: the density in wavelength falls with its square.
    let space = space();
    for mutation in [AnyMutation::Bidirectional(Bidirectional {}), AnyMutation::Lens(Lens::default())] {
        let factor = |_: &Path, to: &Path, _: Splice| (500.0 / to.wavelength.nanometres()).powi(2);
        let verdict = drift(&space, &Scaled { mutation, factor }, 200_000).verdict(ALPHA);
        println!("{}: max |t| = {:.1}", mutation.name(), verdict.max_t);
        assert!(verdict.max_t > CAUGHT, "{}: {verdict:?}", mutation.name());
    }
}

/// The bidirectional mutation with a new wavelength although dispersive vertices are kept, whose index is still that for the old.
#[derive(Clone, Copy)]
struct AnyTime(Bidirectional);

impl Mutation for AnyTime {
    type Space = PathSpace;
    type State = Path;
    type Plan = Splice;
    type Failure = Rejection;

    fn propose(
        &self,
        space: &PathSpace,
        x: &Path,
        y: &mut Path,
        rng: &mut impl RandomSource,
    ) -> Result<Splice, Rejection> {
        let plan = self.0.propose(space, x, y, rng)?;
        if x.wavelength == y.wavelength {
            y.wavelength = space.scene.sample_wavelength(rng);
        }
        Ok(plan)
    }

    fn ln_density(&self, space: &PathSpace, from: &Path, to: &Path, plan: Splice) -> f64 {
        let mut to = to.clone();
        to.wavelength = from.wavelength;
        self.0.ln_density(space, from, &to, plan)
    }
}

#[test]
fn a_new_wavelength_with_dispersive_vertices_kept_is_caught() {
    let law = drift(&space(), &AnyTime(Bidirectional {}), 100_000);
    let t = law.t();
    println!("t = {:.1} of the mismatch, {:.1} of all", t[MISMATCH], law.verdict(ALPHA).max_t);
    assert!(t[MISMATCH] > CAUGHT, "{t:?}");
}

#[test]
fn chains_in_primary_sample_space_obey_the_laws_with_a_wavelength() {
    let space = space();
    let roulette = Roulette { start: 4, survival: 0.7 };
    let n = nightly(8_000, 200_000);
    primary_laws::check("dispersive", &space, &PathTracer::new(LENGTHS, roulette), n);
    primary_laws::check("dispersive", &space, &BidirectionalPathTracer::new(LENGTHS, roulette), n);
    primary_laws::check("dispersive", &space, &Multiplexed::new(&space.scene, LENGTHS, 5), 10 * n);
}

/// Pixels on a side; even, for the quarters.
const SIDE: u32 = 16;

/// The means of the quarters of a picture.
fn quarters(picture: &Picture) -> [Rgb; 4] {
    let mut sums = [Rgb::ZERO; 4];
    for (i, pixel) in (0..).zip(&picture.pixels) {
        let (column, row) = (i % SIDE, i / SIDE);
        sums[(row / (SIDE / 2) * 2 + column / (SIDE / 2)) as usize] += *pixel;
    }
    sums.map(|sum| sum / f64::from(SIDE * SIDE / 4))
}

fn of_room(dispersion: f64, method: Method, samples: f64, replicas: usize) -> [Estimate; 4] {
    let scene = view_of(dispersive_room(dispersion), (SIDE, SIDE));
    estimate(&scene, &settings(method, &(1..=7), SIDE, samples), replicas, quarters).expect("valid settings")
}

/// The greatest distance between the quarters of two pictures, in standard errors.
fn apart(a: &[Estimate; 4], b: &[Estimate; 4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.z_against(b)).fold(0.0, f64::max)
}

/// 1e-4 two-sided over 12 numbers and 4 comparisons for Student's t with some 16 degrees of freedom.
const AGREES: f64 = 6.5;

#[test]
fn all_methods_make_the_same_picture_of_a_scene_that_disperses() {
    let reference = of_room(DISPERSION, Method::Bidirectional, 160.0, 12);
    for (method, samples) in
        [(Method::Path, 160.0), (Method::Mlt, 1600.0), (Method::Pssmlt, 240.0), (Method::Mmlt, 600.0)]
    {
        let found = of_room(DISPERSION, method, samples, 12);
        let z = apart(&reference, &found);
        println!("{method:?}: {z:.1}; {:.4} {:.4}", reference[2].mean, found[2].mean);
        println!("  relative error {:.4} {:.4}", reference[2].relative_error(), found[2].relative_error());
        assert!(z < AGREES, "{method:?}: {z}\n{reference:?}\n{found:?}");
    }
    // What is 4 % off in one channel would have been seen.
    let tinted = reference.map(|e| Estimate { mean: e.mean * Rgb::new(1.0, 1.0, 1.04), ..e });
    let z = apart(&reference, &tinted);
    println!("a tint of 4 %: {z:.1}");
    assert!(z > AGREES, "{z}");
}

#[test]
fn without_dispersion_the_picture_is_that_of_rgb() {
    // So little that no index changes, but every path has a wavelength.
    let (rgb, spectral) = (view_of(dispersive_room(0.0), (SIDE, SIDE)), view_of(dispersive_room(1e-12), (SIDE, SIDE)));
    assert!(!rgb.disperses() && spectral.disperses());
    assert!(rgb.sample_wavelength(&mut stream(1, Purpose::Chain, 0)).is_none());
    for (method, samples) in [(Method::Bidirectional, 160.0), (Method::Mlt, 1600.0)] {
        let a = of_room(0.0, method, samples, 12);
        let b = of_room(1e-12, method, samples, 12);
        let z = apart(&a, &b);
        println!("{method:?}: {z:.1}; {:.4} {:.4}", a[2].mean, b[2].mean);
        assert!(z < AGREES, "{method:?}: {z}");
    }
}

#[test]
fn without_dispersive_glass_nothing_has_a_wavelength() {
    let scene = view_of(dispersive_room(0.0), (SIDE, SIDE));
    let settings = Settings { seed: 3, ..settings(Method::Mlt, &(1..=7), SIDE, 20.0) };
    let picture = |scene: &Scene| render(scene, &settings, &Unobserved).expect("valid settings").picture.pixels;
    // Thin walls and surfaces that nothing passes do not disperse, so the picture has the same bits.
    let mut thin = dispersive_room(0.0);
    thin.materials[0].dispersion = 1.0;
    thin.materials.push(Material { dispersion: 1.0, ..glass(1.5) });
    assert_eq!(picture(&scene), picture(&view_of(thin, (SIDE, SIDE))));
}

/// A prism along y with its apex on top, of apex angle `apex`.
fn prism(apex: f64) -> Mesh {
    let (half, height) = ((0.5 * apex).tan(), 1.0);
    let profile = [DVec3::new(-half, 0.0, 0.0), DVec3::new(half, 0.0, 0.0), DVec3::new(0.0, 0.0, height)];
    let positions = [-1.0, 1.0].into_iter().flat_map(|y| profile.map(|p| p + DVec3::Y * y)).collect();
    let triangles = vec![[0, 1, 2], [3, 5, 4], [0, 3, 1], [1, 3, 4], [1, 4, 2], [2, 4, 5], [2, 5, 0], [0, 5, 3]];
    Mesh { positions, triangles, ..Mesh::default() }
}

/// The direction in which light of a wavelength leaves the prism that the eye looks at along `w`.
fn through(scene: &Scene, w: DVec3, wavelength: Wavelength) -> DVec3 {
    let mut rng = stream(1, Purpose::Chain, 0);
    let enters = scene.trace(&scene.camera_vertex(), w, wavelength, &mut rng).expect("the prism");
    let within = enters.interaction.dirac_direction(-w, Component::DiracTransmission).expect("refraction");
    let leaves = scene.trace(&enters, within, wavelength, &mut rng).expect("its other side");
    leaves.interaction.dirac_direction(-within, Component::DiracTransmission).expect("refraction")
}

#[test]
fn a_prism_spreads_light_as_snell_says() {
    let apex = 60f64.to_radians();
    let (ior, dispersion) = (1.62, 0.55);
    let material = Material { dispersion, ..glass(ior) };
    let at = DVec3::new(-0.5 * (0.5 * apex).tan(), 0.0, 0.5);
    let normal = DVec3::new(-(0.5 * apex).cos(), 0.0, (0.5 * apex).sin());
    for degrees in [45.0f64, 54.0, 63.0] {
        let incidence = degrees.to_radians();
        // Turned about y from the normal, away from the apex.
        let tangent = DVec3::new(-normal.z, 0.0, normal.x);
        let from_eye = normal * incidence.cos() + tangent * incidence.sin();
        let from_eye =
            if from_eye.z < normal.z { from_eye } else { normal * incidence.cos() - tangent * incidence.sin() };
        let eye = Eye { from: at + from_eye * 2.0, at, up: DVec3::Y, fov: 0.2 };
        let lamp = quad(DVec3::new(3.0, -1.0, -3.0), DVec3::Y * 2.0, DVec3::Z * 6.0);
        let things = vec![(prism(apex), material.clone()), (lamp, diffuse(0.0, 1.0))];
        let scene = scene_of(things, Vec::new(), &eye, SIDE);
        let deviation = |wavelength: Wavelength| through(&scene, -from_eye, wavelength).angle_between(-from_eye);
        // D = i + e - A with sin i = n sin r, sin e = n sin (A - r) (Born and Wolf, 4.7.2).
        let snell = |n: f64| incidence + (n * (apex - (incidence.sin() / n).asin()).sin()).asin() - apex;
        let spread = (ior - 1.0) * dispersion / 20.0;
        for share in [0.0, 0.3, 0.7, 0.99] {
            let wavelength = Wavelength::at(share);
            // Cauchy's formula through the lines F, d and C.
            let inverse_square = |nanometres: f64| 1.0 / (nanometres * nanometres);
            let b = spread / (inverse_square(486.1) - inverse_square(656.3));
            let n = ior + b * (inverse_square(wavelength.nanometres()) - inverse_square(587.6));
            let found = deviation(wavelength);
            assert!((found - snell(n)).abs() < 1e-9, "{degrees}, {wavelength:?}: {found} {}", snell(n));
            // With the index of another colour it would be elsewhere.
            assert!((found - snell(ior)).abs() > 1e-4);
        }
        // Blue is bent most.
        assert!(
            deviation(Wavelength::F) > deviation(Wavelength::D) && deviation(Wavelength::D) > deviation(Wavelength::C)
        );
    }
}

/// Chains of the mixture that renders use reach paths of all wavelengths from one.
#[test]
fn chains_reach_every_wavelength() {
    let space = space();
    let mixture: Mixture<AnyMutation> = mixture(members());
    let mut rng = stream(47, Purpose::Chain, 0);
    let mut draw = draw(&space);
    let start = loop {
        if let Some((x, _)) = draw(&mut rng)
            && x.response().is_some()
        {
            break x;
        }
    };
    let mut chain = ergodic_metropolis::Chain::new(start, &LuminanceTarget::default());
    let mut seen = [0u32; 10];
    for _ in 0..nightly(200_000, 2_000_000) {
        chain.step(&LuminanceTarget::default(), &mixture, &space, &mut rng);
        let x = chain.current().0;
        if x.response().is_some() {
            let share =
                (x.wavelength.nanometres() - Wavelength::SHORTEST) / (Wavelength::LONGEST - Wavelength::SHORTEST);
            seen[((share * 10.0) as usize).min(9)] += 1;
        }
    }
    println!("{seen:?}");
    // Violet and the deepest red are hardly visible; the rest is.
    assert!(seen[1..9].iter().all(|n| *n > 100), "{seen:?}");
}
