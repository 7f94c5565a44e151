//! Images of other formats than PNG and JPEG.

use base64::Engine;
use ergodic_assets::Trouble;
use serde_json::{Value, json};

use crate::support::{Buffer, load, png, triangle, try_load};

/// A lossy WebP of 16 x 16 pixels with alpha: the left half (200, 40, 40, 255), the right half (40, 40, 200, 64).
const WEBP: &str = "UklGRm4AAABXRUJQVlA4WAoAAAAQAAAADwAADwAAQUxQSBMAAAABD/Cg/4iIIBZM5i/dnUFE/0MXAFZQOCA0AAAAkAEAnQEqEAAQAADAEiWgAnS6AAOY\
                    AP76zH//JRy/9GH/9qWf+GH/7Us//allw//aljugAA==";

/// A triangle with one texture.
fn textured(texture: Value, images: Value) -> Value {
    let mut file = triangle();
    file["meshes"][0]["primitives"][0]["material"] = 0.into();
    file["materials"] = json!([{"pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}}}]);
    file["textures"] = json!([texture]);
    file["images"] = images;
    file
}

fn data(mime: &str, base64: &str) -> Value {
    json!({"uri": format!("data:{mime};base64,{base64}")})
}

fn one_texel() -> Value {
    data("image/png", &base64::engine::general_purpose::STANDARD.encode(png(&[[255, 0, 0, 255]])))
}

#[test]
fn lossy_webp_with_alpha_is_read_and_goes_before_its_fallback() {
    let texture = json!({"source": 0, "extensions": {"EXT_texture_webp": {"source": 1}}});
    let mut file = textured(texture, json!([one_texel(), data("image/webp", WEBP)]));
    file["extensionsRequired"] = json!(["EXT_texture_webp"]);
    let asset = load(&file);
    let texture = &asset.description.textures[0];
    assert_eq!((texture.width, texture.height), (16, 16));
    for (u, expected) in [(0.25, [200.0, 40.0, 40.0, 255.0]), (0.75, [40.0, 40.0, 200.0, 64.0])] {
        let read = texture.lookup(glam::DVec2::new(u, 0.5)).to_array();
        let close = read.iter().zip(expected).all(|(a, b): (&f64, f64)| (a * 255.0 - b).abs() <= 3.0);
        assert!(close, "{read:?}");
    }
    assert!(asset.warnings.is_empty(), "{:?}", asset.warnings);
}

#[test]
fn a_texture_that_cannot_be_read_is_named_with_its_format_and_a_mend() {
    let basis = json!({"extensions": {"KHR_texture_basisu": {"source": 0}}});
    let mut file = textured(basis, json!([data("image/ktx2", "q0tUWCAyMLsNChoK")]));
    for required in [false, true] {
        if required {
            file["extensionsRequired"] = json!(["KHR_texture_basisu"]);
        }
        let error = try_load(&file).unwrap_err();
        assert_eq!((error.trouble, error.place.as_str()), (Trouble::Unsupported, "textures[0]"));
        assert!(error.problem.contains("KHR_texture_basisu") && error.mend.contains("PNG"), "{error}");
    }
    // With another image beside it, that is shown, and the extension is named.
    let basis = json!({"source": 0, "extensions": {"KHR_texture_basisu": {"source": 1}}});
    let mut file = textured(basis, json!([one_texel(), data("image/ktx2", "q0tUWCAyMLsNChoK")]));
    file["extensionsUsed"] = json!(["KHR_texture_basisu"]);
    let asset = load(&file);
    assert_eq!(asset.description.textures[0].width, 1);
    assert!(asset.warnings[0].starts_with("KHR_texture_basisu"), "{:?}", asset.warnings);
}

#[test]
fn transforms_reach_every_texture_of_a_material() {
    // A view of a material with a texture in each place that the loader reads, all with one transform.
    let transform = json!({"KHR_texture_transform": {"offset": [0.25, 0.5]}});
    let info = json!({"index": 0, "extensions": transform});
    let mut file = textured(json!({"source": 0}), json!([one_texel()]));
    file["materials"] = json!([{
        "pbrMetallicRoughness": {"baseColorTexture": info, "metallicRoughnessTexture": info},
        "normalTexture": info,
        "emissiveTexture": info,
        "extensions": {
            "KHR_materials_specular": {"specularTexture": info, "specularColorTexture": info},
            "KHR_materials_transmission": {"transmissionTexture": info},
        },
    }]);
    let asset = load(&file);
    let material = &asset.description.materials[0];
    let used = [
        material.base_color_texture,
        material.metallic_roughness_texture,
        material.normal_texture,
        material.emission_texture,
        material.specular_texture,
        material.specular_color_texture,
        material.transmission_texture,
    ];
    for (i, texture) in used.into_iter().enumerate() {
        let moved = texture.unwrap().transform.transform_point2(glam::DVec2::ZERO);
        assert_eq!(moved, glam::DVec2::new(0.25, 0.5), "texture {i}");
    }
}

/// Texture coordinates, normals and tangents as integers of every kind that KHR_mesh_quantization allows.
#[test]
fn quantized_attributes_of_every_type_are_read() {
    let bytes = |values: [f64; 9], kind: u32, normalized: bool| -> Vec<u8> {
        let stored = |v: f64, most: f64| (v * if normalized { most } else { 1.0 }).round();
        let store = |v: &f64| -> Vec<u8> {
            match kind {
                5120 => (stored(*v, 127.0) as i8).to_le_bytes().to_vec(),
                5121 => (stored(*v, 255.0) as u8).to_le_bytes().to_vec(),
                5122 => (stored(*v, 32_767.0) as i16).to_le_bytes().to_vec(),
                _ => (stored(*v, 65_535.0) as u16).to_le_bytes().to_vec(),
            }
        };
        values.iter().flat_map(store).collect()
    };
    let corners = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    for kind in [5120, 5121, 5122, 5123] {
        for normalized in [false, true] {
            let mut buffer = Buffer::default();
            buffer.push(&bytes(corners, kind, normalized));
            // As texture coordinates the same bytes are read two by two.
            let accessor = |count: u32, shape: &str| json!({"bufferView": 0, "componentType": kind, "normalized": normalized, "count": count, "type": shape});
            let file = buffer.finish(json!({
                "asset": {"version": "2.0"},
                "extensionsRequired": ["KHR_mesh_quantization"],
                "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 0, "TEXCOORD_0": 1}}]}],
                "accessors": [accessor(3, "VEC3"), accessor(3, "VEC2")],
            }));
            let mesh = &load(&file).description.meshes[0];
            assert_eq!(mesh.positions, [glam::DVec3::ZERO, glam::DVec3::X, glam::DVec3::Y], "{kind} {normalized}");
            assert_eq!(mesh.normals.as_ref().unwrap()[1], glam::DVec3::X, "{kind} {normalized}");
            assert_eq!(mesh.texcoords[0].as_ref().unwrap()[1], glam::DVec2::Y, "{kind} {normalized}");
        }
    }
}
