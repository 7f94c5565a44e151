//! Geometry compressed by Draco and by meshopt: what was put in comes out, and damage is an error.

use std::time::{Duration, Instant};

use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, FaceIndex, GeometryAttributeType, MeshEncoder, PointAttribute, PointIndex,
};
use ergodic_assets::Trouble;
use glam::{DVec2, DVec3};
use serde_json::{Value, json};

use crate::support::{Buffer, load, next, try_load};

type Damage = fn(&mut Value);

/// Squares along a side of the grid that is compressed.
const SIDE: u32 = 8;

/// The vertices of a curved grid and its triangles.
fn grid() -> (Vec<DVec3>, Vec<DVec2>, Vec<[u32; 3]>) {
    let mut positions = Vec::new();
    let mut texcoords = Vec::new();
    let mut triangles = Vec::new();
    for y in 0..=SIDE {
        for x in 0..=SIDE {
            let [u, v] = [x, y].map(|i| f64::from(i) / f64::from(SIDE));
            positions.push(DVec3::new(u, v, 0.5 * u * v));
            texcoords.push(DVec2::new(u, 1.0 - v));
            if x < SIDE && y < SIDE {
                let i = y * (SIDE + 1) + x;
                triangles.extend([[i, i + 1, i + SIDE + 2], [i, i + SIDE + 2, i + SIDE + 1]]);
            }
        }
    }
    (positions, texcoords, triangles)
}

fn little_endian(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|v| (*v as f32).to_le_bytes()).collect()
}

/// The grid compressed by Draco at a speed from 0 to 10, which chooses the method.
fn draco(speed: i32) -> Vec<u8> {
    let (positions, texcoords, triangles) = grid();
    let mut mesh = draco_core::Mesh::new();
    let mut add = |kind, components: u8, bytes: &[u8]| {
        let mut attribute = PointAttribute::new();
        attribute.init(kind, components, DataType::Float32, false, positions.len());
        attribute.buffer_mut().write(0, bytes);
        mesh.add_attribute(attribute);
    };
    let flat: Vec<f64> = positions.iter().flat_map(|p| p.to_array()).collect();
    add(GeometryAttributeType::Position, 3, &little_endian(&flat));
    let flat: Vec<f64> = texcoords.iter().flat_map(|p| p.to_array()).collect();
    add(GeometryAttributeType::TexCoord, 2, &little_endian(&flat));
    mesh.set_num_faces(triangles.len());
    for (i, triangle) in triangles.iter().enumerate() {
        mesh.set_face(FaceIndex(i as u32), triangle.map(PointIndex));
    }
    let mut options = EncoderOptions::new();
    options.set_global_int("encoding_speed", speed);
    options.set_global_int("decoding_speed", speed);
    let mut encoder = MeshEncoder::new();
    encoder.set_mesh(mesh);
    let mut bytes = EncoderBuffer::new();
    encoder.encode(&options, &mut bytes).expect("a grid can be encoded");
    bytes.data().to_vec()
}

fn with_draco(bytes: &[u8]) -> Value {
    let mut buffer = Buffer::default();
    buffer.push(bytes);
    let (count, indices) = ((SIDE + 1).pow(2), 6 * SIDE * SIDE);
    buffer.finish(json!({
        "asset": {"version": "2.0"},
        "extensionsRequired": ["KHR_draco_mesh_compression"],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "TEXCOORD_0": 1},
            "indices": 2,
            "extensions": {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0, "TEXCOORD_0": 1}}},
        }]}],
        "accessors": [
            {"componentType": 5126, "count": count, "type": "VEC3"},
            {"componentType": 5126, "count": count, "type": "VEC2"},
            {"componentType": 5123, "count": indices, "type": "SCALAR"},
        ],
    }))
}

/// The triangles of a mesh as corners with all they have, in an order of their own.
fn corners(positions: &[DVec3], texcoords: &[DVec2], triangles: &[[u32; 3]]) -> Vec<[[i64; 5]; 3]> {
    let corner = |&i: &u32| {
        let (p, t) = (positions[i as usize], texcoords[i as usize]);
        // To a multiple of a 64th: coarser than Draco's grid, finer than ours.
        [p.x, p.y, p.z, t.x, t.y].map(|v| (v * 64.0).round() as i64)
    };
    let mut list: Vec<[[i64; 5]; 3]> = triangles.iter().map(|t| t.each_ref().map(corner)).collect();
    for triangle in &mut list {
        let least = (0..3).min_by_key(|&i| triangle[i]).unwrap_or(0);
        triangle.rotate_left(least);
    }
    list.sort_unstable();
    list
}

#[test]
fn draco_gives_back_the_mesh_by_every_method() {
    let (positions, texcoords, triangles) = grid();
    let expected = corners(&positions, &texcoords, &triangles);
    for speed in [0, 3, 5, 7, 10] {
        let asset = load(&with_draco(&draco(speed)));
        let mesh = &asset.description.meshes[0];
        let found = corners(&mesh.positions, mesh.texcoords[0].as_ref().unwrap(), &mesh.triangles);
        assert_eq!(found, expected, "speed {speed}");
        assert!(asset.warnings.is_empty(), "{:?}", asset.warnings);
    }
}

#[test]
fn what_draco_data_cannot_be_is_named() {
    let broken: [(Damage, &str); 3] = [
        (|e| e["bufferView"] = 7.into(), ".bufferView"),
        (|e| e["attributes"]["POSITION"] = 9.into(), ".attributes.POSITION"),
        (|e| e["attributes"]["POSITION"] = 1.into(), ".attributes.POSITION"),
    ];
    let bytes = draco(5);
    for (damage, place) in broken {
        let mut file = with_draco(&bytes);
        let primitive = &mut file["meshes"][0]["primitives"][0];
        damage(&mut primitive["extensions"]["KHR_draco_mesh_compression"]);
        let error = try_load(&file).unwrap_err();
        let expected = format!("meshes[0].primitives[0].extensions.KHR_draco_mesh_compression{place}");
        assert_eq!(error.place, expected, "{error}");
    }
    let error = try_load(&with_draco(&bytes[..bytes.len() / 2])).unwrap_err();
    assert!(error.problem.contains("cannot be decoded") && error.trouble == Trouble::Malformed, "{error}");
}

/// Attributes in version 0 of the codec, all groups of whole bytes, or in version 1, all columns literal.
fn attributes(data: &[u8], stride: usize, version: u8) -> Vec<u8> {
    let mut stream = vec![0xa0 + version];
    let mut last = vec![0; stride];
    let elements: Vec<&[u8]> = data.chunks(stride).collect();
    for block in elements.chunks(((8192 / stride) & !15).min(256)) {
        if version == 1 {
            stream.extend(std::iter::repeat_n(0xff, stride / 4));
        }
        for position in 0..stride {
            let mut column = Vec::new();
            for element in block {
                let delta = element[position].wrapping_sub(last[position]);
                column.push(if delta & 0x80 == 0 { delta << 1 } else { !(delta << 1) });
                last[position] = element[position];
            }
            if version == 0 {
                let groups = column.len().div_ceil(16);
                stream.extend(std::iter::repeat_n(0xff, groups.div_ceil(4)));
                column.resize(16 * groups, 0);
            }
            stream.extend(column);
        }
    }
    let modes = if version == 0 { 0 } else { stride / 4 };
    let least: usize = if version == 0 { 32 } else { 24 };
    stream.resize(stream.len() + (stride + modes).max(least), 0);
    stream
}

/// Indices by mode 2, all from the first baseline.
fn sequence(indices: &[u32]) -> Vec<u8> {
    let mut stream = vec![0xd1];
    let mut last = 0u32;
    for &index in indices {
        let delta = index.wrapping_sub(last) as i32;
        let mut value = ((delta << 1 ^ delta >> 31) as u32) << 1;
        last = index;
        while value >= 0x80 {
            stream.push(value as u8 | 0x80);
            value >>= 7;
        }
        stream.push(value as u8);
    }
    stream.extend([0; 4]);
    stream
}

/// The grid with 16-bit positions, octahedral normals (all along +z) and indices, each in a compressed view.
fn with_meshopt(name: &str, version: u8) -> Value {
    let (positions, _, triangles) = grid();
    let count = positions.len();
    let stored = |p: &DVec3| [p.x, p.y, p.z, 0.0].map(|v| (v * 65_535.0).round() as u16);
    let shorts: Vec<u8> = positions.iter().flat_map(stored).flat_map(u16::to_le_bytes).collect();
    let mut buffer = Buffer::default();
    let mut views = Vec::new();
    let mut add = |bytes: Vec<u8>, stride: usize, count: usize, mode: &str, filter: &str| {
        let place = buffer.push(&bytes);
        views.push((place, stride, count, mode.to_string(), filter.to_string(), bytes.len()));
    };
    add(attributes(&shorts, 8, version), 8, count, "ATTRIBUTES", "NONE");
    add(attributes(&[0, 0, 127, 0].repeat(count), 4, version), 4, count, "ATTRIBUTES", "OCTAHEDRAL");
    add(sequence(triangles.as_flattened()), 2, 3 * triangles.len(), "INDICES", "NONE");
    let mut file = buffer.finish(json!({
        "asset": {"version": "2.0"},
        "extensionsRequired": [name, "KHR_mesh_quantization"],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5123, "normalized": true, "count": count, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5120, "normalized": true, "count": count, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5123, "count": 3 * triangles.len(), "type": "SCALAR"},
        ],
    }));
    let fallback = json!({"byteLength": 1 << 20, "extensions": {name: {"fallback": true}}});
    file["buffers"].as_array_mut().expect("a list").push(fallback);
    for (place, stride, count, mode, filter, length) in views {
        let view = &mut file["bufferViews"][place];
        let offset = view["byteOffset"].take();
        let extension = json!({
            "buffer": 0, "byteOffset": offset, "byteLength": length,
            "byteStride": stride, "count": count, "mode": mode, "filter": filter,
        });
        *view = json!({"buffer": 1, "byteLength": stride * count, "extensions": {name: extension}});
        if mode == "ATTRIBUTES" {
            view["byteStride"] = stride.into();
        }
    }
    file
}

#[test]
fn meshopt_gives_back_the_mesh_by_both_names_and_versions() {
    let (positions, _, triangles) = grid();
    for (name, version) in
        [("EXT_meshopt_compression", 0), ("KHR_meshopt_compression", 0), ("KHR_meshopt_compression", 1)]
    {
        let asset = load(&with_meshopt(name, version));
        let mesh = &asset.description.meshes[0];
        assert!(mesh.positions.iter().zip(&positions).all(|(a, b)| (*a - *b).length() < 1e-4), "{name} {version}");
        assert!(mesh.normals.as_ref().unwrap().iter().all(|n| *n == DVec3::Z), "{name} {version}");
        assert_eq!(mesh.triangles, triangles);
        assert!(asset.warnings.is_empty(), "{:?}", asset.warnings);
    }
}

#[test]
fn what_meshopt_data_cannot_be_is_named() {
    let broken: [(Damage, &str); 9] = [
        (|e| e["mode"] = "TRIANGLE".into(), ""),
        (|e| e["filter"] = "QUATERNION".into(), ""),
        (|e| e["byteStride"] = 6.into(), ""),
        (|e| e["byteStride"] = 0.into(), ""),
        (|e| e["count"] = 7.into(), ""),
        (|e| e["count"] = (u64::MAX / 2).into(), ""),
        (|e| e["buffer"] = 5.into(), ".buffer"),
        (|e| e["byteLength"] = 1.into(), ""),
        (|e| e["byteOffset"] = u64::MAX.into(), ""),
    ];
    for (damage, place) in broken {
        let mut file = with_meshopt("EXT_meshopt_compression", 0);
        let extension = &mut file["bufferViews"][1]["extensions"]["EXT_meshopt_compression"];
        damage(extension);
        let error = try_load(&file).unwrap_err();
        assert_eq!(error.place, format!("bufferViews[1].extensions.EXT_meshopt_compression{place}"), "{error}");
    }
}

#[test]
fn a_stream_cannot_announce_more_than_it_holds() {
    let mut file = with_meshopt("KHR_meshopt_compression", 1);
    let count = 1u64 << 28;
    file["bufferViews"][0]["byteLength"] = (8 * count).into();
    file["bufferViews"][0]["extensions"]["KHR_meshopt_compression"]["count"] = count.into();
    file["accessors"][0]["count"] = count.into();
    let start = Instant::now();
    assert!(try_load(&file).unwrap_err().problem.contains("ends before"));
    assert!(start.elapsed() < Duration::from_secs(1));
}

/// Damages the first `reach` bytes of the only buffer with bytes and counts how many files still load.
fn damage(file: &Value, rounds: usize, state: &mut u64) -> usize {
    use base64::Engine;
    let base64 = base64::engine::general_purpose::STANDARD;
    let uri = file["buffers"][0]["uri"].as_str().expect("the buffer has a URI");
    let (header, body) = uri.split_once(',').expect("the URI has data");
    let whole = base64.decode(body).expect("the data are base64");
    let mut file = file.clone();
    let mut loaded = 0;
    for round in 0..rounds {
        let mut bytes = whole.clone();
        for _ in 0..=next(state) % 3 {
            let at = next(state) % bytes.len();
            bytes[at] =
                if next(state).is_multiple_of(2) { bytes[at] ^ 1 << (next(state) % 8) } else { next(state) as u8 };
        }
        file["buffers"][0]["uri"] = format!("{header},{}", base64.encode(&bytes)).into();
        let start = Instant::now();
        loaded += usize::from(try_load(&file).is_ok());
        assert!(start.elapsed() < Duration::from_secs(5), "round {round}");
    }
    loaded
}

#[test]
fn random_damage_to_compressed_data_never_panics_or_hangs() {
    let rounds = 1500;
    let mut state = 3;
    let files = [with_draco(&draco(0)), with_draco(&draco(5)), with_draco(&draco(10))];
    let draco: usize = files.iter().map(|file| damage(file, rounds, &mut state)).sum();
    let names = [("EXT_meshopt_compression", 0), ("KHR_meshopt_compression", 1)];
    let meshopt: usize = names.iter().map(|(name, v)| damage(&with_meshopt(name, *v), rounds, &mut state)).sum();
    // Neither does all damage break a file nor none.
    assert!((1..3 * rounds).contains(&draco) && (1..2 * rounds).contains(&meshopt), "{draco}, {meshopt}");
}
