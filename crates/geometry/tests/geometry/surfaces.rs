//! Normals, tangents and attributes under transforms, and frames.

use ergodic_geometry::{Frame, Instance, Mesh, Ray, World};
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3, DVec4};

use crate::support::{Random, cube, sphere};

/// A triangle in z = 0 whose front looks up, with every attribute.
fn triangle() -> Mesh {
    Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        triangles: vec![[0, 1, 2]],
        normals: Some(
            [[0.3, 0.0, 1.0], [0.0, 0.2, 1.0], [-0.1, 0.1, 1.0]].map(|n| DVec3::from_array(n).normalize()).to_vec(),
        ),
        tangents: Some(vec![DVec4::new(1.0, 0.0, 0.0, -1.0); 3]),
        texcoords: [Some(vec![DVec2::ZERO, DVec2::X, DVec2::Y]), Some(vec![DVec2::ONE; 3])],
        colors: Some(vec![DVec4::ZERO, DVec4::new(1.0, 0.5, 0.0, 1.0), DVec4::ONE]),
    }
}

fn placed(mesh: Mesh, transform: DAffine3) -> World {
    World::build(vec![mesh], vec![Instance { mesh: 0, transform }]).expect("a valid world")
}

#[test]
fn attributes_are_interpolated() {
    let surface = placed(triangle(), DAffine3::IDENTITY).surface_at(0, 0, 0.25, 0.5);
    assert_eq!(surface.position, DVec3::new(0.25, 0.5, 0.0));
    assert_eq!(surface.ng, DVec3::Z);
    assert_eq!(surface.texcoords, [DVec2::new(0.25, 0.5), DVec2::ONE]);
    assert_eq!(surface.color, DVec4::new(0.75, 0.625, 0.5, 0.75));
    assert_eq!((surface.tangent, surface.bitangent_sign), (DVec3::X, -1.0));
}

#[test]
fn missing_attributes_have_defaults() {
    let bare = Mesh { positions: triangle().positions, triangles: vec![[0, 1, 2]], ..Mesh::default() };
    let surface = placed(bare, DAffine3::IDENTITY).surface_at(0, 0, 0.25, 0.5);
    assert_eq!(surface.ns, surface.ng);
    assert_eq!(surface.texcoords, [DVec2::ZERO; 2]);
    assert_eq!(surface.color, DVec4::ONE);
    assert_eq!((surface.tangent, surface.bitangent_sign), (DVec3::ZERO, 0.0));
}

#[test]
fn the_front_stays_the_front_under_any_transform() {
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), 1.1);
    for scale in [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [2.0, -0.1, 3.0], [-1.0, -2.0, -3.0], [-1.0, -1.0, 0.5]] {
        let scale = DVec3::from_array(scale);
        let world = placed(
            Mesh { normals: Some(sphere(2).positions), ..sphere(2) },
            DAffine3::from_scale_rotation_translation(scale, turn, DVec3::new(5.0, 6.0, 7.0)),
        );
        for t in 0..world.triangle_count(0) as u32 {
            let surface = world.surface_at(0, t, 0.3, 0.3);
            let outward = surface.position - DVec3::new(5.0, 6.0, 7.0);
            assert!(surface.ng.dot(outward) > 0.0, "scale {scale}");
            // The normal of an ellipsoid is the inverse transpose of the sphere's.
            let on_sphere = turn.inverse() * outward / scale;
            let exact = (turn * (on_sphere / scale)).normalize();
            assert!(surface.ns.dot(exact) > 0.99, "scale {scale}: {} {exact}", surface.ns);
            assert!((surface.ns.length() - 1.0).abs() < 1e-14 && (surface.ng.length() - 1.0).abs() < 1e-14);
        }
    }
}

#[test]
fn vertex_normals_transform_by_the_inverse_transpose() {
    let m = DMat3::from_cols(DVec3::new(1.0, 0.4, 0.0), DVec3::new(0.0, -2.0, 0.3), DVec3::new(0.5, 0.0, 3.0));
    let mesh = triangle();
    let n = mesh.normals.as_ref().unwrap()[1];
    let surface = placed(mesh, DAffine3::from_mat3_translation(m, DVec3::ONE)).surface_at(0, 0, 1.0, 0.0);
    let exact = (m.inverse().transpose() * n).normalize();
    assert!(surface.ns.distance(exact) < 1e-14);
    // The bitangent is the transformed one, although the transform mirrors.
    assert!(m.determinant() < 0.0);
    let (t, b) = (DVec3::X, -n.cross(DVec3::X));
    assert!(surface.tangent.distance((m * t).normalize()) < 1e-14);
    assert!((surface.ns.cross(surface.tangent) * surface.bitangent_sign).dot(m * b) > 0.0);
}

#[test]
fn shading_normals_are_turned_to_the_geometric_side() {
    let mut mesh = triangle();
    let up = mesh.normals.clone().unwrap();
    mesh.normals = Some(up.iter().map(|n| -n).collect());
    let (surface, plain) = (
        placed(mesh, DAffine3::IDENTITY).surface_at(0, 0, 0.2, 0.3),
        placed(triangle(), DAffine3::IDENTITY).surface_at(0, 0, 0.2, 0.3),
    );
    assert_eq!(surface.ns, plain.ns);
    // ns was turned around, so the sign turns for the bitangent to stay.
    assert_eq!(surface.bitangent_sign, -plain.bitangent_sign);
}

#[test]
fn useless_normals_and_tangents_are_replaced() {
    for useless in [DVec3::ZERO, DVec3::NAN] {
        let mesh = Mesh { normals: Some(vec![useless; 3]), tangents: Some(vec![useless.extend(1.0); 3]), ..triangle() };
        let surface = placed(mesh, DAffine3::IDENTITY).surface_at(0, 0, 0.2, 0.3);
        assert_eq!(surface.ns, DVec3::Z);
        assert_eq!((surface.tangent, surface.bitangent_sign), (DVec3::ZERO, 0.0));
    }
}

#[test]
fn degenerate_triangles_are_dropped_counted_and_have_a_normal() {
    let mut mesh = cube(1);
    mesh.positions.extend([DVec3::ZERO, DVec3::new(0.1, 0.1, 0.1), DVec3::new(0.2, 0.2, 0.2)]);
    mesh.triangles.extend([[24, 25, 26], [24, 24, 24], [24, 25, 25]]);
    let world = placed(mesh, DAffine3::from_translation(DVec3::new(0.3, 0.0, 0.0)));
    assert_eq!(world.dropped_triangles(), 3);
    assert_eq!(world.triangle_count(0), 15);
    let mut random = Random::new(1);
    for _ in 0..1000 {
        let hit = world.intersect(&Ray { origin: DVec3::new(0.3, 0.0, 0.0), direction: random.direction() }).unwrap();
        assert!(hit.triangle < 12);
    }
    for t in 12..15 {
        let surface = world.surface_at(0, t, 0.2, 0.2);
        assert!((surface.ng.length() - 1.0).abs() < 1e-14);
        assert!(surface.ns.is_finite());
    }
}

#[test]
fn bounds_hold_every_instance() {
    let at = |x: f64, scale: f64| Instance {
        mesh: 0,
        transform: DAffine3::from_scale_rotation_translation(
            DVec3::splat(scale),
            DQuat::IDENTITY,
            DVec3::new(x, 0.0, 0.0),
        ),
    };
    let world = World::build(vec![cube(1)], vec![at(-5.0, 1.0), at(10.0, -2.0)]).unwrap();
    assert_eq!(world.bounds(), (DVec3::new(-6.0, -2.0, -2.0), DVec3::new(12.0, 2.0, 2.0)));
}

fn assert_orthonormal(frame: &Frame) {
    let m = DMat3::from_cols(frame.t, frame.b, frame.n);
    let error = m.transpose() * m - DMat3::IDENTITY;
    assert!(error.to_cols_array().iter().all(|e| e.abs() < 1e-14), "{frame:?}");
    assert!((m.determinant() - 1.0).abs() < 1e-14, "{frame:?}");
}

#[test]
fn frames_are_right_handed_and_orthonormal() {
    let mut random = Random::new(1);
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let normals: Vec<DVec3> =
        axes.iter().flat_map(|a| [*a, -*a]).chain((0..10_000).map(|_| random.direction())).collect();
    for n in normals {
        let frame = Frame::from_normal(n);
        assert_orthonormal(&frame);
        let w = random.direction();
        assert!(frame.to_world(frame.to_local(w)).distance(w) < 1e-14);
        assert!(frame.to_local(n).distance(DVec3::Z) < 1e-14);
        for tangent in [
            random.cube(),
            n,
            n * 3.0 + random.cube() * 1e-7,
            n + random.cube() * 1e-17,
            DVec3::ZERO,
            DVec3::NAN,
            DVec3::INFINITY,
        ] {
            let frame = Frame::from_normal_tangent(n, tangent);
            assert_orthonormal(&frame);
            if tangent.is_finite() && n.cross(tangent).length() > 1e-3 {
                assert!(frame.t.dot(tangent) > 0.0 && frame.b.dot(tangent).abs() < 1e-14);
            }
        }
    }
}

#[test]
fn what_lies_in_the_place_of_another_can_not_be_hit() {
    let moved = |x: f64| DAffine3::from_translation(DVec3::new(x, 0.0, 0.0));
    let instance = |mesh, x| Instance { mesh, transform: moved(x) };
    let mut turned = triangle();
    turned.triangles = turned.triangles.iter().map(|[a, b, c]| [*c, *b, *a]).collect();
    // A mesh twice in one place, once elsewhere; and another mesh, turned over, in the first place of a third.
    let meshes = vec![triangle(), turned, triangle()];
    let instances = vec![instance(0, 0.0), instance(0, 0.0), instance(0, 5.0), instance(2, 9.0), instance(1, 9.0)];
    let world = World::build(meshes, instances).unwrap();
    let found: Vec<bool> = (0..5).map(|i| world.can_be_hit(i, 0)).collect();
    assert_eq!(found, [true, false, true, true, false]);
    for (x, owner) in [(0.0, 0), (5.0, 2), (9.0, 3)] {
        let [a, b, c] = world.triangle(owner, 0);
        let middle = (a + b + c) / 3.0;
        assert!((middle.x - x).abs() < 2.0);
        for direction in [DVec3::NEG_Z, DVec3::Z] {
            let hit = world.intersect(&Ray { origin: middle - direction, direction }).unwrap();
            assert_eq!(hit.instance, owner);
        }
    }
}
