//! Files on disk: buffers and images beside the scene.

use std::fs;

use base64::Engine;
use ergodic_assets::load;

use crate::support::triangle;

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
