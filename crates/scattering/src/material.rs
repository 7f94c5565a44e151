//! The glTF 2.0 metallic-roughness material with its extensions, as a file states it; [`Material::interaction`] turns it
//! into the scattering at one point.

use crate::{Rgb, TextureUse};

/// A material. Colours are linear. Defaults are glTF's.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name in the file, for messages.
    pub name: String,
    /// baseColorFactor without alpha.
    pub base_color: Rgb,
    /// baseColorTexture.
    pub base_color_texture: Option<TextureUse>,
    /// metallicFactor.
    pub metallic: f64,
    /// roughnessFactor (perceptual; alpha of GGX is its square).
    pub roughness: f64,
    /// metallicRoughnessTexture: roughness in G, metallic in B.
    pub metallic_roughness_texture: Option<TextureUse>,
    /// normalTexture.
    pub normal_texture: Option<TextureUse>,
    /// normalTexture.scale.
    pub normal_scale: f64,
    /// emissiveFactor times KHR_materials_emissive_strength: the emitted radiance.
    pub emission: Rgb,
    /// emissiveTexture, multiplied into the emission.
    pub emission_texture: Option<TextureUse>,
    /// KHR_materials_ior, 1.5 by default.
    pub ior: f64,
    /// KHR_materials_specular: specularFactor.
    pub specular: f64,
    /// KHR_materials_specular: specularTexture (A).
    pub specular_texture: Option<TextureUse>,
    /// KHR_materials_specular: specularColorFactor.
    pub specular_color: Rgb,
    /// KHR_materials_specular: specularColorTexture (RGB).
    pub specular_color_texture: Option<TextureUse>,
    /// KHR_materials_transmission: transmissionFactor.
    pub transmission: f64,
    /// KHR_materials_transmission: transmissionTexture (R).
    pub transmission_texture: Option<TextureUse>,
    /// KHR_materials_volume with thickness > 0: the surface bounds a solid that refracts; otherwise it is thin-walled.
    pub solid: bool,
    /// KHR_materials_volume: absorption coefficient per unit of world length, -ln(attenuationColor) /
    /// attenuationDistance; zero for a clear solid. Only read when `solid`.
    pub absorption: Rgb,
    /// Whether emission leaves both faces.
    pub double_sided: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Rgb::ONE,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            emission: Rgb::ZERO,
            emission_texture: None,
            ior: 1.5,
            specular: 1.0,
            specular_texture: None,
            specular_color: Rgb::ONE,
            specular_color_texture: None,
            transmission: 0.0,
            transmission_texture: None,
            solid: false,
            absorption: Rgb::ZERO,
            double_sided: false,
        }
    }
}
