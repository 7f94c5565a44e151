//! Faulty meshes and instances give errors that say where.

use ergodic_geometry::{GeometryError, Instance, Mesh, World};
use glam::{DAffine3, DMat3, DVec2, DVec3, DVec4};

use crate::support::cube;

fn build(mesh: Mesh) -> Result<World, GeometryError> {
    World::build(vec![cube(1), mesh], vec![Instance { mesh: 1, transform: DAffine3::IDENTITY }])
}

#[test]
fn positions_must_be_finite_and_in_range() {
    for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e200] {
        let mut mesh = cube(1);
        mesh.positions[5].y = bad;
        assert_eq!(build(mesh).unwrap_err(), GeometryError::Position { mesh: 1, vertex: 5 });
    }
}

#[test]
fn indices_must_exist() {
    let mut mesh = cube(1);
    mesh.triangles[3][1] = 24;
    let error = build(mesh).unwrap_err();
    assert_eq!(error, GeometryError::VertexIndex { mesh: 1, triangle: 3, vertex: 24, vertices: 24 });
    let error = World::build(vec![cube(1)], vec![Instance { mesh: 1, transform: DAffine3::IDENTITY }]).unwrap_err();
    assert_eq!(error, GeometryError::MeshIndex { instance: 0, mesh: 1, meshes: 1 });
}

#[test]
fn attributes_must_have_one_entry_a_vertex() {
    let short = [
        ("normals", Mesh { normals: Some(vec![DVec3::Z; 23]), ..cube(1) }),
        ("tangents", Mesh { tangents: Some(vec![DVec4::X; 23]), ..cube(1) }),
        ("first texture coordinates", Mesh { texcoords: [Some(vec![DVec2::X; 23]), None], ..cube(1) }),
        ("second texture coordinates", Mesh { texcoords: [None, Some(vec![DVec2::X; 23])], ..cube(1) }),
        ("colors", Mesh { colors: Some(vec![DVec4::X; 23]), ..cube(1) }),
    ];
    for (attribute, mesh) in short {
        let error = build(mesh).unwrap_err();
        assert_eq!(error, GeometryError::AttributeLength { mesh: 1, attribute, found: 23, vertices: 24 });
    }
}

#[test]
fn transforms_must_be_finite_and_keep_the_mesh_in_range() {
    for bad in [
        DAffine3::from_translation(DVec3::new(0.0, f64::NAN, 0.0)),
        DAffine3::from_scale(DVec3::splat(1e150)),
        DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(1.0, f64::INFINITY, 1.0))),
    ] {
        let error = World::build(vec![cube(1)], vec![Instance { mesh: 0, transform: bad }]).unwrap_err();
        assert_eq!(error, GeometryError::Transform { instance: 0, mesh: 0 });
    }
}

#[test]
fn of_several_faults_the_first_is_named() {
    let mut mesh = cube(1);
    mesh.triangles.extend(vec![[0, 1, 2]; 100_000]);
    for triangle in [200, 70_000, 100_003] {
        mesh.triangles[triangle] = [1, 24 + triangle as u32, 99];
    }
    let error = build(mesh).unwrap_err();
    assert_eq!(error, GeometryError::VertexIndex { mesh: 1, triangle: 200, vertex: 224, vertices: 24 });

    let far = DAffine3::from_translation(DVec3::splat(1e200));
    let mut instances = vec![Instance { mesh: 0, transform: DAffine3::IDENTITY }; 1000];
    instances[300].transform = far;
    instances[301].mesh = 7;
    instances[900].transform = far;
    let error = World::build(vec![cube(1)], instances.clone()).unwrap_err();
    assert_eq!(error, GeometryError::Transform { instance: 300, mesh: 0 });
    instances.swap(300, 301);
    let error = World::build(vec![cube(1)], instances).unwrap_err();
    assert_eq!(error, GeometryError::MeshIndex { instance: 300, mesh: 7, meshes: 1 });
}
