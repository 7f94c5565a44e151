//! Primitives: modes, indices, quantized and sparse accessors, strides, tangents.

use glam::{DVec2, DVec3, DVec4};
use serde_json::json;

use crate::support::{Buffer, TRIANGLE, load, triangle, try_load, with_primitive};

const SQUARE: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];

fn square(primitive: serde_json::Value, order: &[u16]) -> serde_json::Value {
    let mut buffer = Buffer::default();
    buffer.floats(&SQUARE);
    buffer.shorts(order);
    let accessors = json!([
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5123, "count": order.len(), "type": "SCALAR"},
    ]);
    with_primitive(buffer, accessors, primitive)
}

#[test]
fn triangles_come_with_and_without_indices() {
    let mesh = &load(&triangle()).description.meshes[0];
    assert_eq!(mesh.positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    assert!(mesh.normals.is_none());

    let indexed = square(json!({"attributes": {"POSITION": 0}, "indices": 1}), &[0, 1, 2, 0, 2, 3]);
    assert_eq!(load(&indexed).description.meshes[0].triangles, [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn strips_and_fans_keep_the_front_in_front() {
    let strip = square(json!({"attributes": {"POSITION": 0}, "indices": 1, "mode": 5}), &[0, 1, 3, 2]);
    let fan = square(json!({"attributes": {"POSITION": 0}, "indices": 1, "mode": 6}), &[0, 1, 2, 3]);
    for file in [strip, fan] {
        let mesh = &load(&file).description.meshes[0];
        assert_eq!(mesh.triangles.len(), 2);
        for &[a, b, c] in &mesh.triangles {
            let [a, b, c] = [a, b, c].map(|i| mesh.positions[i as usize]);
            assert_eq!((b - a).cross(c - a), DVec3::Z);
        }
    }
}

#[test]
fn lines_and_incomplete_triangles_are_left_out_with_a_warning() {
    let lines = load(&square(json!({"attributes": {"POSITION": 0}, "indices": 1, "mode": 1}), &[0, 1]));
    assert!(lines.description.meshes.is_empty() && lines.warnings[0].contains("lines"), "{:?}", lines.warnings);
    let five = load(&square(json!({"attributes": {"POSITION": 0}, "indices": 1}), &[0, 1, 2, 0, 2]));
    assert_eq!(five.description.meshes[0].triangles, [[0, 1, 2]]);
    assert!(five.warnings[0].contains("incomplete"), "{:?}", five.warnings);
}

#[test]
fn integers_are_dequantized_as_the_specification_says() {
    // Positions as plain 16-bit integers, normals and colours normalized; a stride of 8 for 6 bytes.
    let mut buffer = Buffer::default();
    let positions: [i16; 12] = [0, 0, 0, 99, 300, 0, 0, 99, 0, -5, 0, 99];
    buffer.push(&positions.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>());
    buffer.push(&[0, 0, 127, 0, 0, 0, 0x81, 0, 0x80, 0, 0, 0]);
    buffer.push(&[255, 0, 51, 0, 255, 0, 255, 255, 0, 0, 0, 0]);
    let accessors = json!([
        {"bufferView": 0, "componentType": 5122, "count": 3, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5120, "normalized": true, "count": 3, "type": "VEC3"},
        {"bufferView": 2, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC4"},
    ]);
    let attributes = json!({"POSITION": 0, "NORMAL": 1, "COLOR_0": 2});
    let mut file = with_primitive(buffer, accessors, json!({"attributes": attributes}));
    file["bufferViews"][0]["byteStride"] = 8.into();
    file["bufferViews"][1]["byteStride"] = 4.into();
    file["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    file["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    let asset = load(&file);
    let mesh = &asset.description.meshes[0];
    assert_eq!(mesh.positions[1], DVec3::new(300.0, 0.0, 0.0));
    assert_eq!(mesh.positions[2], DVec3::new(0.0, -5.0, 0.0));
    // -128 and -127 both stand for -1.
    assert_eq!(mesh.normals.as_ref().unwrap()[..], [DVec3::Z, DVec3::NEG_Z, DVec3::NEG_X]);
    assert_eq!(mesh.colors.as_ref().unwrap()[0], DVec4::new(1.0, 0.0, 0.2, 0.0));
    assert!(asset.warnings.is_empty(), "{:?}", asset.warnings);
}

#[test]
fn sparse_accessors_replace_what_lies_below_or_zeros() {
    for dense in [true, false] {
        let mut buffer = Buffer::default();
        buffer.floats(&TRIANGLE);
        buffer.push(&[1, 2]);
        buffer.floats(&[7.0, 8.0, 9.0, 4.0, 5.0, 6.0]);
        let sparse = json!({
            "count": 2,
            "indices": {"bufferView": 1, "componentType": 5121},
            "values": {"bufferView": 2},
        });
        let mut accessor = json!({"componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse});
        if dense {
            accessor["bufferView"] = 0.into();
        }
        let file = with_primitive(buffer, json!([accessor]), json!({"attributes": {"POSITION": 0}}));
        let expected = [DVec3::ZERO, DVec3::new(7.0, 8.0, 9.0), DVec3::new(4.0, 5.0, 6.0)];
        assert_eq!(load(&file).description.meshes[0].positions, expected);
    }
}

#[test]
fn indices_are_of_any_size_and_may_be_sparse() {
    let order = [0u8, 1, 2, 0, 2, 3];
    for (kind, size) in [(5121, 1), (5123, 2), (5125, 4)] {
        for sparse in [false, true] {
            let stored: Vec<u8> =
                order.iter().flat_map(|&i| u32::from(i).to_le_bytes().into_iter().take(size)).collect();
            let mut buffer = Buffer::default();
            buffer.floats(&SQUARE);
            buffer.push(&stored);
            buffer.push(&[0, 1, 2, 3, 4, 5]);
            let mut indices = json!({"componentType": kind, "count": 6, "type": "SCALAR"});
            if sparse {
                // All zeros below.
                let at = json!({"bufferView": 2, "componentType": 5121});
                indices["sparse"] = json!({"count": 6, "indices": at, "values": {"bufferView": 1}});
            } else {
                indices["bufferView"] = 1.into();
            }
            let positions = json!({"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"});
            let primitive = json!({"attributes": {"POSITION": 0}, "indices": 1});
            let file = with_primitive(buffer, json!([positions, indices]), primitive);
            let found = &load(&file).description.meshes[0].triangles;
            assert_eq!(found[..], [[0, 1, 2], [0, 2, 3]], "{kind} {sparse}");
        }
    }
}

#[test]
fn a_sparse_index_beyond_the_end_is_an_error() {
    let mut buffer = Buffer::default();
    buffer.push(&[3]);
    buffer.floats(&[7.0, 8.0, 9.0]);
    let sparse = json!({"count": 1, "indices": {"bufferView": 0, "componentType": 5121}, "values": {"bufferView": 1}});
    let accessor = json!({"componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse});
    let file = with_primitive(buffer, json!([accessor]), json!({"attributes": {"POSITION": 0}}));
    let error = try_load(&file).unwrap_err();
    assert_eq!(error.place, "accessors[0].sparse");
}

/// A square with a normal map, its texture coordinates turned by a quarter: u runs along +y.
fn square_with_normal_map(normals: bool) -> serde_json::Value {
    let mut buffer = Buffer::default();
    buffer.floats(&SQUARE);
    buffer.shorts(&[0, 1, 2, 0, 2, 3]);
    buffer.floats(&[0.0, 0.0, 0.0, -1.0, 1.0, -1.0, 1.0, 0.0].map(|v: f32| v));
    buffer.floats(&[0.0, 0.0, 1.0].repeat(4));
    let image = buffer.push(&crate::support::png(&[[128, 128, 255, 255]]));
    let accessors = json!([
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"},
        {"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC3"},
    ]);
    let mut attributes = json!({"POSITION": 0, "TEXCOORD_0": 2});
    if normals {
        attributes["NORMAL"] = 3.into();
    }
    let mut file = with_primitive(buffer, accessors, json!({"attributes": attributes, "indices": 1, "material": 0}));
    file["materials"] = json!([{"normalTexture": {"index": 0}}]);
    file["textures"] = json!([{"source": 0}]);
    file["images"] = json!([{"bufferView": image, "mimeType": "image/png"}]);
    file
}

#[test]
fn tangents_are_made_where_a_normal_map_needs_them() {
    for normals in [true, false] {
        let asset = load(&square_with_normal_map(normals));
        let mesh = &asset.description.meshes[0];
        assert_eq!(mesh.triangles.len(), 2);
        let (tangents, texcoords) = (mesh.tangents.as_ref().unwrap(), mesh.texcoords[0].as_ref().unwrap());
        for &[a, b, c] in &mesh.triangles {
            let [a, b, c] = [a, b, c].map(|i| i as usize);
            // Position as a linear function of u and v: the tangent is its derivative along u, and the bitangent points
            // along -v, because MikkTSpace has v upwards.
            let (e1, e2) = (mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
            let (d1, d2): (DVec2, DVec2) = (texcoords[b] - texcoords[a], texcoords[c] - texcoords[a]);
            let determinant = d1.perp_dot(d2);
            let along_u = (e1 * d2.y - e2 * d1.y) / determinant;
            let along_v = (e2 * d1.x - e1 * d2.x) / determinant;
            for corner in [a, b, c] {
                let tangent = tangents[corner];
                assert!((tangent.truncate() - along_u.normalize()).length() < 1e-6, "{tangent}");
                let normal = mesh.normals.as_ref().unwrap()[corner];
                assert_eq!(normal, DVec3::Z);
                let bitangent = normal.cross(tangent.truncate()) * tangent.w;
                assert!((bitangent + along_v.normalize()).length() < 1e-6, "{bitangent}");
            }
        }
    }
}
