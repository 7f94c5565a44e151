//! Small glTF files made in memory.

use base64::Engine;
use ergodic_assets::{Asset, AssetError, from_bytes};
use serde_json::{Value, json};

/// Collects bytes into one buffer with a view for each piece.
#[derive(Default)]
pub struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
}

impl Buffer {
    /// Adds bytes; returns the index of their view.
    pub fn push(&mut self, bytes: &[u8]) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.views.push(json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}));
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    pub fn floats(&mut self, values: &[f32]) -> usize {
        self.push(&values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>())
    }

    pub fn shorts(&mut self, values: &[u16]) -> usize {
        self.push(&values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>())
    }

    /// Puts the buffer and its views into a file.
    pub fn finish(self, mut file: Value) -> Value {
        let data = base64::engine::general_purpose::STANDARD.encode(&self.bytes);
        let uri = format!("data:application/octet-stream;base64,{data}");
        file["buffers"] = json!([{"byteLength": self.bytes.len(), "uri": uri}]);
        file["bufferViews"] = Value::Array(self.views);
        file
    }
}

/// The corners of one triangle in the plane z = 0.
pub const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// A file with one triangle at one node; its front looks along +z.
pub fn triangle() -> Value {
    let mut buffer = Buffer::default();
    buffer.floats(&TRIANGLE);
    buffer.finish(json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
    }))
}

/// A file whose only mesh has one primitive with the given members, on the given accessors.
pub fn with_primitive(buffer: Buffer, accessors: Value, primitive: Value) -> Value {
    buffer.finish(json!({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "accessors": accessors,
    }))
}

pub fn try_load(file: &Value) -> Result<Asset, AssetError> {
    from_bytes(file.to_string().as_bytes(), "test.gltf")
}

pub fn load(file: &Value) -> Asset {
    try_load(file).unwrap_or_else(|e| panic!("{e}"))
}

/// A one-row PNG of RGBA bytes.
pub fn png(texels: &[[u8; 4]]) -> Vec<u8> {
    let image = image::RgbaImage::from_raw(texels.len() as u32, 1, texels.concat()).expect("as many bytes as texels");
    let mut bytes = Vec::new();
    image.write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::Png).expect("PNG into memory");
    bytes
}

/// A generator of its own, so that the damage is the same everywhere.
pub fn next(state: &mut u64) -> usize {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 33) as usize
}
