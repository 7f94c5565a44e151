//! The material extensions that add layers and effects: clearcoat, sheen, anisotropy, iridescence, diffuse transmission.

use ergodic_scattering::{MaterialLayers, Rgb};
use gltf::json::material::NormalTexture;
use gltf::json::texture::Info;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use crate::error::Flaw;
use crate::material::Reader;
use crate::texture::Encoding;

pub(crate) const CLEARCOAT: &str = "KHR_materials_clearcoat";
pub(crate) const SHEEN: &str = "KHR_materials_sheen";
pub(crate) const ANISOTROPY: &str = "KHR_materials_anisotropy";
pub(crate) const IRIDESCENCE: &str = "KHR_materials_iridescence";
pub(crate) const DIFFUSE_TRANSMISSION: &str = "KHR_materials_diffuse_transmission";

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Clearcoat {
    clearcoat_factor: f32,
    clearcoat_texture: Option<Info>,
    clearcoat_roughness_factor: f32,
    clearcoat_roughness_texture: Option<Info>,
    clearcoat_normal_texture: Option<NormalTexture>,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Sheen {
    sheen_color_factor: [f32; 3],
    sheen_color_texture: Option<Info>,
    sheen_roughness_factor: f32,
    sheen_roughness_texture: Option<Info>,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Anisotropy {
    anisotropy_strength: f32,
    anisotropy_rotation: f32,
    anisotropy_texture: Option<Info>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Iridescence {
    iridescence_factor: f32,
    iridescence_texture: Option<Info>,
    iridescence_ior: f32,
    iridescence_thickness_minimum: f32,
    iridescence_thickness_maximum: f32,
    iridescence_thickness_texture: Option<Info>,
}

impl Default for Iridescence {
    fn default() -> Self {
        Self {
            iridescence_factor: 0.0,
            iridescence_texture: None,
            iridescence_ior: 1.3,
            iridescence_thickness_minimum: 100.0,
            iridescence_thickness_maximum: 400.0,
            iridescence_thickness_texture: None,
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct DiffuseTransmission {
    diffuse_transmission_factor: f32,
    diffuse_transmission_texture: Option<Info>,
    diffuse_transmission_color_factor: [f32; 3],
    diffuse_transmission_color_texture: Option<Info>,
}

impl Default for DiffuseTransmission {
    fn default() -> Self {
        Self {
            diffuse_transmission_factor: 0.0,
            diffuse_transmission_texture: None,
            diffuse_transmission_color_factor: [1.0; 3],
            diffuse_transmission_color_texture: None,
        }
    }
}

/// The extension `name` of a material at `place`, if it has it.
pub(crate) fn extension<T: DeserializeOwned>(
    extensions: &Map<String, Value>,
    name: &str,
    place: &str,
) -> Result<Option<T>, Flaw> {
    let Some(value) = extensions.get(name) else { return Ok(None) };
    let read = serde_path_to_error::deserialize(value.clone());
    read.map(Some).map_err(|e| {
        let inner = e.path().to_string();
        let inner = if inner == "." { String::new() } else { format!(".{inner}") };
        Flaw::malformed(format!("{place}.extensions.{name}{inner}"), e.into_inner().to_string())
    })
}

/// Reads all of them; `None` if the material has none that has an effect.
pub(crate) fn read(
    extensions: &Map<String, Value>,
    reader: &mut Reader<'_>,
) -> Result<Option<Box<MaterialLayers>>, Flaw> {
    let mut layers = MaterialLayers::default();
    let place = reader.place.clone();
    if let Some(coat) = extension::<Clearcoat>(extensions, CLEARCOAT, &place)? {
        let at = |name: &str| format!("extensions.{CLEARCOAT}.{name}");
        layers.clearcoat = reader.share(coat.clearcoat_factor, &at("clearcoatFactor"))?;
        layers.clearcoat_texture = reader.linear(coat.clearcoat_texture.as_ref(), &at("clearcoatTexture"))?;
        layers.clearcoat_roughness = reader.share(coat.clearcoat_roughness_factor, &at("clearcoatRoughnessFactor"))?;
        layers.clearcoat_roughness_texture =
            reader.linear(coat.clearcoat_roughness_texture.as_ref(), &at("clearcoatRoughnessTexture"))?;
        if let Some(normal) = &coat.clearcoat_normal_texture {
            (layers.clearcoat_normal_texture, layers.clearcoat_normal_scale) =
                reader.normal(normal, &at("clearcoatNormalTexture"))?;
        }
    }
    if let Some(sheen) = extension::<Sheen>(extensions, SHEEN, &place)? {
        let at = |name: &str| format!("extensions.{SHEEN}.{name}");
        layers.sheen_color = reader.shares(sheen.sheen_color_factor, &at("sheenColorFactor"))?;
        layers.sheen_color_texture =
            reader.texture(sheen.sheen_color_texture.as_ref(), Encoding::Srgb, &at("sheenColorTexture"))?;
        layers.sheen_roughness = reader.share(sheen.sheen_roughness_factor, &at("sheenRoughnessFactor"))?;
        layers.sheen_roughness_texture =
            reader.linear(sheen.sheen_roughness_texture.as_ref(), &at("sheenRoughnessTexture"))?;
    }
    if let Some(anisotropy) = extension::<Anisotropy>(extensions, ANISOTROPY, &place)? {
        let at = |name: &str| format!("extensions.{ANISOTROPY}.{name}");
        layers.anisotropy = reader.share(anisotropy.anisotropy_strength, &at("anisotropyStrength"))?;
        layers.anisotropy_rotation = reader.number(anisotropy.anisotropy_rotation, &at("anisotropyRotation"))?;
        layers.anisotropy_texture = reader.linear(anisotropy.anisotropy_texture.as_ref(), &at("anisotropyTexture"))?;
    }
    if let Some(film) = extension::<Iridescence>(extensions, IRIDESCENCE, &place)? {
        let at = |name: &str| format!("extensions.{IRIDESCENCE}.{name}");
        layers.iridescence = reader.share(film.iridescence_factor, &at("iridescenceFactor"))?;
        layers.iridescence_texture = reader.linear(film.iridescence_texture.as_ref(), &at("iridescenceTexture"))?;
        layers.iridescence_ior = reader.index(film.iridescence_ior, &at("iridescenceIor"))?;
        layers.iridescence_thickness_minimum =
            reader.amount(film.iridescence_thickness_minimum, &at("iridescenceThicknessMinimum"))?;
        layers.iridescence_thickness_maximum =
            reader.amount(film.iridescence_thickness_maximum, &at("iridescenceThicknessMaximum"))?;
        layers.iridescence_thickness_texture =
            reader.linear(film.iridescence_thickness_texture.as_ref(), &at("iridescenceThicknessTexture"))?;
    }
    if let Some(leaf) = extension::<DiffuseTransmission>(extensions, DIFFUSE_TRANSMISSION, &place)? {
        let at = |name: &str| format!("extensions.{DIFFUSE_TRANSMISSION}.{name}");
        layers.diffuse_transmission =
            reader.share(leaf.diffuse_transmission_factor, &at("diffuseTransmissionFactor"))?;
        layers.diffuse_transmission_texture =
            reader.linear(leaf.diffuse_transmission_texture.as_ref(), &at("diffuseTransmissionTexture"))?;
        layers.diffuse_transmission_color =
            reader.shares(leaf.diffuse_transmission_color_factor, &at("diffuseTransmissionColorFactor"))?;
        layers.diffuse_transmission_color_texture = reader.texture(
            leaf.diffuse_transmission_color_texture.as_ref(),
            Encoding::Srgb,
            &at("diffuseTransmissionColorTexture"),
        )?;
    }
    without_effect(&mut layers);
    Ok(layers.has_effect().then(|| Box::new(layers)))
}

/// What is switched off by its factor needs no textures.
fn without_effect(layers: &mut MaterialLayers) {
    if layers.clearcoat == 0.0 {
        layers.clearcoat_texture = None;
        layers.clearcoat_roughness_texture = None;
        layers.clearcoat_normal_texture = None;
    }
    if layers.sheen_color == Rgb::ZERO {
        layers.sheen_color_texture = None;
        layers.sheen_roughness_texture = None;
    }
    if layers.anisotropy == 0.0 {
        layers.anisotropy_texture = None;
    }
    if layers.iridescence == 0.0 {
        layers.iridescence_texture = None;
        layers.iridescence_thickness_texture = None;
    }
    if layers.diffuse_transmission == 0.0 {
        layers.diffuse_transmission_texture = None;
        layers.diffuse_transmission_color_texture = None;
    }
}
