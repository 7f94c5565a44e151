//! A triangle with a material, and one with a texture.

use serde_json::json;

use crate::support::{Buffer, TRIANGLE, png, triangle};

/// A triangle with this material.
pub fn with_material(material: serde_json::Value) -> serde_json::Value {
    let mut file = triangle();
    file["meshes"][0]["primitives"][0]["material"] = 0.into();
    file["materials"] = json!([material]);
    file
}

/// A triangle with the texture coordinates of its corners equal to their position, and one texture of two texels.
pub fn textured(material: serde_json::Value, sampler: serde_json::Value, second_set: bool) -> serde_json::Value {
    let mut buffer = Buffer::default();
    buffer.floats(&TRIANGLE);
    buffer.floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    buffer.push(&png(&[[188, 0, 255, 51], [0, 255, 0, 255]]));
    let set = if second_set { "TEXCOORD_1" } else { "TEXCOORD_0" };
    buffer.finish(json!({
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, set: 1}, "material": 0}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"},
        ],
        "materials": [material],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [sampler],
        "images": [{"bufferView": 2, "mimeType": "image/png"}],
    }))
}
