//! Surfaces that cover a share only (alphaMode MASK and BLEND): closed forms, the laws of mutations and of strategies, methods that
//! agree.

use std::f64::consts::PI;

use ergodic_metropolis::RandomSource;
use ergodic_mutations::Splice;
use ergodic_pathspace::{Lengths, Path, PathSpace, Roulette, Scene, Vertex};
use ergodic_render::{Direct, Method, Purpose, Settings, Unobserved, render, stream};
use ergodic_scattering::{
    AlphaMode, Interpolation, Material, PunctualLight, Rgb, Texels, Texture, TextureUse, Wavelength, Wrap,
};
use ergodic_tests::{
    Estimate, Eye, Thing, cuboid, description_of, diffuse, estimate, mirror, nightly, quad, scene_of, settings, view_of,
};
use glam::{DAffine2, DVec2, DVec3};

use crate::mutation_laws::{LENGTHS, check_balance, check_kernels, drift_of, members};
use crate::rendering;
use crate::strategies::{AGREE, check_connections, disagreement};

fn blend(alpha: f64, material: Material) -> Material {
    Material { alpha_mode: AlphaMode::Blend, alpha, ..material }
}

/// A sheet across the z axis, 4 wide.
fn sheet(z: f64, material: Material) -> Thing {
    (quad(DVec3::new(-2.0, -2.0, z), DVec3::X * 4.0, DVec3::Y * 4.0), material)
}

fn along_z() -> Eye {
    Eye { from: DVec3::Z * 3.0, at: DVec3::ZERO, up: DVec3::Y, fov: 0.5 }
}

const SIDE: u32 = 4;

fn mean(scene: &Scene, method: Method, edges: usize) -> Estimate {
    let settings = settings(method, &(edges..=edges), SIDE, 2000.0);
    let [mean] = estimate(scene, &settings, 16, |picture| [picture.mean()]).unwrap_or_else(|e| panic!("{e}"));
    mean
}

fn check(scene: &Scene, edges: usize, truth: f64) {
    for (method, name) in Method::ALL {
        let found = mean(scene, method, edges);
        let z = found.z(Rgb::splat(truth));
        println!("{name}: {:.5} +- {:.5}, want {truth:.5}, z = {z:.1}", found.mean.x, found.error.x);
        assert!(z < 5.0 && found.relative_error() < 0.02, "{name}: {found:?}, want {truth}");
        assert!(found.z(Rgb::splat(1.1 * truth)) > 5.0, "{name}: 10 % more passes");
    }
}

#[test]
fn stacked_sheets_let_the_product_of_what_they_do_not_cover_pass() {
    // Shares of 1/5 are exact in steps of 1/65535. Sheets count from both sides.
    let alphas = [0.2, 0.6, 0.4];
    let passes: f64 = alphas.iter().map(|alpha| 1.0 - alpha).product();
    let mut things = vec![sheet(0.0, diffuse(0.0, 2.0))];
    for (i, alpha) in alphas.iter().enumerate() {
        let (mut mesh, material) = sheet(0.5 + 0.5 * i as f64, blend(*alpha, diffuse(0.0, 0.0)));
        if i == 1 {
            mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        things.push((mesh, material));
    }
    check(&scene_of(things, Vec::new(), &along_z(), SIDE), 1, 2.0 * passes);
}

#[test]
fn a_sheet_emits_the_share_that_it_covers() {
    // Each sheet emits its share, of which those before it let a part pass.
    let things = (0..3).map(|i| sheet(0.5 * f64::from(i), blend(0.4, diffuse(0.0, 2.0)))).collect();
    let truth = 2.0 * 0.4 * (1.0 + 0.6 + 0.36);
    check(&scene_of(things, Vec::new(), &along_z(), SIDE), 1, truth);
}

#[test]
fn lights_without_extent_shine_through_sheets() {
    // A wall seen through one sheet, and lit through it and another one.
    let things = || {
        let sheets = [1.0, 1.5].map(|z| sheet(z, blend(0.4, diffuse(0.0, 0.0))));
        std::iter::once(sheet(0.0, diffuse(0.5, 0.0))).chain(sheets).collect::<Vec<_>>()
    };
    let direction = DVec3::new(0.6, 0.0, -0.8);
    let light = PunctualLight::Directional { direction, irradiance: Rgb::splat(2.0) };
    let eye = Eye { from: DVec3::Z * 1.2, ..along_z() };
    let truth = 0.5 / PI * 2.0 * 0.8 * 0.6 * 0.36;
    check(&scene_of(things(), vec![light], &eye, SIDE), 2, truth);
    // A wall that covers a share scatters that share.
    let mut thin = things();
    thin[0].1 = blend(0.6, thin[0].1.clone());
    check(&scene_of(thin, vec![light], &eye, SIDE), 2, 0.6 * truth);
    let point = PunctualLight::Point { position: DVec3::new(0.0, 0.0, 200.0), intensity: Rgb::splat(8e4) };
    check(&scene_of(things(), vec![point], &eye, SIDE), 2, 0.5 / PI * 2.0 * 0.6 * 0.36);
}

/// Texels whose alpha is 0 and 1 in turns.
fn checker(interpolation: Interpolation) -> Texture {
    let texel = |i: usize| [255, 255, 255, if (i / 4 + i % 4).is_multiple_of(2) { 255 } else { 0 }];
    let texels = Texels::Linear8((0..16).map(texel).collect());
    Texture { width: 4, height: 4, texels, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat, interpolation }
}

fn textured(material: Material) -> Material {
    let texture = TextureUse { texture: 0, texcoord: 0, transform: DAffine2::IDENTITY };
    Material { base_color_texture: Some(texture), ..material }
}

/// The same thing with texture coordinates over the whole of its parallelogram.
fn mapped((mut mesh, material): Thing) -> Thing {
    mesh.texcoords[0] = Some(vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y]);
    (mesh, material)
}

#[test]
fn masks_and_textures_decide_point_by_point() {
    let with = |material: Material, interpolation| {
        let (mut mesh, material) = mapped(sheet(1.0, textured(material)));
        // The texture spans the square that is seen.
        let half = 2.0 * (0.25f64).tan();
        mesh.positions.iter_mut().for_each(|p| *p = DVec3::new(p.x * half / 2.0, p.y * half / 2.0, p.z));
        let mut description =
            description_of(vec![sheet(0.0, diffuse(0.0, 2.0)), (mesh, material)], Vec::new(), &along_z());
        description.textures = vec![checker(interpolation)];
        view_of(description, (SIDE, SIDE))
    };
    // Half of the squares are there.
    let mask = Material { alpha_mode: AlphaMode::Mask { cutoff: 0.5 }, ..diffuse(0.0, 0.0) };
    check(&with(mask.clone(), Interpolation::Nearest), 1, 1.0);
    // The factor of the colour takes alpha below the cutoff: nothing is there.
    check(&with(Material { alpha: 0.4, ..mask.clone() }, Interpolation::Nearest), 1, 2.0);
    // The mean alpha is a half, however it is interpolated.
    check(&with(blend(0.8, diffuse(0.0, 0.0)), Interpolation::Nearest), 1, 2.0 * (1.0 - 0.4));
    check(&with(blend(0.8, diffuse(0.0, 0.0)), Interpolation::Bilinear), 1, 2.0 * (1.0 - 0.4));
}

/// A room with curtains: one that scatters, a half mirror, a mask, one of bilinear alpha that emits a little.
fn room(lengths: Lengths) -> PathSpace {
    let across = |x: f64, material: Material| {
        mapped((quad(DVec3::new(x, -0.8, -0.9), DVec3::new(0.3, 0.0, 1.4), DVec3::Y * 1.4), material))
    };
    let mask = textured(Material { alpha_mode: AlphaMode::Mask { cutoff: 0.4 }, ..diffuse(0.6, 0.0) });
    let things = vec![
        (cuboid(DVec3::ONE, true), diffuse(0.7, 0.0)),
        (quad(DVec3::new(-0.4, 0.98, -0.4), DVec3::X * 0.8, DVec3::Z * 0.8), diffuse(0.0, 5.0)),
        across(-0.6, blend(0.4, diffuse(0.8, 0.0))),
        across(-0.2, blend(0.6, mirror())),
        across(0.2, mask),
        across(0.5, textured(blend(0.8, diffuse(0.5, 0.3)))),
    ];
    let eye = Eye { from: DVec3::new(-0.3, 0.1, 0.95), at: DVec3::new(0.1, -0.2, -0.5), up: DVec3::Y, fov: 1.2 };
    let mut description = description_of(things, Vec::new(), &eye);
    description.textures = vec![checker(Interpolation::Bilinear)];
    PathSpace { scene: view_of(description, (64, 64)), lengths }
}

#[test]
fn the_way_back_has_support_and_balance_is_detailed() {
    check_balance("curtains", &room(LENGTHS));
}

#[test]
fn one_step_leaves_the_target_invariant() {
    check_kernels("curtains", &room(LENGTHS), nightly(150_000, 4_000_000));
}

#[test]
fn forgotten_probabilities_of_passing_and_of_stopping_are_caught() {
    let space = room(Lengths { min_edges: 1, max_edges: 4 });
    for mutation in members().into_iter().take(3) {
        // The share of light that passes the new edges is left out of the density.
        let passing = |_: &Path, to: &Path, (_, plan): (usize, Splice)| {
            let edges = plan.prefix.saturating_sub(1)..to.vertices.len() - plan.suffix.max(1);
            let share = |i: usize| space.scene.visibility(&to.vertices[i], &to.vertices[i + 1]);
            -edges.map(share).product::<f64>().ln()
        };
        let z = drift_of(&space, vec![mutation], 300_000, &passing);
        assert!(z > 8.0, "{}: z = {z}", mutation.name());
        // The coverage at which rays stop.
        let stopping = |_: &Path, to: &Path, (_, plan): (usize, Splice)| {
            let new = &to.vertices[plan.prefix..to.vertices.len() - plan.suffix];
            -new.iter().map(|vertex| vertex.coverage.share()).product::<f64>().ln()
        };
        let z = drift_of(&space, vec![mutation], 300_000, &stopping);
        assert!(z > 8.0, "{}: z = {z}", mutation.name());
    }
}

#[test]
fn every_connection_agrees_with_the_path_seen_from_outside() {
    let space = room(LENGTHS);
    for roulette in [Roulette::OFF, Roulette { start: 3, survival: 0.6 }] {
        let (checked, estimate, weight) = check_connections(&space, roulette, 11, nightly(6000, 100_000));
        println!("{checked} connections, estimate {estimate:.1e}, weight {weight:.1e}");
        assert!(checked > 1000 && estimate < 1e-6 && weight < 1e-6, "{estimate} {weight}");
    }
}

#[test]
fn single_strategies_agree_per_length() {
    let space = room(Lengths { min_edges: 1, max_edges: 3 });
    // Not all strategies make what goes by the mirror.
    let rough = |path: &Path| path.vertices[1..path.length()].iter().all(Vertex::is_connectable);
    let z = disagreement(&space, nightly(400_000, 4_000_000), |path, _| f64::from(u8::from(rough(path))));
    assert!(z < AGREE, "{z}");
    // Where the coverage of the vertices that the light walk left is not in f, strategies differ.
    let z = disagreement(&space, 400_000, |path, s| {
        let covered = path.vertices[1..s.max(1)].iter().map(|vertex| vertex.coverage.share()).product::<f64>();
        f64::from(u8::from(rough(path))) / covered
    });
    assert!(z > AGREE, "the planted fault passes, {z}");
}

#[test]
fn methods_agree() {
    let scene = room(LENGTHS).scene;
    let of = |method, samples| {
        let mut settings = Settings { min_edges: 1, max_edges: 6, ..rendering::settings(method, (64, 64), samples) };
        settings.mlt.direct = Direct::InChain;
        settings.mlt.seeding.max_samples = 100_000;
        rendering::replicate(&scene, &settings, rendering::REPLICAS)
    };
    let bidirectional = of(Method::Bidirectional, nightly(6.0, 12.0));
    for (method, samples) in [(Method::Path, nightly(24.0, 48.0)), (Method::Mlt, nightly(40.0, 150.0))] {
        let found = of(method, samples);
        let t = rendering::disagreement(&bidirectional, &found);
        println!("{method:?} against bidirectional, max |t| {t:.1}");
        assert!(t < rendering::LIMIT, "{method:?}: {t}");
    }
}

#[test]
fn chains_of_primary_samples_agree_among_curtains() {
    rendering::check_primary("curtains", &room(LENGTHS).scene, (64, 64));
}

#[test]
fn visibility_is_the_same_from_both_ends_to_the_bit() {
    let space = room(LENGTHS);
    let scene = &space.scene;
    let mut rng = stream(7, Purpose::Chain, 31);
    let mut shares = 0;
    let mut from = scene.camera_vertex();
    for _ in 0..20_000 {
        let w = ergodic_scattering::warp::uniform_sphere([rng.uniform(), rng.uniform()]);
        let Some(to) = scene.trace(&from, w, Wavelength::NONE, &mut rng) else { continue };
        let eye = scene.camera_vertex();
        for (a, b) in [(&from, &to), (&eye, &to)] {
            let there = scene.visibility(a, b);
            assert_eq!(there.to_bits(), scene.visibility(b, a).to_bits());
            shares += u32::from(there > 0.0 && there < 1.0);
        }
        from = to;
    }
    assert!(shares > 1000, "only {shares} shares");
}

/// Alpha that is 1 everywhere is no partial coverage: nothing is asked, no number drawn.
#[test]
fn whole_surfaces_cost_nothing_whatever_their_mode() {
    let picture = |mode: AlphaMode, method| {
        let things = vec![
            (cuboid(DVec3::ONE, true), Material { alpha_mode: mode, ..diffuse(0.7, 0.5) }),
            (cuboid(DVec3::splat(0.3), false), Material { alpha_mode: mode, ..mirror() }),
        ];
        let eye = Eye { from: DVec3::new(0.5, 0.5, 0.9), at: DVec3::ZERO, up: DVec3::Y, fov: 1.2 };
        let scene = scene_of(things, Vec::new(), &eye, SIDE);
        assert!(!scene.has_partial_coverage());
        let settings = settings(method, &(1..=5), SIDE, 50.0);
        render(&scene, &settings, &Unobserved).unwrap_or_else(|e| panic!("{e}")).picture
    };
    for (method, _) in Method::ALL {
        let opaque = picture(AlphaMode::Opaque, method);
        assert!(
            opaque == picture(AlphaMode::Blend, method) && opaque == picture(AlphaMode::Mask { cutoff: 1.0 }, method)
        );
    }
}

/// A ray that passes surfaces and the segment between its ends agree on what lies between: light that comes through where nothing is
/// seen would be in one method's picture and not in the other's.
#[test]
fn what_a_ray_comes_through_is_visible() {
    let space = room(LENGTHS);
    let scene = &space.scene;
    let mut rng = stream(7, Purpose::Chain, 32);
    let (mut from, mut blocked, mut found) = (scene.camera_vertex(), 0, 0);
    for _ in 0..100_000 {
        let w = ergodic_scattering::warp::uniform_sphere([rng.uniform(), rng.uniform()]);
        let Some(to) = scene.trace(&from, w, Wavelength::NONE, &mut rng) else { continue };
        found += 1;
        blocked += u32::from(scene.visibility(&from, &to) == 0.0);
        from = to;
    }
    assert!(found > 40_000 && blocked <= 2, "{blocked} of {found}");
}
