//! The glTF 2.0 metallic-roughness material with its extensions, as a file states it; [`Material::interaction`] turns it
//! into the scattering at one point.

use ergodic_geometry::{Frame, Surface};
use glam::DVec4;

use crate::{
    Bsdf, Extended, Interaction, Lambert, Layered, MaterialLayers, Medium, Parameters, Repertoire, Rgb, Texture,
    TextureUse, Wavelength, normal_map, wavelength,
};

/// What alpha, the product of those of base colour factor, texture and mesh, means (glTF 2.0, section 3.9.4).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Nothing: the surface is whole.
    #[default]
    Opaque,
    /// The surface is there where alpha is at least this, and nowhere else.
    Mask {
        /// alphaCutoff.
        cutoff: f64,
    },
    /// The surface covers this share of every small area: it scatters and emits this share, and lets the rest of the light pass
    /// straight through.
    Blend,
}

/// A material. Colours are linear. Defaults are glTF's.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name in the file, for messages.
    pub name: String,
    /// baseColorFactor without alpha.
    pub base_color: Rgb,
    /// How much of what lies behind the surface it covers.
    pub alpha_mode: AlphaMode,
    /// Alpha of baseColorFactor.
    pub alpha: f64,
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
    /// KHR_materials_dispersion: 20 over the Abbe number; 0 for the same index at all wavelengths. See [`Self::disperses`].
    pub dispersion: f64,
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
    /// attenuationDistance, less what is scattered; zero for a clear solid. Only read when `solid`.
    pub absorption: Rgb,
    /// KHR_materials_volume_scatter: scattering coefficient per unit of world length. Only read when `solid`.
    pub scattering: Rgb,
    /// KHR_materials_volume_scatter: scatterAnisotropy, the mean cosine of the turn, in (-1, 1).
    pub anisotropy: f64,
    /// Whether emission leaves both faces.
    pub double_sided: bool,
    /// Coat, sheen and the like; `None` for the many materials that have nothing of it.
    pub layers: Option<Box<MaterialLayers>>,
    /// KHR_materials_pbrSpecularGlossiness: the base colour is its diffuse colour and the specular colour its specular
    /// one, with an index of 0 and no metal; this has the rest.
    pub specular_glossiness: Option<SpecularGlossiness>,
    /// Evaluates the surface with every effect there is, though it has none of them: for measuring what they cost.
    pub general: bool,
    /// KHR_materials_unlit: the emission is what was the base colour, and takes the mesh's colour as that would.
    pub unlit: bool,
}

/// What KHR_materials_pbrSpecularGlossiness has in place of roughness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpecularGlossiness {
    /// glossinessFactor: 1 - roughness.
    pub glossiness: f64,
    /// specularGlossinessTexture: specular colour in RGB, glossiness in A.
    pub texture: Option<TextureUse>,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Rgb::ONE,
            alpha_mode: AlphaMode::Opaque,
            alpha: 1.0,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            emission: Rgb::ZERO,
            emission_texture: None,
            ior: 1.5,
            dispersion: 0.0,
            specular: 1.0,
            specular_texture: None,
            specular_color: Rgb::ONE,
            specular_color_texture: None,
            transmission: 0.0,
            transmission_texture: None,
            solid: false,
            absorption: Rgb::ZERO,
            scattering: Rgb::ZERO,
            anisotropy: 0.0,
            double_sided: false,
            layers: None,
            specular_glossiness: None,
            general: false,
            unlit: false,
        }
    }
}

impl Material {
    /// Whether the surface bounds a refracting solid: it has a volume, and some light can get in.
    #[inline]
    pub fn is_solid(&self) -> bool {
        self.solid && (self.is_transmissive() || self.is_translucent())
    }

    /// What fills the solid; nothing if the surface bounds none.
    pub fn medium(&self) -> Medium {
        if self.is_solid() {
            Medium { scattering: self.scattering, absorption: self.absorption, anisotropy: self.anisotropy }
        } else {
            Medium::VACUUM
        }
    }

    /// Whether light can pass diffusely anywhere on the surface.
    #[inline]
    fn is_translucent(&self) -> bool {
        self.layers.as_ref().is_some_and(|layers| layers.diffuse_transmission > 0.0) && self.metallic_is_below_one()
    }

    /// Whether light can pass anywhere on the surface. An index of 0 stands for a perfect reflector (KHR_materials_ior).
    #[inline]
    fn is_transmissive(&self) -> bool {
        self.transmission > 0.0 && self.metallic_is_below_one() && self.ior > 0.0
    }

    #[inline]
    fn metallic_is_below_one(&self) -> bool {
        self.metallic < 1.0 || self.metallic_roughness_texture.is_some()
    }

    /// Whether the index of refraction depends on the wavelength and light gets to know: only where it refracts, in solids that are
    /// transmissive, and with an index other than that of air.
    #[inline]
    pub fn disperses(&self) -> bool {
        self.dispersion > 0.0 && self.solid && self.is_transmissive() && self.ior != 1.0
    }

    /// The index of refraction at a wavelength.
    #[inline]
    pub fn index_at(&self, wavelength: Wavelength) -> f64 {
        if self.disperses() { wavelength::index(self.ior, self.dispersion, wavelength) } else { self.ior }
    }

    /// The set of texture coordinates along which tangents are needed, if a normal map or an effect needs any.
    pub fn tangent_texcoord(&self) -> Option<usize> {
        let base = self.normal_texture.as_ref().map(|texture| texture.texcoord);
        base.or_else(|| self.layers.as_ref()?.tangent_texcoord())
    }

    /// The share of what lies behind that the surface covers at a point, on both sides alike, in [0, 1]. The boundaries of refracting
    /// solids are whole: light that passed them unrefracted would be neither inside nor outside.
    pub fn coverage(&self, textures: &[Texture], surface: &Surface) -> f64 {
        self.coverage_of(|| {
            let texel = self.base_color_texture.map_or(1.0, |texture| texture.at(textures, surface).w);
            self.alpha * texel * surface.color.w
        })
    }

    /// The least share that it covers anywhere on a mesh whose colours have at least this alpha.
    pub fn least_coverage(&self, textures: &[Texture], color_alpha: f64) -> f64 {
        self.coverage_of(|| {
            let texel = self.base_color_texture.map_or(1.0, |texture| textures[texture.texture].least_alpha());
            self.alpha * texel * color_alpha
        })
    }

    #[inline]
    fn coverage_of(&self, alpha: impl FnOnce() -> f64) -> f64 {
        match self.alpha_mode {
            AlphaMode::Opaque => 1.0,
            _ if self.is_solid() => 1.0,
            AlphaMode::Mask { cutoff } => f64::from(u8::from(alpha() >= cutoff)),
            AlphaMode::Blend => alpha().clamp(0.0, 1.0),
        }
    }

    /// The scattering at every point of a surface with this material, if neither a texture nor the wavelength changes it; for white
    /// vertex colours.
    pub fn constant_bsdf(&self) -> Option<Bsdf> {
        if self.disperses() {
            return None;
        }
        let textures = [
            &self.base_color_texture,
            &self.metallic_roughness_texture,
            &self.normal_texture,
            &self.specular_texture,
            &self.specular_color_texture,
            &self.transmission_texture,
            &self.specular_glossiness.and_then(|specular| specular.texture),
        ];
        if textures.iter().any(|texture| texture.is_some()) {
            return None;
        }
        let base = self.parameters(Rgb::ONE, Wavelength::NONE, |_| None);
        let Some(layers) = &self.layers else { return Some(self.bsdf(&base)) };
        let effects = layers.effects(&|_| None);
        layers.is_constant().then(|| {
            if effects.has_effect() { Bsdf::Extended(Extended::new(&base, &effects)) } else { self.bsdf(&base) }
        })
    }

    /// The scattering at a point of a surface whose normal is the mesh's, by a material's [`Self::constant_bsdf`].
    #[inline]
    pub fn interaction_of<R: Repertoire>(bsdf: Bsdf, surface: &Surface) -> Interaction<R> {
        let frame = Frame::from_normal(normal_map::keep_above(surface.ns, surface.ng));
        Interaction::new(frame, surface.ng, bsdf)
    }

    /// The scattering at a point of a surface with this material, with the index of refraction that the file states.
    pub fn interaction(&self, textures: &[Texture], surface: &Surface) -> Interaction {
        self.interaction_at(textures, surface, Wavelength::NONE)
    }

    /// The scattering at a point of a surface with this material, for light of a wavelength.
    #[inline]
    pub fn interaction_at<R: Repertoire>(
        &self,
        textures: &[Texture],
        surface: &Surface,
        wavelength: Wavelength,
    ) -> Interaction<R> {
        let read = |texture: &Option<TextureUse>| texture.map(|texture| texture.at(textures, surface));
        let ns = match read(&self.normal_texture) {
            Some(texel) => normal_map::apply(surface, texel, self.normal_scale),
            None => normal_map::keep_above(surface.ns, surface.ng),
        };
        let base = self.parameters(surface.color.truncate(), wavelength, read);
        if let Some(layers) = &self.layers
            && let Some(interaction) = layers.interaction(&base, ns, surface, &read)
        {
            return interaction;
        }
        Interaction::new(Frame::from_normal(ns), surface.ng, self.bsdf(&base))
    }

    /// The surface of core glTF with these parameters.
    #[inline]
    fn bsdf(&self, base: &Parameters) -> Bsdf {
        if self.general {
            Bsdf::Extended(Extended::new(base, &MaterialLayers::default().effects(&|_| None)))
        } else if base.metallic == 0.0 && base.specular == 0.0 && !base.transmissive && !base.solid {
            Bsdf::Lambert(Lambert { albedo: base.base })
        } else {
            Bsdf::Layered(Layered::new(base))
        }
    }

    /// The base's parameters for a wavelength, where the mesh has a colour and textures have what `read` gives.
    #[inline]
    fn parameters(
        &self,
        color: Rgb,
        wavelength: Wavelength,
        read: impl Fn(&Option<TextureUse>) -> Option<DVec4>,
    ) -> Parameters {
        let mut base = self.base_color * color;
        if let Some(texel) = read(&self.base_color_texture) {
            base *= texel.truncate();
        }
        let (mut metallic, mut roughness) = (self.metallic, self.roughness);
        if let Some(texel) = read(&self.metallic_roughness_texture) {
            metallic *= texel.z;
            roughness *= texel.y;
        }
        let specular = self.specular * read(&self.specular_texture).map_or(1.0, |texel| texel.w);
        let tint = read(&self.specular_color_texture).map_or(Rgb::ONE, |texel| texel.truncate());
        let mut specular_color = self.specular_color * tint;
        if let Some(gloss) = &self.specular_glossiness {
            let texel = read(&gloss.texture).unwrap_or(DVec4::ONE);
            roughness = 1.0 - gloss.glossiness * texel.w;
            specular_color *= texel.truncate();
            base *= 1.0 - specular_color.max_element().min(1.0);
        }
        let transmissive = self.is_transmissive();
        let transmission = self.transmission * read(&self.transmission_texture).map_or(1.0, |texel| texel.x);
        Parameters {
            base,
            metallic,
            alpha: roughness * roughness,
            ior: self.index_at(wavelength),
            specular,
            specular_color,
            transmission: if transmissive { transmission } else { 0.0 },
            transmissive,
            solid: self.is_solid(),
            dispersive: self.disperses(),
        }
    }

    /// Radiance emitted at a point of a surface, before it is asked from which side (see [`crate::emission`]) and what a
    /// coat leaves of it.
    pub fn emitted(&self, textures: &[Texture], surface: &Surface) -> Rgb {
        let emission = if self.unlit { self.emission * surface.color.truncate() } else { self.emission };
        match &self.emission_texture {
            Some(texture) => emission * texture.at(textures, surface).truncate(),
            None => emission,
        }
    }

    /// Whether the emission is not the same all over the surface.
    pub fn emission_varies(&self) -> bool {
        self.emission_texture.is_some() || self.unlit
    }
}
