//! Broken files: each error names its place, and nothing panics.

use std::time::{Duration, Instant};

use ergodic_assets::{Trouble, from_bytes, load};
use ergodic_pathspace::{Scene, View};
use serde_json::{Value, json};

use crate::support::{next, triangle, try_load};

type Damage = fn(&mut Value);

#[test]
fn every_error_names_the_place() {
    let cases: [(Damage, &str); 18] = [
        (|f| f["asset"] = json!({}), "asset"),
        (|f| f["asset"]["version"] = "1.0".into(), "asset.version"),
        (|f| f["asset"]["minVersion"] = "2.1".into(), "asset.version"),
        (|f| f["scene"] = 5.into(), "scene"),
        (|f| f["scenes"][0]["nodes"] = json!([7]), "scenes[0].nodes[0]"),
        (|f| f["nodes"][0]["mesh"] = 1.into(), "nodes[0].mesh"),
        (|f| f["nodes"][0]["rotation"] = json!([0, 0, 0, 0]), "nodes[0].rotation"),
        (|f| f["nodes"][0]["matrix"] = json!([1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 0, 1]), "nodes[0].matrix"),
        (|f| f["meshes"][0]["primitives"][0]["mode"] = 9.into(), "meshes[0].primitives[0].mode"),
        (|f| f["meshes"][0]["primitives"][0]["material"] = 0.into(), "meshes[0].primitives[0].material"),
        (|f| f["meshes"][0]["primitives"][0]["indices"] = 0.into(), "accessors[0].componentType"),
        (|f| f["accessors"][0]["count"] = 4.into(), "accessors[0]"),
        (|f| f["accessors"][0]["count"] = u64::MAX.into(), "accessors[0]"),
        (|f| f["accessors"][0]["count"] = (-1).into(), "accessors[0].count"),
        (|f| f["accessors"][0]["byteOffset"] = (u64::MAX - 3).into(), "accessors[0]"),
        (|f| f["accessors"][0]["type"] = "VEC2".into(), "accessors[0].type"),
        (|f| f["bufferViews"][0]["byteLength"] = u64::MAX.into(), "bufferViews[0]"),
        (|f| f["buffers"][0]["byteLength"] = 1000.into(), "buffers[0]"),
    ];
    for (damage, place) in cases {
        let mut file = triangle();
        damage(&mut file);
        let error = try_load(&file).unwrap_err();
        assert_eq!(error.place, place, "{error}");
        let text = error.to_string();
        assert!(text.starts_with(&format!("test.gltf: {place}: ")) && !error.mend.is_empty(), "{text}");
    }
}

#[test]
fn uris_are_not_trusted() {
    for (uri, trouble) in [
        ("%ff", Trouble::Malformed),
        ("", Trouble::Malformed),
        ("a%00b", Trouble::Malformed),
        ("/etc/hosts", Trouble::Malformed),
        ("https://example.org/a.bin", Trouble::Unsupported),
        ("data:nothing", Trouble::Malformed),
        ("data:;base64,****", Trouble::Malformed),
        ("missing.bin", Trouble::Unreadable),
    ] {
        let mut file = triangle();
        file["buffers"][0]["uri"] = uri.into();
        let error = try_load(&file).unwrap_err();
        assert_eq!(error.trouble, trouble, "{uri}: {error}");
    }
}

#[test]
fn an_unusable_path_is_an_error() {
    let folder = std::env::temp_dir();
    assert!(load(&folder).unwrap_err().problem.contains("folder"));
    assert!(load(&folder.join("no such scene.glb")).unwrap_err().problem.contains("cannot be read"));
    // A device never ends.
    if std::path::Path::new("/dev/zero").exists() {
        assert!(load("/dev/zero".as_ref()).unwrap_err().problem.contains("regular"));
    }
}

#[test]
fn an_accessor_without_data_cannot_exhaust_memory() {
    let mut file = triangle();
    file["accessors"][0] = json!({"componentType": 5126, "count": 4_000_000_000u32, "type": "VEC3"});
    assert_eq!(try_load(&file).unwrap_err().trouble, Trouble::TooLarge);
}

#[test]
fn an_image_larger_than_allowed_is_refused_before_it_is_decoded() {
    // The header of a PNG of 60000 x 60000 pixels, with the checksum of its first chunk.
    let mut png = b"\x89PNG\r\n\x1a\n\x00\x00\x00\x0dIHDR".to_vec();
    png.extend(60_000u32.to_be_bytes());
    png.extend(60_000u32.to_be_bytes());
    png.extend([8, 6, 0, 0, 0]);
    let crc = png[12..].iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 == 1 { (c >> 1) ^ 0xedb8_8320 } else { c >> 1 })
    });
    png.extend((!crc).to_be_bytes());
    png.extend(b"\x00\x00\x00\x00IDAT\x35\xaf\x06\x1e");
    let mut file = triangle();
    let data = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, &png);
    file["images"] = json!([{"uri": format!("data:image/png;base64,{data}")}]);
    file["textures"] = json!([{"source": 0}]);
    file["materials"] = json!([{"emissiveTexture": {"index": 0}}]);
    file["meshes"][0]["primitives"][0]["material"] = 0.into();
    let error = try_load(&file).unwrap_err();
    assert_eq!((error.trouble, error.place.as_str()), (Trouble::TooLarge, "images[0]"), "{error}");
}

#[test]
fn random_damage_never_panics_or_hangs() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut state = 1;
    let (mut refused, mut loaded) = (0, 0);
    for scene in ["cornell", "glass"] {
        let whole = std::fs::read(root.join(scene).join("scene.glb")).unwrap();
        // Most of the damage goes to the header and the JSON, where it matters.
        let json = u32::from_le_bytes(whole[12..16].try_into().unwrap()) as usize + 20;
        for round in 0..1500 {
            let mut bytes = whole.clone();
            for _ in 0..=next(&mut state) % 4 {
                let reach = if round % 8 == 0 { bytes.len() } else { json };
                let at = next(&mut state) % reach;
                bytes[at] = match next(&mut state) % 4 {
                    0 => b'0' + (next(&mut state) % 10) as u8,
                    1 => bytes[next(&mut state) % reach],
                    2 => bytes[at] ^ (1 << (next(&mut state) % 8)),
                    _ => next(&mut state) as u8,
                };
            }
            if round % 16 == 0 {
                bytes.truncate(next(&mut state) % bytes.len());
            }
            let start = Instant::now();
            match from_bytes(&bytes, "damaged.glb") {
                Ok(asset) => {
                    loaded += 1;
                    // What was let through must not break what is built from it.
                    if let Ok((camera, _)) = asset.camera("", 1.0) {
                        let view = View { camera, width: 4, height: 4, margin: 0.0, crop: None };
                        let _ = Scene::new(asset.description, &view);
                    }
                }
                Err(_) => refused += 1,
            }
            assert!(start.elapsed() < Duration::from_secs(5), "{scene}, round {round}");
        }
    }
    // The damage is neither too small to matter nor so large that only the JSON parser sees it.
    assert!(refused > 500 && loaded > 100, "{refused} refused, {loaded} loaded");
}
