//! Media that scatter: closed forms, strategies, the laws of mutations and whole renders, with the faults that they see.
//!
//! - A medium that absorbs nothing is invisible in an environment of one radiance, whatever its phase function, and so is a solid
//!   that is filled with it.
//! - Light of one turn: along a line of sight, L = integral of exp(-s t) s_s p(theta) I / d² exp(-s d) dt from a point light of
//!   intensity I at distance d, by the midpoint rule.
//! - A medium that only absorbs dims a wall of radiance L at distance d to L exp(-s d).

use std::f64::consts::PI;

use ergodic_laws::faults::Scaled;
use ergodic_metropolis::Mutation;
use ergodic_mutations::{AnyMutation, Lens, Splice, Volume};
use ergodic_pathspace::{Lengths, LuminanceTarget, Path, PathSpace, Roulette, Scene};
use ergodic_render::{Purpose, stream};
use ergodic_scattering::{Component, Environment, Material, Medium, PunctualLight, Rgb};
use ergodic_tests::{
    Eye, PathSource, Thing, cuboid, description_of, diffuse, glass, mirror, nightly, quad, sphere, view_of,
};
use glam::DVec3;

use crate::closed_forms::{SIDE, USUAL, check};
use crate::mutation_laws::{ALPHA, CAUGHT, check_kernels, drifts, mixture};
use crate::rendering::{check_methods, check_primary};
use crate::strategies::{AGREE, check_connections, disagreement};

/// Things in a medium.
fn within(
    medium: Medium,
    things: Vec<Thing>,
    lights: Vec<PunctualLight>,
    environment: Option<Environment>,
    eye: &Eye,
    side: u32,
) -> Scene {
    let mut description = description_of(things, lights, eye);
    description.environment = environment;
    description.medium = medium;
    view_of(description, (side, side))
}

/// A medium whose colours differ in everything.
fn fog(density: f64) -> Medium {
    Medium {
        scattering: Rgb::new(0.3, 0.5, 0.9) * density,
        absorption: Rgb::new(0.2, 0.1, 0.0) * density,
        anisotropy: 0.4,
    }
}

fn eye() -> Eye {
    Eye { from: DVec3::new(0.5, 1.2, 3.6), at: DVec3::new(0.0, 0.9, 0.0), up: DVec3::Y, fov: 0.75 }
}

/// A room without front, 2 on a side, with a lamp under its ceiling.
fn room(lamp: f64) -> Vec<Thing> {
    let (x, y, z) = (DVec3::X * 2.0, DVec3::Y * 2.0, DVec3::Z * 2.0);
    let corner = DVec3::new(-1.0, 0.0, -1.0);
    vec![
        (quad(corner, z, x), diffuse(0.7, 0.0)),
        (quad(corner, x, y), Material { base_color: Rgb::new(0.3, 0.6, 0.8), ..diffuse(0.0, 0.0) }),
        (quad(corner, y, z), Material { base_color: Rgb::new(0.8, 0.3, 0.2), ..diffuse(0.0, 0.0) }),
        (quad(corner + x, z, y), diffuse(0.5, 0.0)),
        (quad(corner + y, x, z), diffuse(0.7, 0.0)),
        (quad(DVec3::new(-0.35, 1.98, -0.35), DVec3::X * 0.7, DVec3::Z * 0.7), diffuse(0.0, lamp)),
    ]
}

/// Glass filled with a medium that scatters.
fn milk(ior: f64) -> Material {
    let medium = Medium { scattering: Rgb::new(2.0, 3.0, 4.0), absorption: Rgb::new(0.5, 0.2, 0.1), anisotropy: 0.2 };
    Material {
        scattering: medium.scattering,
        absorption: medium.absorption,
        anisotropy: medium.anisotropy,
        ..glass(ior)
    }
}

/// The room in fog, with a mirror, clear glass and filled glass.
fn furnished(side: u32, lengths: Lengths) -> PathSpace {
    let mut things = room(6.0);
    things.push((sphere(DVec3::new(-0.5, 0.41, -0.3), 0.4, 24, false), mirror()));
    things.push((sphere(DVec3::new(0.5, 0.36, 0.2), 0.35, 24, false), glass(1.5)));
    things.push((sphere(DVec3::new(-0.1, 1.2, -0.2), 0.3, 24, false), milk(1.3)));
    PathSpace { scene: within(fog(0.5), things, Vec::new(), None, &eye(), side), lengths }
}

/// A floor, a box and a mirror in fog under a sky with a sun, and a directional light.
fn misty_yard(side: u32, lengths: Lengths) -> PathSpace {
    let texel = |i: u32| if i == 37 { [30.0, 25.0, 20.0] } else { [0.3, 0.4, 0.6] };
    let sky =
        Environment::map(16, 8, (0..128).flat_map(texel).collect(), 1.0, 40.0).expect("as many texels as it says");
    let things = vec![
        (quad(DVec3::new(-1.5, 0.0, -1.5), DVec3::Z * 3.0, DVec3::X * 3.0), diffuse(0.6, 0.0)),
        (cuboid(DVec3::splat(0.3), false), diffuse(0.8, 0.0)),
        (sphere(DVec3::new(-0.7, 0.51, 0.0), 0.5, 24, false), mirror()),
    ];
    let sun = PunctualLight::Directional { direction: DVec3::new(0.3, -0.8, 0.2).normalize(), irradiance: Rgb::ONE };
    PathSpace { scene: within(fog(0.3), things, vec![sun], Some(sky), &eye(), side), lengths }
}

const LENGTHS: Lengths = Lengths { min_edges: 1, max_edges: 7 };

fn spaces(side: u32) -> [(&'static str, PathSpace); 2] {
    [("furnished", furnished(side, LENGTHS)), ("misty yard", misty_yard(side, LENGTHS))]
}

#[test]
fn what_absorbs_nothing_is_invisible_in_an_even_environment() {
    let radiance = Rgb::new(0.8, 1.0, 1.2);
    let samples = [64.0, 64.0, 1024.0];
    let even = || Some(Environment::constant(radiance));
    let eye = Eye { from: DVec3::new(1.0, 1.0, 3.0), at: DVec3::ZERO, up: DVec3::Y, fov: 0.6 };
    let ball = |material| vec![(sphere(DVec3::ZERO, 1.0, 24, false), material)];
    for anisotropy in [0.0, 0.6] {
        let white = Medium { scattering: Rgb::new(0.07, 0.1, 0.15), absorption: Rgb::ZERO, anisotropy };
        let scene = within(white, ball(diffuse(1.0, 0.0)), Vec::new(), even(), &eye, SIDE);
        check("white ball in white fog", &scene, 1..=14, samples, |_| radiance);
    }
    // A solid that does not refract, in nothing.
    let scattering = Rgb::splat(0.6);
    let cloud = Material { scattering, anisotropy: 0.3, ..glass(1.0) };
    let scene = within(Medium::VACUUM, ball(cloud), Vec::new(), even(), &eye, SIDE);
    // Half of its picture is a cloud that chains stay in for long.
    check("white cloud", &scene, 1..=20, [64.0, 64.0, 1536.0], |_| radiance);
}

#[test]
fn light_of_one_turn_is_an_integral_along_the_line_of_sight() {
    let medium = Medium { scattering: Rgb::new(0.4, 0.2, 0.6), absorption: Rgb::new(0.1, 0.3, 0.0), anisotropy: 0.5 };
    let wall = quad(DVec3::new(-4.0, -4.0, -2.0), DVec3::X * 8.0, DVec3::Y * 8.0);
    let eye = Eye { from: DVec3::new(0.0, 0.0, 2.0), at: DVec3::new(0.0, 0.0, -2.0), up: DVec3::Y, fov: 0.5 };
    let (lamp, intensity) = (DVec3::new(0.3, 2.2, -0.4), Rgb::new(3.0, 2.0, 1.0));
    let lights = vec![PunctualLight::Point { position: lamp, intensity }];
    let scene = within(medium, vec![(wall, diffuse(0.0, 0.0))], lights, None, &eye, SIDE);
    let radiance = |p| {
        let wall = eye.sees(p);
        let (length, w) = ((wall - eye.from).length(), (wall - eye.from).normalize());
        let steps = 400;
        let step = length / f64::from(steps);
        let at = |i: i32| {
            let t = (f64::from(i) + 0.5) * step;
            let point = eye.from + w * t;
            let d = point.distance(lamp);
            let cos = (point - lamp).normalize().dot(-w);
            let g = medium.anisotropy;
            let phase = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos).powf(1.5));
            medium.transmittance(t + d) * medium.scattering * intensity * (phase / (d * d) * step)
        };
        (0..steps).map(at).sum()
    };
    check("one turn", &scene, 2..=2, [256.0, 256.0, 1024.0], radiance);
}

#[test]
fn what_only_absorbs_dims() {
    let absorption = Rgb::new(0.1, 0.2, 0.4);
    let medium = Medium { absorption, ..Medium::VACUUM };
    let wall = quad(DVec3::new(-4.0, -4.0, -2.0), DVec3::X * 8.0, DVec3::Y * 8.0);
    let eye = Eye { from: DVec3::new(0.0, 0.0, 2.0), at: DVec3::new(0.0, 0.0, -2.0), up: DVec3::Y, fov: 0.5 };
    let scene = within(medium, vec![(wall, diffuse(0.0, 2.0))], Vec::new(), None, &eye, SIDE);
    assert!(!scene.scatters());
    check("absorbing", &scene, 1..=1, USUAL, |p| 2.0 * medium.transmittance(eye.sees(p).distance(eye.from)));
}

#[test]
fn every_connection_agrees_with_the_path_seen_from_outside() {
    for (name, space) in spaces(32) {
        for roulette in [Roulette::OFF, Roulette { start: 3, survival: 0.6 }] {
            let (checked, estimate, weight) = check_connections(&space, roulette, 13, nightly(6000, 100_000));
            println!("{name}: {checked} connections, estimate {estimate:.1e}, weight {weight:.1e}");
            assert!(checked > 5000, "{name}: only {checked} connections");
            assert!(estimate < 1e-6, "{name}: estimate and f / p differ by {estimate}");
            assert!(weight < 1e-6, "{name}: weights do not sum to 1, by {weight}");
        }
    }
}

/// The room with nothing in it but fog, so that every strategy makes every path.
fn empty_room(lengths: Lengths) -> PathSpace {
    PathSpace { scene: within(fog(0.8), room(6.0), Vec::new(), None, &eye(), 32), lengths }
}

#[test]
fn single_strategies_agree_per_length() {
    let space = empty_room(Lengths { min_edges: 2, max_edges: 4 });
    let z = disagreement(&space, nightly(400_000, 4_000_000), |_, _| 1.0);
    assert!(z < AGREE, "{z}");
}

#[test]
fn single_strategies_agree_per_length_under_a_sky() {
    let mut space = misty_yard(32, Lengths { min_edges: 2, max_edges: 3 });
    // Mirrors take away strategies.
    let things = vec![(quad(DVec3::new(-1.5, 0.0, -1.5), DVec3::Z * 3.0, DVec3::X * 3.0), diffuse(0.6, 0.0))];
    let sky = Environment::map(2, 1, vec![0.3, 0.4, 0.6, 2.0, 1.0, 0.5], 1.0, 40.0).expect("two texels");
    space.scene = within(fog(0.3), things, Vec::new(), Some(sky), &eye(), 32);
    let z = disagreement(&space, nightly(400_000, 4_000_000), |_, _| 1.0);
    assert!(z < AGREE, "{z}");
}

/// Faults of single strategies: a vertex in the medium that was made from the light with a cosine, or with a density that knows
/// nothing of flight.
#[test]
fn a_cosine_in_the_medium_or_a_density_without_flight_is_caught() {
    let space = empty_room(Lengths { min_edges: 2, max_edges: 2 });
    let scene = space.scene.clone();
    let in_medium = |path: &Path| path.vertices[1].is_in_medium();
    let z =
        disagreement(
            &space,
            200_000,
            |path, s| {
                if s == 2 && in_medium(path) { path.edges[0].direction.y.abs() } else { 1.0 }
            },
        );
    assert!(z > 1.5 * AGREE, "{z}");
    let z = disagreement(&space, 200_000, |path, s| {
        let [light, next, _] = &path.vertices[..] else { return 1.0 };
        if s == 2 { path.edges[0].flight(&scene, light, next, next) } else { 1.0 }
    });
    assert!(z > 1.5 * AGREE, "{z}");
}

/// What a chain asks of a proposal, on paths with many points in media.
#[test]
fn the_way_back_has_support_and_balance_is_detailed() {
    let ln_target = |x: &Path| {
        let target = LuminanceTarget::default();
        <LuminanceTarget as ergodic_metropolis::Target>::ln_density(&ergodic_metropolis::Target::evaluate(&target, x))
    };
    for (name, space) in spaces(64) {
        for mutation in AnyMutation::all() {
            let (mut source, mut rng) = (PathSource::new(&space), stream(17, Purpose::Chain, 1));
            let (mut x, mut y) = (Path::default(), Path::default());
            let (mut tried, mut one_way, mut in_medium) = (0u32, 0u32, 0u32);
            for _ in 0..10_000 {
                if source.draw(&mut x, &mut rng).is_none() || mutation.suitability(&space, &x) == 0.0 {
                    continue;
                }
                let Ok(plan) = mutation.propose(&space, &x, &mut y, &mut rng) else { continue };
                let ln_fy = ln_target(&y);
                if ln_fy == f64::NEG_INFINITY {
                    continue;
                }
                tried += 1;
                let new = plan.prefix..y.vertices.len() - plan.suffix;
                in_medium += u32::from(y.vertices[new].iter().any(|vertex| vertex.is_in_medium()));
                let forward = mutation.ln_density(&space, &x, &y, plan);
                let backward = mutation.ln_density(&space, &y, &x, plan);
                assert!(forward.is_finite(), "{name} {}: forward density {forward}", mutation.name());
                assert!(!backward.is_nan() && backward < f64::INFINITY, "{name} {}: {backward}", mutation.name());
                one_way += u32::from(backward == f64::NEG_INFINITY);
                let mut again = y.clone();
                again.derive(&space.scene);
                assert_eq!(again.edges, y.edges, "{name} {}", mutation.name());
                assert_eq!(again.scattering, y.scattering, "{name} {}", mutation.name());
                assert!(y.is_unoccluded(&space.scene), "{name} {}", mutation.name());
            }
            println!("{name} {}: {tried} tried, {in_medium} in media, {one_way} one way", mutation.name());
            let allowed = if matches!(mutation, AnyMutation::Caustic(_)) { tried / 5 } else { 0 };
            assert!(one_way <= allowed, "{name} {}: {one_way} of {tried} have no way back", mutation.name());
            // Few paths have several chains.
            let enough = if matches!(mutation, AnyMutation::MultiChain(_)) { 0 } else { 100 };
            assert!(
                in_medium > enough || enough == 0 && name != "furnished",
                "{name} {}: {in_medium} in media",
                mutation.name()
            );
        }
    }
}

#[test]
fn one_step_leaves_the_target_invariant_in_a_foggy_room() {
    check_kernels("furnished", &furnished(64, LENGTHS), nightly(150_000, 4_000_000));
}

#[test]
fn one_step_leaves_the_target_invariant_in_a_misty_yard() {
    check_kernels("misty yard", &misty_yard(64, LENGTHS), nightly(150_000, 4_000_000));
}

/// The largest |t| of a mutation's invariance law with a faulty density.
fn drift(mutation: AnyMutation, samples: usize, factor: impl Fn(&Path, &Path, (usize, Splice)) -> f64) -> f64 {
    let space = empty_room(Lengths { min_edges: 1, max_edges: 4 });
    // Laws are about images of this size.
    let scene = within(fog(0.8), room(6.0), Vec::new(), None, &eye(), 64);
    let kernels = [Scaled { mutation: mixture(vec![mutation]), factor }];
    let (law, _) = &drifts(&PathSpace { scene, ..space }, &kernels, samples, 29)[0];
    let t = law.verdict(ALPHA).max_t;
    println!("max |t| = {t:.1}");
    t
}

#[test]
fn a_perturbed_length_without_its_jacobian_is_caught() {
    // As if the density of a length e^x l were that of x.
    let factor = |_: &Path, to: &Path, (_, plan): (usize, Splice)| {
        let i = plan.prefix;
        if to.vertices[i].is_in_medium() { to.edges[i].length } else { 1.0 }
    };
    let t = drift(AnyMutation::Lens(Lens::default()), 400_000, factor);
    assert!(t > CAUGHT, "{t}");
}

#[test]
fn a_forgotten_choice_among_points_is_caught() {
    let points = |path: &Path| path.vertices.iter().filter(|vertex| vertex.is_in_medium()).count().max(1) as f64;
    // The number of points is kept, so only a choice that is not uniform can be wrong: one that prefers points near the eye.
    let factor = |from: &Path, to: &Path, (_, plan): (usize, Splice)| {
        to.edges[plan.prefix].length / from.edges[plan.prefix].length * points(from)
    };
    let t = drift(AnyMutation::Volume(Volume { max_free_paths: 2.0, min_free_paths: 0.1 }), 200_000, factor);
    assert!(t > CAUGHT, "{t}");
}

/// What the laws are about is there.
#[test]
fn foggy_scenes_have_all_kinds_of_paths() {
    for (name, space) in spaces(64) {
        let (mut source, mut rng) = (PathSource::new(&space), stream(7, Purpose::Chain, 6));
        let mut path = Path::default();
        let mut seen = [0u32; 4];
        for _ in 0..20_000 {
            if source.draw(&mut path, &mut rng).is_none() {
                continue;
            }
            let in_medium = path.vertices.iter().filter(|vertex| vertex.is_in_medium()).count();
            let dirac = path.vertices.iter().filter(|vertex| vertex.component != Component::Rough).count();
            let filled = path.vertices.iter().any(|vertex| vertex.is_in_medium() && vertex.medium() != u32::MAX);
            seen[0] += u32::from(in_medium == 0);
            seen[1] += u32::from(in_medium > 1);
            seen[2] += u32::from(in_medium > 0 && dirac > 0);
            seen[3] += u32::from(filled || name != "furnished");
        }
        println!("{name}: {seen:?}");
        assert!(seen.iter().all(|count| *count > 50), "{name}: {seen:?}");
    }
}

#[test]
fn all_methods_agree_in_a_foggy_room() {
    check_methods("furnished", &furnished(32, LENGTHS).scene);
}

#[test]
fn all_methods_agree_in_a_misty_yard() {
    check_methods("misty yard", &misty_yard(32, LENGTHS).scene);
}

/// The misty yard has scattering, an environment, a sun and a mirror.
#[test]
fn chains_of_primary_samples_agree_in_a_misty_yard() {
    check_primary("misty yard", &misty_yard(32, LENGTHS).scene, (32, 32));
}
