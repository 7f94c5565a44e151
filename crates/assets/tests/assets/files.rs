//! Files on disk: buffers and images beside the scene.

use std::fs;

use base64::Engine;
use ergodic_assets::load;

use crate::support::{load as load_json, triangle};

#[test]
fn a_scene_finds_the_files_beside_it() {
    let folder = std::env::temp_dir().join(format!("ergodic assets ❤ {}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let mut file = triangle();
    let data = file["buffers"][0]["uri"].as_str().unwrap().split_once(',').unwrap().1.to_string();
    fs::write(folder.join("a b.bin"), base64::engine::general_purpose::STANDARD.decode(data).unwrap()).unwrap();
    file["buffers"][0]["uri"] = "a%20b.bin".into();
    let path = folder.join("scene.gltf");
    fs::write(&path, file.to_string()).unwrap();
    let asset = load(&path);
    fs::write(&path, [b"\xef\xbb\xbf", file.to_string().as_bytes()].concat()).unwrap();
    let marked = load(&path);
    fs::remove_dir_all(&folder).unwrap();
    assert_eq!(asset.unwrap().description.meshes[0].triangles.len(), 1);
    assert!(marked.is_ok(), "a byte order mark is skipped");
}

#[test]
fn the_scenes_of_the_repository_load_without_a_warning() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut count = 0;
    for folder in fs::read_dir(root).unwrap() {
        let path = folder.unwrap().path().join("scene.glb");
        let asset = load(&path).unwrap();
        assert!(asset.warnings.is_empty(), "{:?}", asset.warnings);
        assert_eq!(asset.description.cameras.len(), 1);
        count += 1;
    }
    assert!(count >= 5);
}

#[test]
fn extras_of_any_type_and_integers_with_a_point_are_allowed() {
    let mut file = triangle();
    file["nodes"][0]["extras"] = 42.into();
    file["asset"]["extras"] = serde_json::json!([1, {"extras": null}]);
    file["accessors"][0]["count"] = 3.0.into();
    file["nodes"][0]["translation"] = serde_json::json!([1.0, 1e3, 0.5]);
    let description = load_json(&file).description;
    assert_eq!(description.placements[0].transform.translation.to_array(), [1.0, 1000.0, 0.5]);
    // A scene without nodes is allowed as well, though there is nothing to see.
    file["scenes"].as_array_mut().unwrap().push(serde_json::json!({"name": "empty"}));
    assert_eq!(load_json(&file).description.placements.len(), 1);
    file["accessors"][0]["count"] = 3.5.into();
    assert!(ergodic_assets::from_bytes(file.to_string().as_bytes(), "test").is_err());
}
