//! Nodes, instances, cameras and lights.

use std::f64::consts::FRAC_PI_2;

use ergodic_assets::CameraError;
use ergodic_pathspace::{CameraDescription, Projection};
use ergodic_scattering::{Lens, PunctualLight, Rgb};
use glam::DVec3;
use serde_json::json;

use crate::support::{Buffer, TRIANGLE, load, triangle, try_load};

const HALF: f32 = std::f32::consts::FRAC_1_SQRT_2;

fn close(a: DVec3, b: DVec3) {
    assert!((a - b).length() < 1e-6, "{a} is not {b}");
}

#[test]
fn transforms_compose_from_the_root_downwards() {
    let mut file = triangle();
    // A mirror, a quarter turn about z, and a non-uniform scale by a matrix.
    file["nodes"] = json!([
        {"children": [1], "translation": [10, 0, 0], "scale": [-1, 1, 1]},
        {"children": [2], "rotation": [0, 0, HALF, HALF]},
        {"mesh": 0, "matrix": [2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 4, 0, 1, 1, 1, 1]},
    ]);
    let asset = load(&file);
    let transform = asset.description.placements[0].transform;
    // (1, 0, 0) -> (3, 1, 1) -> (-1, 3, 1) -> (1, 3, 1) + (10, 0, 0).
    close(transform.transform_point3(DVec3::X), DVec3::new(11.0, 3.0, 1.0));
    assert!(transform.matrix3.determinant() < 0.0);
    close(DVec3::splat(transform.matrix3.determinant()), DVec3::splat(-24.0));
}

#[test]
fn nodes_outside_the_scene_are_not_shown() {
    let mut file = triangle();
    file["nodes"] = json!([{"mesh": 0}, {"mesh": 0}]);
    assert_eq!(load(&file).description.placements.len(), 1);
    file["scenes"] = json!([]);
    file.as_object_mut().unwrap().remove("scene");
    assert_eq!(load(&file).description.placements.len(), 2);
}

#[test]
fn instances_share_a_mesh_and_the_default_material_is_made_once() {
    let mut file = triangle();
    file["scenes"][0]["nodes"] = json!([0, 1]);
    file["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "translation": [1, 2, 3]}]);
    let description = load(&file).description;
    assert_eq!((description.meshes.len(), description.placements.len(), description.materials.len()), (1, 2, 1));
    let material = &description.materials[0];
    assert_eq!((material.metallic, material.roughness, material.base_color), (1.0, 1.0, Rgb::ONE));
}

#[test]
fn gpu_instancing_multiplies_a_node() {
    let mut buffer = Buffer::default();
    buffer.floats(&TRIANGLE);
    buffer.floats(&[1.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    buffer.floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, HALF, HALF]);
    let instancing = json!({"attributes": {"TRANSLATION": 1, "ROTATION": 2}});
    let file = buffer.finish(json!({
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0, "scale": [2, 2, 2], "extensions": {"EXT_mesh_gpu_instancing": instancing}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 2, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC4"},
        ],
    }));
    let placements = load(&file).description.placements;
    assert_eq!(placements.len(), 2);
    close(placements[0].transform.transform_point3(DVec3::X), DVec3::new(4.0, 0.0, 0.0));
    close(placements[1].transform.transform_point3(DVec3::X), DVec3::new(4.0, 2.0, 0.0));
}

#[test]
fn gpu_instances_may_be_quantized_or_have_attributes_of_their_own_only() {
    let mut buffer = Buffer::default();
    buffer.floats(&TRIANGLE);
    // A half turn about z, and none.
    buffer.push(&[0, 0, 127, 0, 0, 0, 0, 127]);
    buffer.push(&[7, 8]);
    let mut file = buffer.finish(json!({
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"ROTATION": 1, "_ID": 2}}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5120, "normalized": true, "count": 2, "type": "VEC4"},
            {"bufferView": 2, "componentType": 5121, "count": 2, "type": "SCALAR"},
        ],
    }));
    let placements = load(&file).description.placements;
    close(placements[0].transform.transform_point3(DVec3::X), DVec3::NEG_X);
    close(placements[1].transform.transform_point3(DVec3::X), DVec3::X);
    file["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = json!({"_ID": 2});
    assert_eq!(load(&file).description.placements.len(), 2);
}

fn vertical_fov(camera: &CameraDescription) -> f64 {
    match camera.projection {
        Projection::Perspective { vertical_fov, .. } => vertical_fov,
        Projection::Orthographic { .. } => f64::NAN,
    }
}

fn with_cameras() -> serde_json::Value {
    let mut file = triangle();
    file["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    file["nodes"] = json!([
        {"mesh": 0},
        {"camera": 1, "name": "left", "translation": [-5, 0, 0]},
        {"camera": 0, "name": "right", "translation": [5, 0, 0], "scale": [3, 3, 3]},
        {"camera": 2, "name": "flat"},
    ]);
    file["cameras"] = json!([
        {"type": "perspective", "name": "wide", "perspective": {"yfov": 1.5, "znear": 0.1}},
        {"type": "perspective", "name": "narrow", "perspective": {"yfov": 0.5, "znear": 0.1, "aspectRatio": 2}},
        {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 3, "zfar": 2, "znear": 1}},
    ]);
    file
}

#[test]
fn cameras_are_found_by_number_by_node_and_by_name() {
    let asset = load(&with_cameras());
    let fov = |wanted: &str| vertical_fov(&asset.camera(wanted, 1.0).unwrap().0);
    assert_eq!((fov(""), fov("0"), fov("right"), fov("wide")), (1.5, 1.5, 1.5, 1.5));
    assert_eq!((fov("1"), fov("left"), fov("narrow")), (0.5, 0.5, 0.5));
    assert!(!asset.camera("", 1.0).unwrap().1);
    let error = asset.camera("up", 1.0).unwrap_err().to_string();
    assert!(error.contains("\"up\"") && error.contains("0 (\"right\"), 1 (\"left\")"), "{error}");
    let flat = asset.camera("flat", 1.0).unwrap().0.projection;
    assert_eq!(flat, Projection::Orthographic { height: 6.0, near: 1.0 });
}

#[test]
fn a_lens_is_read_from_the_extras_of_a_camera() {
    let lens = |extras: serde_json::Value| {
        let mut file = with_cameras();
        file["cameras"][0]["extras"] = extras;
        match try_load(&file)?.camera("0", 1.0).unwrap().0.projection {
            Projection::Perspective { lens, .. } => Ok::<_, ergodic_assets::AssetError>(lens),
            Projection::Orthographic { .. } => unreachable!("camera 0 is perspective"),
        }
    };
    let whole = json!({"lensRadius": 0.01, "focusDistance": 2.5, "lensBlades": 6, "lensRotation": 0.3, "other": [1]});
    let expected = Lens { radius: 0.01, focus_distance: 2.5, blades: 6, rotation: 0.3 };
    assert_eq!(lens(whole).unwrap(), Some(expected));
    let disk = Lens { blades: 0, rotation: 0.0, ..expected };
    assert_eq!(lens(json!({"lensRadius": 0.01, "focusDistance": 2.5})).unwrap(), Some(disk));
    // A radius of 0 is a pinhole, and extras of other programs are not looked at.
    for extras in
        [json!({"lensRadius": 0, "focusDistance": 2.5}), json!({"focusDistance": "far"}), json!([3]), json!("x")]
    {
        assert_eq!(lens(extras).unwrap(), None);
    }
    for (extras, place) in [
        (json!({"lensRadius": -1, "focusDistance": 2}), "cameras[0].extras.lensRadius"),
        (json!({"lensRadius": 1, "focusDistance": 0}), "cameras[0].extras.focusDistance"),
        (json!({"lensRadius": 1, "focusDistance": 1, "lensBlades": 2}), "cameras[0].extras.lensBlades"),
        (json!({"lensRadius": 1}), "cameras[0].extras"),
        (json!({"lensRadius": "wide", "focusDistance": 1}), "cameras[0].extras"),
    ] {
        assert_eq!(lens(extras).unwrap_err().place, place);
    }
}

#[test]
fn two_cameras_of_one_name_must_be_told_apart() {
    let mut file = with_cameras();
    file["nodes"][1]["name"] = "right".into();
    let error = load(&file).camera("right", 1.0).unwrap_err();
    assert!(matches!(&error, CameraError::Ambiguous { numbers, .. } if numbers == "0, 1"), "{error}");
}

#[test]
fn without_a_camera_the_whole_scene_is_framed() {
    let mut file = triangle();
    file["nodes"][0]["translation"] = json!([100, 50, -7]);
    let asset = load(&file);
    for aspect in [0.25, 1.0, 4.0] {
        let (camera, framed) = asset.camera("", aspect).unwrap();
        assert!(framed);
        let to_camera = camera.transform.inverse();
        let tan = (vertical_fov(&camera) * 0.5).tan();
        for x in [100.0, 101.0] {
            for y in [50.0, 51.0] {
                let p = to_camera.transform_point3(DVec3::new(x, y, -7.0));
                assert!(p.z < 0.0 && p.y.abs() < -p.z * tan && p.x.abs() < -p.z * tan * aspect, "{p} at {aspect}");
            }
        }
    }
    assert!(matches!(asset.camera("main", 1.0), Err(CameraError::None { .. })));
}

#[test]
fn lights_shine_along_their_node_and_ignore_its_scale() {
    let mut file = triangle();
    file["extensionsRequired"] = json!(["KHR_lights_punctual"]);
    file["extensions"]["KHR_lights_punctual"]["lights"] = json!([
        {"type": "point", "color": [1, 0.5, 0], "intensity": 4},
        {"type": "directional", "intensity": 2},
        {"type": "spot", "spot": {"innerConeAngle": 0.25, "outerConeAngle": FRAC_PI_2}, "range": 3},
    ]);
    let node = |light: usize| {
        json!({
            "extensions": {"KHR_lights_punctual": {"light": light}},
            "translation": [1, 2, 3],
            "rotation": [HALF, 0, 0, HALF],
            "scale": [5, 5, 5],
        })
    };
    file["nodes"] = json!([{"mesh": 0}, node(0), node(1), node(2)]);
    file["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    let asset = load(&file);
    let here = DVec3::new(1.0, 2.0, 3.0);
    let [
        PunctualLight::Point { position, intensity },
        PunctualLight::Directional { direction, irradiance },
        PunctualLight::Spot { axis, cos_inner, cos_outer, .. },
    ] = asset.description.lights[..]
    else {
        panic!("{:?}", asset.description.lights)
    };
    assert_eq!((position, intensity), (here, Rgb::new(4.0, 2.0, 0.0)));
    // A quarter turn about x takes -z to +y.
    close(direction, DVec3::Y);
    close(axis, DVec3::Y);
    assert_eq!(irradiance, Rgb::splat(2.0));
    assert!((cos_inner - 0.25f64.cos()).abs() < 1e-7 && (0.0..1e-7).contains(&cos_outer));
    assert!(asset.warnings.iter().any(|w| w.starts_with("Ranges of lights")), "{:?}", asset.warnings);
}

#[test]
fn a_loop_or_a_second_parent_is_an_error() {
    let mut file = triangle();
    file["nodes"] = json!([{"children": [1]}, {"children": [0]}]);
    assert!(try_load(&file).unwrap_err().problem.contains("reached twice"));
    file["nodes"] = json!([{"children": [1, 2]}, {"children": [3]}, {"children": [3]}, {"mesh": 0}]);
    assert_eq!(try_load(&file).unwrap_err().place, "nodes[3]");
}

#[test]
fn a_chain_of_a_hundred_thousand_nodes_does_not_exhaust_the_stack() {
    let mut file = triangle();
    let count = 100_000;
    file["nodes"] = (0..count).map(|i| json!({"children": [i + 1], "translation": [1, 0, 0]})).collect();
    file["nodes"].as_array_mut().unwrap().push(json!({"mesh": 0}));
    let description = load(&file).description;
    assert_eq!(description.placements[0].transform.translation.x, f64::from(count));
}
