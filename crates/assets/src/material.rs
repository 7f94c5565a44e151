//! glTF materials with their extensions.

use ergodic_scattering::{AlphaMode, Material, Rgb, SpecularGlossiness, TextureUse};
use gltf::json;
use gltf::json::material::NormalTexture;
use gltf::json::texture::Info;
use gltf::json::validation::Checked;
use serde::Deserialize;

use crate::document::Document;
use crate::error::Flaw;
use crate::material_layers::{self, extension};
use crate::texture::{Encoding, Reference, Textures};
use crate::volume_scatter;
use crate::warnings::Warnings;

/// Least attenuation colour: a channel of 0 would absorb everything over any distance.
const LEAST_ATTENUATION: f64 = 1e-6;

/// Reads the parts of one material.
pub(crate) struct Reader<'a> {
    document: &'a Document,
    textures: &'a mut Textures,
    pub(crate) warnings: &'a mut Warnings,
    /// Where the material is in the file.
    pub place: String,
}

impl Reader<'_> {
    pub(crate) fn texture(
        &mut self,
        info: Option<&Info>,
        encoding: Encoding,
        name: &str,
    ) -> Result<Option<TextureUse>, Flaw> {
        let Some(info) = info else { return Ok(None) };
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        let reference = Reference { texture: info.index, texcoord: info.tex_coord, transform, encoding };
        self.textures.reference(self.document, &reference, &format!("{}.{name}", self.place), self.warnings)
    }

    /// A texture of numbers that are no colours.
    pub(crate) fn linear(&mut self, info: Option<&Info>, name: &str) -> Result<Option<TextureUse>, Flaw> {
        self.texture(info, Encoding::Linear, name)
    }

    /// A normal map and its scale.
    pub(crate) fn normal(&mut self, normal: &NormalTexture, name: &str) -> Result<(Option<TextureUse>, f64), Flaw> {
        let transform = normal.extensions.as_ref().and_then(|e| e.others.get("KHR_texture_transform"));
        let transform = transform.cloned().map(serde_json::from_value).transpose();
        let place = format!("{}.{name}", self.place);
        let transform = transform
            .map_err(|e| Flaw::malformed(format!("{place}.extensions.KHR_texture_transform"), e.to_string()))?;
        let (texture, texcoord, encoding) = (normal.index, normal.tex_coord, Encoding::Linear);
        let reference = Reference { texture, texcoord, transform: transform.as_ref(), encoding };
        let used = self.textures.reference(self.document, &reference, &place, self.warnings)?;
        Ok((used, self.number(normal.scale, &format!("{name}.scale"))?))
    }

    /// A finite number.
    pub(crate) fn number(&self, value: f32, name: &str) -> Result<f64, Flaw> {
        if value.is_finite() {
            Ok(f64::from(value))
        } else {
            Err(Flaw::malformed(format!("{}.{name}", self.place), "is not finite"))
        }
    }

    /// An index of refraction; one below 1 is taken as 1, with a warning.
    pub(crate) fn index(&mut self, value: f32, name: &str) -> Result<f64, Flaw> {
        let index = self.amount(value, name)?;
        if index < 1.0 {
            let place = format!("{}.{name}", self.place);
            self.warnings.note("An index of refraction below 1", place, "is taken as 1");
        }
        Ok(index.max(1.0))
    }

    /// A number in `[0, 1]`; what lies outside is clamped, with a warning.
    pub(crate) fn share(&mut self, value: f32, name: &str) -> Result<f64, Flaw> {
        if !value.is_finite() {
            return Err(Flaw::malformed(format!("{}.{name}", self.place), "is not finite"));
        }
        if !(0.0..=1.0).contains(&value) {
            let place = format!("{}.{name} is {value}", self.place);
            self.warnings.note("A factor outside [0, 1]", place, "is clamped");
        }
        Ok(f64::from(value.clamp(0.0, 1.0)))
    }

    pub(crate) fn shares(&mut self, [r, g, b]: [f32; 3], name: &str) -> Result<Rgb, Flaw> {
        Ok(Rgb::new(self.share(r, name)?, self.share(g, name)?, self.share(b, name)?))
    }

    /// A finite number that is not negative.
    pub(crate) fn amount(&self, value: f32, name: &str) -> Result<f64, Flaw> {
        if value.is_finite() && value >= 0.0 {
            Ok(f64::from(value))
        } else {
            Err(Flaw::malformed(format!("{}.{name}", self.place), format!("is {value}; it cannot be negative")))
        }
    }

    fn amounts(&self, [r, g, b]: [f32; 3], name: &str) -> Result<Rgb, Flaw> {
        Ok(Rgb::new(self.amount(r, name)?, self.amount(g, name)?, self.amount(b, name)?))
    }
}

/// Reads material `index` of the file.
pub(crate) fn read(
    document: &Document,
    index: usize,
    textures: &mut Textures,
    warnings: &mut Warnings,
) -> Result<Material, Flaw> {
    let json = &document.root.materials[index];
    let place = format!("materials[{index}]");
    let mut reader = Reader { document, textures, warnings, place };
    let name = json.name.clone().unwrap_or_default();
    let mut material = Material { name, double_sided: json.double_sided, ..Material::default() };

    let base = &json.pbr_metallic_roughness;
    let [r, g, b, alpha] = base.base_color_factor.0;
    material.alpha = reader.share(alpha, "pbrMetallicRoughness.baseColorFactor[3]")?;
    material.alpha_mode = alpha_mode(json, &reader.place)?;
    material.base_color = reader.shares([r, g, b], "pbrMetallicRoughness.baseColorFactor")?;
    material.base_color_texture =
        reader.texture(base.base_color_texture.as_ref(), Encoding::Srgb, "pbrMetallicRoughness.baseColorTexture")?;
    material.metallic = reader.share(base.metallic_factor.0, "pbrMetallicRoughness.metallicFactor")?;
    material.roughness = reader.share(base.roughness_factor.0, "pbrMetallicRoughness.roughnessFactor")?;
    material.metallic_roughness_texture = reader.texture(
        base.metallic_roughness_texture.as_ref(),
        Encoding::Linear,
        "pbrMetallicRoughness.metallicRoughnessTexture",
    )?;

    if let Some(normal) = &json.normal_texture {
        (material.normal_texture, material.normal_scale) = reader.normal(normal, "normalTexture")?;
    }

    material.emission = reader.amounts(json.emissive_factor.0, "emissiveFactor")?;
    material.emission_texture = reader.texture(json.emissive_texture.as_ref(), Encoding::Srgb, "emissiveTexture")?;
    if let Some(extensions) = &json.extensions {
        read_extensions(extensions, &mut material, &mut reader)?;
    }
    if material.alpha_mode != AlphaMode::Opaque && material.is_solid() {
        reader.warnings.note("Alpha of refracting solids", &reader.place, "is not supported: they are whole");
    }
    Ok(material)
}

fn read_extensions(
    extensions: &json::extensions::material::Material,
    material: &mut Material,
    reader: &mut Reader<'_>,
) -> Result<(), Flaw> {
    if let Some(strength) = &extensions.emissive_strength {
        let name = "extensions.KHR_materials_emissive_strength.emissiveStrength";
        material.emission *= reader.amount(strength.emissive_strength.0, name)?;
    }
    if let Some(ior) = &extensions.ior {
        // 0 stands for a perfect reflector.
        let zero = ior.ior.0 == 0.0;
        material.ior = if zero { 0.0 } else { reader.index(ior.ior.0, "extensions.KHR_materials_ior.ior")? };
    }
    if let Some(specular) = &extensions.specular {
        let name = "extensions.KHR_materials_specular";
        material.specular = reader.share(specular.specular_factor.0, &format!("{name}.specularFactor"))?;
        let texture = specular.specular_texture.as_ref();
        material.specular_texture = reader.texture(texture, Encoding::Linear, &format!("{name}.specularTexture"))?;
        let color = specular.specular_color_factor.0;
        material.specular_color = reader.amounts(color, &format!("{name}.specularColorFactor"))?;
        let texture = specular.specular_color_texture.as_ref();
        material.specular_color_texture =
            reader.texture(texture, Encoding::Srgb, &format!("{name}.specularColorTexture"))?;
    }
    if let Some(transmission) = &extensions.transmission {
        let name = "extensions.KHR_materials_transmission";
        material.transmission =
            reader.share(transmission.transmission_factor.0, &format!("{name}.transmissionFactor"))?;
        let texture = transmission.transmission_texture.as_ref();
        material.transmission_texture =
            reader.texture(texture, Encoding::Linear, &format!("{name}.transmissionTexture"))?;
    }
    if let Some(volume) = &extensions.volume {
        let name = "extensions.KHR_materials_volume";
        // Only whether there is a thickness matters: how thick the solid is, the rays find out.
        material.solid = reader.amount(volume.thickness_factor.0, &format!("{name}.thicknessFactor"))? > 0.0;
        let color = reader.shares(volume.attenuation_color.0, &format!("{name}.attenuationColor"))?;
        let distance = f64::from(volume.attenuation_distance.0);
        // The distance is infinite where the file states none.
        if distance.is_nan() || distance <= 0.0 {
            let place = format!("{}.{name}.attenuationDistance", reader.place);
            return Err(Flaw::malformed(place, format!("is {distance}; it must be greater than 0")));
        }
        let color = color.max(Rgb::splat(LEAST_ATTENUATION));
        // An addition of 0 keeps a clear channel from being -0.
        material.absorption = -color.map(libm::log) / distance + Rgb::ZERO;
    }
    volume_scatter::read(&extensions.others, material, reader)?;
    if let Some(old) = extension::<OldWorkflow>(&extensions.others, OLD_WORKFLOW, &reader.place)? {
        read_specular_glossiness(&old, material, reader)?;
    }
    material.layers = material_layers::read(&extensions.others, reader)?;
    if let Some(dispersion) = extension::<Dispersion>(&extensions.others, DISPERSION, &reader.place)? {
        let name = format!("extensions.{DISPERSION}.dispersion");
        material.dispersion = reader.amount(dispersion.dispersion, &name)?;
    }
    let disperses = material.dispersion > 0.0;
    if extensions.unlit.is_some() {
        make_unlit(material);
    }
    if disperses && !material.disperses() {
        reader.warnings.note(
            DISPERSION,
            &reader.place,
            "has no effect on a material that does not refract: it needs KHR_materials_transmission, KHR_materials_volume with a \
             thicknessFactor, and an index of refraction above 1",
        );
    }
    Ok(())
}

pub(crate) const DISPERSION: &str = "KHR_materials_dispersion";

#[derive(Default, Deserialize)]
#[serde(default)]
struct Dispersion {
    dispersion: f32,
}

const OLD_WORKFLOW: &str = "KHR_materials_pbrSpecularGlossiness";

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct OldWorkflow {
    diffuse_factor: [f32; 4],
    diffuse_texture: Option<Info>,
    specular_factor: [f32; 3],
    glossiness_factor: f32,
    specular_glossiness_texture: Option<Info>,
}

impl Default for OldWorkflow {
    fn default() -> Self {
        Self {
            diffuse_factor: [1.0; 4],
            diffuse_texture: None,
            specular_factor: [1.0; 3],
            glossiness_factor: 1.0,
            specular_glossiness_texture: None,
        }
    }
}

/// The old workflow takes the place of metallic and roughness. Its reflectance at normal incidence is a colour: that of an
/// index of 0, which reflects everything, times the specular colour.
fn read_specular_glossiness(old: &OldWorkflow, material: &mut Material, reader: &mut Reader<'_>) -> Result<(), Flaw> {
    let at = |name: &str| format!("extensions.{OLD_WORKFLOW}.{name}");
    let [r, g, b, alpha] = old.diffuse_factor;
    material.alpha = reader.share(alpha, &at("diffuseFactor[3]"))?;
    material.base_color = reader.shares([r, g, b], &at("diffuseFactor"))?;
    material.base_color_texture =
        reader.texture(old.diffuse_texture.as_ref(), Encoding::Srgb, &at("diffuseTexture"))?;
    material.specular_color = reader.shares(old.specular_factor, &at("specularFactor"))?;
    let glossiness = reader.share(old.glossiness_factor, &at("glossinessFactor"))?;
    let texture = old.specular_glossiness_texture.as_ref();
    let texture = reader.texture(texture, Encoding::Srgb, &at("specularGlossinessTexture"))?;
    material.specular_glossiness = Some(SpecularGlossiness { glossiness, texture });
    (material.metallic, material.metallic_roughness_texture) = (0.0, None);
    (material.ior, material.specular, material.specular_texture) = (0.0, 1.0, None);
    material.specular_color_texture = None;
    Ok(())
}

/// The surface emits its base colour and scatters nothing.
fn make_unlit(material: &mut Material) {
    *material = Material {
        name: std::mem::take(&mut material.name),
        double_sided: material.double_sided,
        alpha_mode: material.alpha_mode,
        alpha: material.alpha,
        // Black as it is, it has the alpha.
        base_color_texture: material.base_color_texture.filter(|_| material.alpha_mode != AlphaMode::Opaque),
        emission: material.base_color,
        emission_texture: material.base_color_texture,
        base_color: Rgb::ZERO,
        metallic: 0.0,
        specular: 0.0,
        unlit: true,
        ..Material::default()
    };
}

fn alpha_mode(material: &json::Material, place: &str) -> Result<AlphaMode, Flaw> {
    match material.alpha_mode {
        Checked::Valid(json::material::AlphaMode::Opaque) | Checked::Invalid => Ok(AlphaMode::Opaque),
        Checked::Valid(json::material::AlphaMode::Blend) => Ok(AlphaMode::Blend),
        Checked::Valid(json::material::AlphaMode::Mask) => {
            let cutoff = material.alpha_cutoff.map_or(0.5, |cutoff| f64::from(cutoff.0));
            if !(cutoff >= 0.0 && cutoff.is_finite()) {
                return Err(Flaw::malformed(
                    format!("{place}.alphaCutoff"),
                    format!("is {cutoff}; it must not be negative"),
                ));
            }
            Ok(AlphaMode::Mask { cutoff })
        }
    }
}
