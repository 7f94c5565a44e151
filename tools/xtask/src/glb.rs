//! A small writer of binary glTF 2.0: what the scenes need and no more.

use glam::DVec3;
use serde_json::{Map, Value, json};

use crate::shapes::Shape;

/// A material. Colours are linear.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name in the file.
    pub name: &'static str,
    /// Base colour.
    pub color: [f64; 3],
    /// 0 or 1.
    pub metallic: f64,
    /// glTF roughness; alpha of GGX is its square.
    pub roughness: f64,
    /// KHR_materials_specular: 0 for a pure Lambertian surface.
    pub specular: f64,
    /// Emitted radiance.
    pub radiance: Option<[f64; 3]>,
    /// A clear refracting solid.
    pub solid: Option<Solid>,
}

/// What fills a refracting solid.
#[derive(Clone, Copy, Debug)]
pub struct Solid {
    /// Index of refraction.
    pub ior: f64,
    /// Colour of white light after `attenuation_distance` metres.
    pub attenuation_color: [f64; 3],
    /// Metres.
    pub attenuation_distance: f64,
}

impl Material {
    /// A Lambertian surface.
    pub fn diffuse(name: &'static str, color: [f64; 3]) -> Self {
        Self { name, color, metallic: 0.0, roughness: 1.0, specular: 0.0, radiance: None, solid: None }
    }

    /// A black surface that emits from its front.
    pub fn lamp(name: &'static str, radiance: [f64; 3]) -> Self {
        Self { radiance: Some(radiance), ..Self::diffuse(name, [0.0; 3]) }
    }

    /// A diffuse base under a dielectric surface.
    pub fn glossy(name: &'static str, color: [f64; 3], roughness: f64) -> Self {
        Self { roughness, specular: 1.0, ..Self::diffuse(name, color) }
    }

    /// A metal.
    pub fn metal(name: &'static str, color: [f64; 3], roughness: f64) -> Self {
        Self { metallic: 1.0, roughness, specular: 1.0, ..Self::diffuse(name, color) }
    }

    /// A perfectly smooth refracting solid.
    pub fn solid(name: &'static str, solid: Solid) -> Self {
        Self { roughness: 0.0, specular: 1.0, solid: Some(solid), ..Self::diffuse(name, [1.0; 3]) }
    }

    fn to_json(&self) -> Value {
        let [r, g, b] = self.color;
        let mut extensions = Map::new();
        if self.specular != 1.0 {
            extensions.insert("KHR_materials_specular".into(), json!({ "specularFactor": self.specular }));
        }
        if let Some(solid) = self.solid {
            extensions.insert("KHR_materials_transmission".into(), json!({ "transmissionFactor": 1.0 }));
            extensions.insert("KHR_materials_ior".into(), json!({ "ior": solid.ior }));
            extensions.insert(
                "KHR_materials_volume".into(),
                json!({
                    "thicknessFactor": 1.0,
                    "attenuationColor": solid.attenuation_color,
                    "attenuationDistance": solid.attenuation_distance,
                }),
            );
        }
        let mut material = json!({
            "name": self.name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [r, g, b, 1.0],
                "metallicFactor": self.metallic,
                "roughnessFactor": self.roughness,
            },
        });
        if let Some(radiance) = self.radiance {
            // emissiveFactor must not exceed 1; the strength carries the rest.
            let strength = radiance.iter().fold(0.0, |max: f64, c| max.max(*c));
            material["emissiveFactor"] = json!(radiance.map(|c| c / strength));
            extensions.insert("KHR_materials_emissive_strength".into(), json!({ "emissiveStrength": strength }));
        }
        if !extensions.is_empty() {
            material["extensions"] = Value::Object(extensions);
        }
        material
    }
}

/// A scene under way.
#[derive(Clone, Debug, Default)]
pub struct Document {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    nodes: Vec<Value>,
    cameras: Vec<Value>,
}

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;

impl Document {
    fn accessor(
        &mut self,
        bytes: &[u8],
        count: usize,
        component: u32,
        kind: &str,
        bounds: Option<[DVec3; 2]>,
    ) -> usize {
        self.views.push(json!({ "buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len() }));
        self.binary.extend_from_slice(bytes);
        let mut accessor =
            json!({ "bufferView": self.views.len() - 1, "componentType": component, "count": count, "type": kind });
        if let Some([low, high]) = bounds {
            // The bounds of the rounded values, as the specification asks.
            accessor["min"] = json!(low.as_vec3().to_array());
            accessor["max"] = json!(high.as_vec3().to_array());
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn vectors(&mut self, vectors: &[DVec3], with_bounds: bool) -> usize {
        let bytes: Vec<u8> = vectors.iter().flat_map(|v| v.as_vec3().to_array()).flat_map(f32::to_le_bytes).collect();
        let bounds = with_bounds.then(|| {
            let low = vectors.iter().copied().fold(DVec3::INFINITY, DVec3::min);
            [low, vectors.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max)]
        });
        self.accessor(&bytes, vectors.len(), FLOAT, "VEC3", bounds)
    }

    /// Adds a material.
    pub fn material(&mut self, material: &Material) -> usize {
        self.materials.push(material.to_json());
        self.materials.len() - 1
    }

    /// Adds a shape as a node of its own.
    pub fn shape(&mut self, name: &str, shape: &Shape, material: usize) {
        let positions = self.vectors(&shape.positions, true);
        let normals = self.vectors(&shape.normals, false);
        let bytes: Vec<u8> = shape.triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        let indices = self.accessor(&bytes, shape.triangles.len() * 3, UNSIGNED_INT, "SCALAR", None);
        self.meshes.push(json!({
            "name": name,
            "primitives": [{
                "attributes": { "POSITION": positions, "NORMAL": normals },
                "indices": indices,
                "material": material,
            }],
        }));
        self.nodes.push(json!({ "name": name, "mesh": self.meshes.len() - 1 }));
    }

    /// Adds a camera that looks from `eye` to `target`, `vertical_fov` in degrees.
    pub fn camera(&mut self, eye: DVec3, target: DVec3, vertical_fov: f64) {
        let z = (eye - target).normalize();
        let x = DVec3::Y.cross(z).normalize();
        let y = z.cross(x);
        let column = |v: DVec3, w: f64| [v.x, v.y, v.z, w];
        let matrix = [column(x, 0.0), column(y, 0.0), column(z, 0.0), column(eye, 1.0)].concat();
        self.cameras.push(json!({
            "name": "main",
            "type": "perspective",
            "perspective": { "yfov": vertical_fov.to_radians(), "znear": 0.01 },
        }));
        self.nodes.push(json!({ "name": "camera", "camera": self.cameras.len() - 1, "matrix": matrix }));
    }

    /// The file.
    pub fn to_glb(&self) -> Vec<u8> {
        let mut extensions: Vec<&String> = self
            .materials
            .iter()
            .filter_map(|material| material["extensions"].as_object())
            .flat_map(Map::keys)
            .collect();
        extensions.sort();
        extensions.dedup();
        let document = json!({
            "asset": { "version": "2.0", "generator": "ergodic xtask" },
            "extensionsUsed": extensions,
            "scene": 0,
            "scenes": [{ "nodes": (0..self.nodes.len()).collect::<Vec<_>>() }],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
            "cameras": self.cameras,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.binary.len() }],
        });
        let mut text = document.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut binary = self.binary.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let mut file = Vec::new();
        let word = |file: &mut Vec<u8>, n: usize| file.extend_from_slice(&(n as u32).to_le_bytes());
        file.extend_from_slice(b"glTF");
        word(&mut file, 2);
        word(&mut file, 12 + 8 + text.len() + 8 + binary.len());
        word(&mut file, text.len());
        file.extend_from_slice(b"JSON");
        file.extend_from_slice(&text);
        word(&mut file, binary.len());
        file.extend_from_slice(b"BIN\0");
        file.extend_from_slice(&binary);
        file
    }
}
