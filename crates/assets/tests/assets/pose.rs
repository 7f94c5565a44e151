//! Morph targets, skins and visibility: the one moment of a scene that moves.

use glam::{DVec3, DVec4};
use serde_json::{Value, json};

use crate::support::{Buffer, TRIANGLE, load, triangle, try_load};

type Damage = fn(&mut Value);

const HALF: f32 = std::f32::consts::FRAC_1_SQRT_2;

fn close(a: DVec3, b: DVec3) {
    assert!((a - b).length() < 1e-6, "{a} is not {b}");
}

/// A triangle with normals, tangents and two morph targets, the second of 8-bit integers that are stored sparsely.
fn morphing() -> Value {
    let mut buffer = Buffer::default();
    buffer.floats(&TRIANGLE);
    buffer.floats(&[0.0, 0.0, 1.0].repeat(3));
    buffer.floats(&[1.0, 0.0, 0.0, -1.0].repeat(3));
    buffer.floats(&[0.0, 0.0, 2.0].repeat(3));
    buffer.floats(&[4.0, 0.0, 0.0].repeat(3));
    buffer.floats(&[-1.0, 4.0, 0.0].repeat(3));
    buffer.push(&[1]);
    buffer.push(&[0x80, 0, 0x7f]);
    buffer.finish(json!({
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}],
        "meshes": [{"weights": [0.25, 0], "primitives": [{
            "attributes": {"POSITION": 0, "NORMAL": 1, "TANGENT": 2},
            "targets": [{"POSITION": 3, "NORMAL": 4, "TANGENT": 5}, {"POSITION": 6}],
        }]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC4"},
            {"bufferView": 3, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 4, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 5, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"componentType": 5120, "normalized": true, "count": 3, "type": "VEC3", "sparse": {
                "count": 1,
                "indices": {"bufferView": 6, "componentType": 5121},
                "values": {"bufferView": 7},
            }},
        ],
    }))
}

#[test]
fn morph_targets_are_shown_at_the_weights_of_the_mesh_or_of_the_node() {
    let mut file = morphing();
    let asset = load(&file);
    let mesh = &asset.description.meshes[0];
    close(mesh.positions[1], DVec3::new(1.0, 0.0, 0.5));
    close(mesh.normals.as_ref().unwrap()[0], DVec3::new(1.0, 0.0, 1.0).normalize());
    let tangent = mesh.tangents.as_ref().unwrap()[2];
    assert!((tangent - DVec4::new(0.6, 0.8, 0.0, -1.0)).length() < 1e-6, "{tangent}");
    assert!(asset.warnings.is_empty() && asset.notes[0].starts_with("Morph targets"), "{:?}", asset.notes);

    // Nodes with weights of their own show the same mesh otherwise, and share what is the same.
    file["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "weights": [0, 2]}, {"mesh": 0, "weights": [0, 2]}]);
    let description = load(&file).description;
    let shown = description.placements.iter().map(|p| p.mesh).collect::<Vec<_>>();
    assert_eq!(shown, [0, 1, 1]);
    close(description.meshes[1].positions[0], DVec3::ZERO);
    // -128 and 127 stand for -1 and 1.
    close(description.meshes[1].positions[1], DVec3::new(-1.0, 0.0, 2.0));
}

#[test]
fn a_morph_target_must_fit_its_mesh() {
    let mut file = morphing();
    file["accessors"][3]["count"] = 2.into();
    assert_eq!(try_load(&file).unwrap_err().place, "meshes[0].primitives[0].targets[0].POSITION");
    let mut file = morphing();
    file["meshes"][0]["weights"] = json!([1e38, 0]);
    file["accessors"][3]["count"] = 3.into();
    assert!(try_load(&file).unwrap_err().problem.contains("no usable number"));
}

/// A triangle bound to two joints: the second vertex to the first joint, the third half to each, the first to the second.
fn skinned() -> Value {
    let mut buffer = Buffer::default();
    buffer.floats(&TRIANGLE);
    buffer.push(&[1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0]);
    // Weights as normalized bytes, which need not add up to exactly 1.
    buffer.push(&[255, 0, 0, 0, 255, 0, 0, 0, 127, 127, 0, 0]);
    let mut matrices = vec![0.0; 32];
    for i in 0..4 {
        matrices[5 * i] = 1.0;
        matrices[16 + 5 * i] = 1.0;
    }
    // The second joint stood at x = 1 when it was bound.
    matrices[16 + 12] = -1.0;
    buffer.floats(&matrices);
    buffer.floats(&[0.0, 0.0, 1.0].repeat(3));
    buffer.finish(json!({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [
            {"mesh": 0, "skin": 0, "translation": [100, 0, 0]},
            {"children": [2], "translation": [0, 0, 5]},
            {"translation": [3, 0, 0], "rotation": [0, 0, HALF, HALF]},
        ],
        "skins": [{"joints": [1, 2], "inverseBindMatrices": 3}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2, "NORMAL": 4}}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5121, "count": 3, "type": "VEC4"},
            {"bufferView": 2, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC4"},
            {"bufferView": 3, "componentType": 5126, "count": 2, "type": "MAT4"},
            {"bufferView": 4, "componentType": 5126, "count": 3, "type": "VEC3"},
        ],
    }))
}

#[test]
fn skins_stand_where_their_joints_do() {
    let asset = load(&skinned());
    let placement = &asset.description.placements[0];
    let mesh = &asset.description.meshes[placement.mesh];
    // The node's own transform has no effect.
    let world = |i: usize| placement.transform.transform_point3(mesh.positions[i]);
    // (0, 0, 0) is (-1, 0, 0) for the second joint, turned by 90 degrees (0, -1, 0), and moved by (3, 0, 5).
    close(world(0), DVec3::new(3.0, -1.0, 5.0));
    close(world(1), DVec3::new(1.0, 0.0, 5.0));
    // The mean of (0, 1, 5) and, by (-1, 1, 0) and (-1, -1, 0), of (2, -1, 5).
    close(world(2), DVec3::new(1.0, 0.0, 5.0));
    assert!(asset.warnings.is_empty() && asset.notes[0].starts_with("Skins (nodes[0])"), "{:?}", asset.notes);
}

#[test]
fn mirroring_joints_turn_triangles_round_and_normals_with_them() {
    let mut file = skinned();
    file["nodes"][1]["scale"] = json!([1, 1, -2]);
    let description = load(&file).description;
    let mesh = &description.meshes[0];
    let [a, b, c] = mesh.triangles[0].map(|i| mesh.positions[i as usize]);
    let front = (b - a).cross(c - a);
    for normal in mesh.normals.as_ref().unwrap() {
        assert!((*normal - DVec3::NEG_Z).length() < 1e-6 || front.length() == 0.0);
        assert!(front.dot(*normal) >= 0.0, "{front} {normal}");
    }
}

#[test]
fn broken_skins_are_named_and_homeless_joints_leave_the_mesh_at_its_node() {
    let broken: [(Damage, &str); 4] = [
        (|f| f["nodes"][0]["skin"] = 1.into(), "nodes[0].skin"),
        (|f| f["skins"][0]["joints"] = json!([1, 9]), "skins[0].joints[1]"),
        (|f| f["skins"][0]["joints"] = json!([1]), "meshes[0].primitives[0].attributes.JOINTS_0"),
        (|f| f["accessors"][3]["count"] = 1.into(), "skins[0].inverseBindMatrices"),
    ];
    for (damage, place) in broken {
        let mut file = skinned();
        damage(&mut file);
        let error = try_load(&file).unwrap_err();
        assert_eq!(error.place, place, "{error}");
    }
    let mut file = skinned();
    file["scenes"][0]["nodes"] = json!([0]);
    let asset = load(&file);
    assert_eq!(asset.description.placements[0].transform.translation, DVec3::new(100.0, 0.0, 0.0));
    assert!(asset.warnings[0].starts_with("A joint of a skin"), "{:?}", asset.warnings);
    assert!(asset.notes.is_empty(), "{:?}", asset.notes);
}

#[test]
fn invisible_nodes_hide_what_is_below_them_but_no_camera() {
    let mut file = triangle();
    let hidden = json!({"KHR_node_visibility": {"visible": false}});
    file["extensionsRequired"] = json!(["KHR_node_visibility"]);
    file["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]);
    file["nodes"] = json!([
        {"mesh": 0},
        {"children": [2], "extensions": hidden},
        {"mesh": 0, "camera": 0, "extensions": {"KHR_node_visibility": {"visible": true}}},
    ]);
    file["scenes"][0]["nodes"] = json!([0, 1]);
    let asset = load(&file);
    assert_eq!((asset.description.placements.len(), asset.description.cameras.len()), (1, 1));
    assert!(asset.notes[0].starts_with("Invisible nodes (nodes[2])"), "{:?}", asset.notes);
}
