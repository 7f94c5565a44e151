//! The parts of a material that few materials have: glTF's extensions beyond the layered surface, as a file states them.

use ergodic_geometry::{Frame, Surface};
use glam::{DVec2, DVec3, DVec4};

use crate::{Bsdf, Extended, ExtendedParameters, Interaction, Parameters, Repertoire, Rgb, TextureUse, normal_map};

/// What a material has of KHR_materials_clearcoat, _sheen, _anisotropy, _iridescence and _diffuse_transmission. Defaults are
/// glTF's: without effect.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialLayers {
    /// clearcoatFactor.
    pub clearcoat: f64,
    /// clearcoatTexture (R).
    pub clearcoat_texture: Option<TextureUse>,
    /// clearcoatRoughnessFactor.
    pub clearcoat_roughness: f64,
    /// clearcoatRoughnessTexture (G).
    pub clearcoat_roughness_texture: Option<TextureUse>,
    /// clearcoatNormalTexture; without it the coat has the mesh's normal, whatever the base has.
    pub clearcoat_normal_texture: Option<TextureUse>,
    /// clearcoatNormalTexture.scale.
    pub clearcoat_normal_scale: f64,
    /// sheenColorFactor.
    pub sheen_color: Rgb,
    /// sheenColorTexture (RGB).
    pub sheen_color_texture: Option<TextureUse>,
    /// sheenRoughnessFactor.
    pub sheen_roughness: f64,
    /// sheenRoughnessTexture (A).
    pub sheen_roughness_texture: Option<TextureUse>,
    /// anisotropyStrength.
    pub anisotropy: f64,
    /// anisotropyRotation in radians, counter-clockwise from the tangent.
    pub anisotropy_rotation: f64,
    /// anisotropyTexture: direction in RG, strength in B.
    pub anisotropy_texture: Option<TextureUse>,
    /// iridescenceFactor.
    pub iridescence: f64,
    /// iridescenceTexture (R).
    pub iridescence_texture: Option<TextureUse>,
    /// iridescenceIor.
    pub iridescence_ior: f64,
    /// iridescenceThicknessMinimum in nanometres.
    pub iridescence_thickness_minimum: f64,
    /// iridescenceThicknessMaximum in nanometres.
    pub iridescence_thickness_maximum: f64,
    /// iridescenceThicknessTexture (G): from the minimum to the maximum.
    pub iridescence_thickness_texture: Option<TextureUse>,
    /// diffuseTransmissionFactor.
    pub diffuse_transmission: f64,
    /// diffuseTransmissionTexture (A).
    pub diffuse_transmission_texture: Option<TextureUse>,
    /// diffuseTransmissionColorFactor.
    pub diffuse_transmission_color: Rgb,
    /// diffuseTransmissionColorTexture (RGB).
    pub diffuse_transmission_color_texture: Option<TextureUse>,
}

impl Default for MaterialLayers {
    fn default() -> Self {
        Self {
            clearcoat: 0.0,
            clearcoat_texture: None,
            clearcoat_roughness: 0.0,
            clearcoat_roughness_texture: None,
            clearcoat_normal_texture: None,
            clearcoat_normal_scale: 1.0,
            sheen_color: Rgb::ZERO,
            sheen_color_texture: None,
            sheen_roughness: 0.0,
            sheen_roughness_texture: None,
            anisotropy: 0.0,
            anisotropy_rotation: 0.0,
            anisotropy_texture: None,
            iridescence: 0.0,
            iridescence_texture: None,
            iridescence_ior: 1.3,
            iridescence_thickness_minimum: 100.0,
            iridescence_thickness_maximum: 400.0,
            iridescence_thickness_texture: None,
            diffuse_transmission: 0.0,
            diffuse_transmission_texture: None,
            diffuse_transmission_color: Rgb::ONE,
            diffuse_transmission_color_texture: None,
        }
    }
}

impl MaterialLayers {
    /// The textures with the names that people know them by.
    pub fn textures(&self) -> [(&'static str, &Option<TextureUse>); 10] {
        [
            ("clearcoat", &self.clearcoat_texture),
            ("clearcoat roughness", &self.clearcoat_roughness_texture),
            ("clearcoat normal", &self.clearcoat_normal_texture),
            ("sheen colour", &self.sheen_color_texture),
            ("sheen roughness", &self.sheen_roughness_texture),
            ("anisotropy", &self.anisotropy_texture),
            ("iridescence", &self.iridescence_texture),
            ("iridescence thickness", &self.iridescence_thickness_texture),
            ("diffuse transmission", &self.diffuse_transmission_texture),
            ("diffuse transmission colour", &self.diffuse_transmission_color_texture),
        ]
    }

    /// Leaves the factors alone everywhere.
    pub fn remove_textures(&mut self) {
        self.clearcoat_texture = None;
        self.clearcoat_roughness_texture = None;
        self.clearcoat_normal_texture = None;
        self.sheen_color_texture = None;
        self.sheen_roughness_texture = None;
        self.anisotropy_texture = None;
        self.iridescence_texture = None;
        self.iridescence_thickness_texture = None;
        self.diffuse_transmission_texture = None;
        self.diffuse_transmission_color_texture = None;
    }

    /// Whether anything here can change the surface somewhere.
    pub fn has_effect(&self) -> bool {
        self.clearcoat > 0.0
            || self.sheen_color != Rgb::ZERO
            || self.anisotropy > 0.0
            || self.iridescence > 0.0
            || self.diffuse_transmission > 0.0
    }

    /// The set of texture coordinates whose tangents are needed, if any are.
    pub fn tangent_texcoord(&self) -> Option<usize> {
        let anisotropic = self.anisotropy > 0.0;
        match (&self.clearcoat_normal_texture, &self.anisotropy_texture) {
            (Some(texture), _) => Some(texture.texcoord),
            (None, Some(texture)) if anisotropic => Some(texture.texcoord),
            (None, _) => anisotropic.then_some(0),
        }
    }

    /// Whether neither textures nor tangents are needed to know the effects at a point.
    pub(crate) fn is_constant(&self) -> bool {
        self.anisotropy == 0.0 && self.textures().iter().all(|(_, texture)| texture.is_none())
    }

    /// The effects where textures have what `read` gives, all but the coat's normal and the direction of anisotropy.
    pub(crate) fn effects(&self, read: &impl Fn(&Option<TextureUse>) -> Option<DVec4>) -> ExtendedParameters {
        let channel = |texture: &Option<TextureUse>, of: fn(DVec4) -> f64| read(texture).map_or(1.0, of);
        let colored = |texture: &Option<TextureUse>| read(texture).map_or(Rgb::ONE, DVec4::truncate);
        let mut effects = ExtendedParameters::default();
        if self.clearcoat > 0.0 {
            let roughness = self.clearcoat_roughness * channel(&self.clearcoat_roughness_texture, |t| t.y);
            effects.coat = self.clearcoat * channel(&self.clearcoat_texture, |t| t.x);
            effects.coat_alpha = roughness * roughness;
        }
        if self.sheen_color != Rgb::ZERO {
            effects.sheen_color = self.sheen_color * colored(&self.sheen_color_texture);
            effects.sheen_roughness = self.sheen_roughness * channel(&self.sheen_roughness_texture, |t| t.w);
        }
        if self.anisotropy > 0.0 {
            effects.anisotropy = self.anisotropy * channel(&self.anisotropy_texture, |t| t.z);
        }
        if self.iridescence > 0.0 {
            let (thinnest, thickest) = (self.iridescence_thickness_minimum, self.iridescence_thickness_maximum);
            let share = channel(&self.iridescence_thickness_texture, |t| t.y);
            effects.film = self.iridescence * channel(&self.iridescence_texture, |t| t.x);
            effects.film_ior = self.iridescence_ior;
            effects.film_thickness = thinnest + (thickest - thinnest) * share;
        }
        if self.diffuse_transmission > 0.0 {
            effects.translucency = self.diffuse_transmission * channel(&self.diffuse_transmission_texture, |t| t.w);
            effects.translucent_color =
                self.diffuse_transmission_color * colored(&self.diffuse_transmission_color_texture);
        }
        effects
    }

    /// The scattering at a point whose base has parameters `base` and the shading normal `ns`; `None` if nothing here has
    /// an effect there.
    pub(crate) fn interaction<R: Repertoire>(
        &self,
        base: &Parameters,
        ns: DVec3,
        surface: &Surface,
        read: &impl Fn(&Option<TextureUse>) -> Option<DVec4>,
    ) -> Option<Interaction<R>> {
        let mut effects = self.effects(read);
        if surface.bitangent_sign == 0.0 {
            // There is no direction for it.
            effects.anisotropy = 0.0;
        }
        if !effects.has_effect() {
            return None;
        }
        let frame = if effects.anisotropy > 0.0 {
            Frame::from_normal_tangent(ns, self.rougher_direction(surface, read))
        } else {
            Frame::from_normal(ns)
        };
        if effects.coat > 0.0 {
            let normal = match read(&self.clearcoat_normal_texture) {
                Some(texel) => normal_map::apply(surface, texel, self.clearcoat_normal_scale),
                None => normal_map::keep_above(surface.ns, surface.ng),
            };
            effects.coat_normal = (normal != ns).then(|| frame.to_local(normal));
        }
        let bsdf = Bsdf::Extended(Extended::new(base, &effects));
        Some(Interaction::new(frame, surface.ng, bsdf))
    }

    /// The direction in which anisotropy makes the surface rougher, in the world.
    fn rougher_direction(&self, surface: &Surface, read: &impl Fn(&Option<TextureUse>) -> Option<DVec4>) -> DVec3 {
        let painted = read(&self.anisotropy_texture).map_or(DVec2::X, |texel| texel.truncate().truncate() * 2.0 - 1.0);
        let (sin, cos) = libm::sincos(self.anisotropy_rotation);
        let turned = DVec2::new(cos, sin).rotate(painted.normalize_or(DVec2::X));
        let bitangent = surface.ns.cross(surface.tangent) * surface.bitangent_sign;
        surface.tangent * turned.x + bitangent * turned.y
    }
}
