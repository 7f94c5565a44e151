//! Points very near to each other, and surfaces very near to the rays that leave them.

use ergodic_metropolis::Mutation;
use ergodic_mutations::AnyMutation;
use ergodic_pathspace::{BidirectionalSampler, End, Lengths, Path, PathSpace, Roulette, Subpath, contribution};
use ergodic_render::{Method, Purpose, stream};
use ergodic_scattering::luminance;
use ergodic_tests::{Eye, cuboid, description_of, diffuse, nightly, quad, scene_of, view_of};
use glam::{DAffine3, DMat3, DVec3};

use super::{SIDE, check, means, settings};

fn eye() -> Eye {
    Eye { from: DVec3::new(0.3, -0.2, 0.1), at: DVec3::new(-1.0, 1.0, -0.5), up: DVec3::Z, fov: 0.8 }
}

/// A white room that emits everywhere, seen into a corner.
fn room(lengths: Lengths) -> PathSpace {
    let room = (cuboid(DVec3::new(1.0, 1.0, 0.5), true), diffuse(0.7, 1.5));
    PathSpace { scene: scene_of(vec![room], Vec::new(), &eye(), SIDE), lengths }
}

#[test]
fn contributions_stay_bounded_however_near_the_ends_of_a_connection_are() {
    // A lamp and a floor that meet in an edge, each 1e-5 wide; all connections are shorter than that.
    const WIDE: f64 = 1e-5;
    let lamp = quad(DVec3::ZERO, DVec3::Y * WIDE, DVec3::Z * WIDE);
    let floor = quad(DVec3::new(0.0, -0.5, 0.0), DVec3::X, DVec3::Y);
    let eye = Eye::over(DVec3::new(0.6, 0.0, 0.8) * 0.1, DVec3::new(0.5, 0.5, 0.0) * WIDE, DVec3::Y, 0.5 * WIDE);
    let things = || vec![(lamp.clone(), diffuse(0.0, 1.0)), (floor.clone(), diffuse(0.7, 0.0))];
    let space = PathSpace {
        scene: scene_of(things(), Vec::new(), &eye, SIDE),
        lengths: Lengths { min_edges: 2, max_edges: 2 },
    };
    let mut sampler = BidirectionalSampler::new(space.lengths, Roulette::OFF);
    let mut rng = stream(3, Purpose::Bidirectional, 11);
    // By powers of ten of the length of the connecting edge: connections, largest estimate before and after weighting.
    let mut bins = [(0u64, 0.0f64, 0.0f64); 12];
    let mut path = Path::default();
    for _ in 0..nightly(400_000, 10_000_000) {
        sampler.sample(&space.scene, &mut rng, |sampler, c| {
            // Strategy s = 1 connects floor and lamp; s = 2 floor and eye, which are apart.
            if c.s != 1 {
                return;
            }
            sampler.assemble(&space.scene, c.s, c.t, &mut path);
            let length = path.edges[0].length / space.scene.scale();
            let bin = &mut bins[(-length.log10()).clamp(0.0, 11.0) as usize];
            bin.0 += 1;
            bin.1 = bin.1.max(luminance(c.estimate));
            bin.2 = bin.2.max(luminance(c.contribution()));
        });
    }
    for (i, (count, plain, weighted)) in bins.iter().enumerate().filter(|(_, bin)| bin.0 > 0) {
        println!("connections of 1e-{i}: {count}, largest estimate {plain:.1e}, weighted {weighted:.1e}");
    }
    assert!(bins[6..].iter().any(|bin| bin.0 > 0), "no connection was short enough to try this: {bins:?}");
    let weighted = bins.iter().map(|bin| bin.2).fold(0.0, f64::max);
    let plain = bins.iter().map(|bin| bin.1).fold(0.0, f64::max);
    // The floor reflects 0.7 of a radiance of 1; the heuristic's weights keep an estimate within a few times that.
    assert!(weighted < 2.0, "{weighted}");
    // Without weights 1 / d² shows: the measure can fail.
    assert!(plain > 30.0 * weighted, "{plain}");
    let edges = 2..=2;
    let expected = means(&space.scene, &settings(Method::Path, &edges, 256.0));
    check("an edge of 1e-5", &space.scene, edges, [0.0, 64.0, 512.0], &expected, 0.02);
}

#[test]
fn neighbours_a_ten_millionth_apart_have_densities() {
    // Light - wall - next wall - eye, two of the vertices on either side of an edge of the room.
    let space = room(Lengths { min_edges: 3, max_edges: 3 });
    let scene = &space.scene;
    let mut rng = stream(5, Purpose::Chain, 1);
    let world = scene.world();
    let (low, high) = world.bounds();
    let hit = |origin: DVec3, direction: DVec3| {
        world
            .intersect(&ergodic_geometry::Ray { origin, direction })
            .map(|hit| scene.vertex(&hit))
            .expect("the room is closed")
    };
    for apart in [1e-3, 1e-5, 1e-7] {
        // Beside the edge where the lowest x and the highest y meet.
        let z = 0.5 * (low.z + high.z) - 0.1;
        let from = DVec3::new(low.x + 0.3, high.y - 0.3, z);
        let a = hit(DVec3::new(from.x, high.y - apart, z), DVec3::NEG_X);
        let b = hit(DVec3::new(low.x + apart, from.y, z), DVec3::Y);
        let light = hit(from, DVec3::new(0.3, -0.5, 0.8).normalize());
        let camera = scene.camera_vertex();
        let x = Path::of(scene, vec![light, a, b, camera]);
        assert!((x.edges[1].length / (apart * 2f64.sqrt()) - 1.0).abs() < 1e-6, "{}", x.edges[1].length);
        let f = contribution(&x);
        assert!(f.ln_luminance().is_finite() && f.rgb.is_finite(), "{f:?}");
        let mut y = Path::default();
        for mutation in AnyMutation::all() {
            let mut tried = 0;
            for _ in 0..20_000 {
                let Ok(plan) = mutation.propose(&space, &x, &mut y, &mut rng) else { continue };
                let (forward, backward) =
                    (mutation.ln_density(&space, &x, &y, plan), mutation.ln_density(&space, &y, &x, plan));
                assert!(forward.is_finite(), "{} {apart:e}: {forward}", mutation.name());
                assert!(!backward.is_nan() && backward < f64::INFINITY, "{} {apart:e}: {backward}", mutation.name());
                tried += 1;
            }
            println!(
                "{apart:e} apart, ln f = {:.2}, {}: {tried} proposals with densities both ways",
                f.ln_luminance(),
                mutation.name()
            );
            assert!(tried > 0 || mutation.suitability(&space, &x) == 0.0, "{}", mutation.name());
        }
    }
}

/// Walks in a closed room: how many of their rays got out, and how many met something at once that is not there.
fn leaks(scale: f64, offset: DVec3, walks: u32) -> (u64, u64, u64) {
    let room = (cuboid(DVec3::new(1.0, 1.0, 0.5), true), diffuse(0.7, 1.5));
    let mut description = description_of(vec![room], Vec::new(), &eye());
    let change = DAffine3 { matrix3: DMat3::from_diagonal(DVec3::splat(scale)), translation: offset };
    description.placements[0].transform = change;
    let from = &mut description.cameras[0].transform.translation;
    *from = change.transform_point3(*from);
    let scene = view_of(description, (SIDE, SIDE));
    let mut rng = stream(9, Purpose::PathTracer, 3);
    let mut walk = Subpath::new(End::Eye, 17);
    let (mut rays, mut escaped, mut acne) = (0, 0, 0);
    let offset = {
        let (low, high) = scene.world().bounds();
        (high - low).length() * 1e-9
    };
    for _ in 0..walks {
        walk.walk(&scene, 17, &Roulette::OFF, &mut rng);
        rays += walk.len() as u64 - 1;
        escaped += u64::from(walk.len() < 17);
        // A convex room: no ray ends where it began, and none stays in the plane of its wall.
        acne += walk.edges[1..].iter().filter(|edge| edge.length < offset).count() as u64;
        acne += walk.vertices[1..].windows(2).filter(|pair| pair[0].interaction.ng == pair[1].interaction.ng).count()
            as u64;
    }
    (rays, escaped, acne)
}

#[test]
fn no_ray_leaves_a_closed_room_at_any_scale_and_place() {
    for scale in [1e-4, 1e-3, 1.0, 1e3, 1e4] {
        for distance in [0.0, 1e3, 1e4, 1e6] {
            let (rays, escaped, acne) =
                leaks(scale, DVec3::new(distance, -distance, 0.5 * distance), nightly(4_000, 400_000));
            println!(
                "a room of {scale:e}, moved by {distance:e}: {rays} rays, {escaped} escaped, {acne} met their own wall"
            );
            assert_eq!((escaped, acne), (0, 0), "scale {scale}, moved by {distance}");
        }
    }
}
