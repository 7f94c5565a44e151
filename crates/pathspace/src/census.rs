//! The census: which effects a scene calls for, and what follows for the code that renders it.
//!
//! An effect that a scene does not have costs nothing: what would be the same everywhere is made once, what never happens is
//! not asked. [`Census::of`] counts, [`Plan`] decides, [`Scene::new`](crate::Scene::new) and the choice of mutations follow
//! it, and people can force an effect on, to see what it costs, or off, to see what it brings.

use std::fmt;

use ergodic_scattering::{
    AlphaMode, Bsdf, Component, Material, MaterialLayers, PunctualLight, SMOOTH_ALPHA, TextureUse,
};
use serde::{Deserialize, Serialize};

use crate::{CameraDescription, Projection, SceneDescription};

macro_rules! effects {
    ($($(#[$doc:meta])* $variant:ident: $name:literal, $on:literal, $off:literal;)+) => {
        /// Something that a scene may call for.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum Effect {
            $($(#[$doc])* $variant),+
        }

        impl Effect {
            /// All of them, in the order of tables.
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];

            /// What it is called.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),+ }
            }

            /// What is done in a scene that has it.
            pub fn when_on(self) -> &'static str {
                match self { $(Self::$variant => $on),+ }
            }

            /// What is saved in a scene that does not.
            pub fn when_off(self) -> &'static str {
                match self { $(Self::$variant => $off),+ }
            }
        }
    };
}

effects! {
    /// Textures of materials other than emission.
    Textures: "textures", "these materials are made at every point that is met", "materials are made once; no texture is fetched";
    /// Normal maps.
    NormalMaps: "normal maps", "shading normals come from a texture", "shading normals are those of the mesh";
    /// Colours of vertices.
    VertexColors: "vertex colours", "these materials are made at every point that is met", "no colour is interpolated that is not white";
    /// Microfacet reflection above the specular threshold.
    GlossyReflection: "glossy reflection", "microfacet lobes are sampled and weighed", "no microfacet lobe";
    /// Reflection below the specular threshold, a Dirac component.
    MirrorReflection: "specular reflection", "paths have Dirac vertices", "no Dirac vertex by reflection";
    /// Transmission through microfacets.
    RoughTransmission: "rough transmission", "microfacet lobes on the other side", "no rough lobe on the other side";
    /// Transmission without scattering, a Dirac component.
    ClearTransmission: "specular transmission", "paths have Dirac vertices", "no Dirac vertex by transmission";
    /// Diffuse transmission.
    DiffuseTransmission: "diffuse transmission", "a diffuse lobe on the other side", "no diffuse lobe on the other side";
    /// Coats, sheen, anisotropy, iridescence.
    Layers: "layers", "the layered surface with all its effects is evaluated", "surfaces are Lambertian or core glTF's";
    /// Solids that refract different wavelengths differently.
    Dispersion: "dispersion", "paths have a wavelength, and these materials are made for it", "light is RGB and has no wavelength";
    /// Media that absorb.
    Absorption: "absorption", "edges carry Beer's transmittance, vertices know what they are in", "edges carry no transmittance";
    /// Media that scatter.
    Scattering: "scattering media", "walks fly freely and end in media, edges carry the density of flight", "walks fly from surface to surface";
    /// Surfaces that are there in some places only (alphaMode MASK).
    Masks: "alpha masks", "rays ask what they meet whether it is there", "every surface is whole";
    /// Surfaces that cover a share of what lies behind them (alphaMode BLEND).
    Blending: "alpha blending", "visibility is a number, rays may pass what they meet", "visibility is yes or no";
    /// Surfaces that emit.
    EmittingSurfaces: "emitting surfaces", "lights have points, and rays from the eye can end on them", "rays from the eye end on no light";
    /// Surfaces whose emission a texture changes.
    TexturedEmission: "textured emission", "radiance is fetched at every point of a light", "lights are alike all over";
    /// Point and spot lights.
    PointLights: "point and spot lights", "some lights are points", "no light is a point";
    /// Directional lights.
    DistantLights: "directional lights", "some lights are infinitely far", "no light is a direction";
    /// Light from the environment.
    Environment: "environment", "rays that escape end on it", "rays that escape carry nothing";
    /// A lens with an aperture.
    Aperture: "aperture", "the point on the lens is sampled and kept or replaced", "no aperture: no point on a lens is sampled";
    /// An orthographic camera.
    Orthographic: "orthographic camera", "all image points look the same way", "all image points look from one place";
    /// Meshes that stand in several places.
    Instances: "instances", "rays are searched on two levels", "one tree holds all triangles";
}

/// A set of effects.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Effects(u64);

impl Effects {
    /// All of them.
    pub fn all() -> Self {
        Effect::ALL.iter().copied().collect()
    }

    /// Whether it has an effect.
    #[inline]
    pub fn has(self, effect: Effect) -> bool {
        self.0 >> effect as u32 & 1 == 1
    }

    /// Whether paths may have Dirac vertices.
    pub fn has_specular(self) -> bool {
        self.has(Effect::MirrorReflection) || self.has(Effect::ClearTransmission)
    }

    /// With the effects of another set.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Without the effects of another set.
    #[must_use]
    pub fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// What both have.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Its members, in the order of tables.
    pub fn iter(self) -> impl Iterator<Item = Effect> {
        Effect::ALL.iter().copied().filter(move |effect| self.has(*effect))
    }

    /// Whether there is none.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl FromIterator<Effect> for Effects {
    fn from_iter<I: IntoIterator<Item = Effect>>(effects: I) -> Self {
        Self(effects.into_iter().fold(0, |set, effect| set | 1 << effect as u32))
    }
}

impl fmt::Debug for Effects {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.iter()).finish()
    }
}

/// Where an effect was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Which effect.
    pub effect: Effect,
    /// Indices of the materials that have it, if it is one of materials.
    pub materials: Vec<usize>,
    /// Triangles, as often as they are placed, that have it.
    pub triangles: u64,
    /// How many lights or meshes have it, if it is one of these.
    pub count: u64,
}

/// What was found in a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Census {
    findings: Vec<Finding>,
}

/// Which lobes a material may have somewhere. Where a texture decides, every outcome that some texel may have counts.
fn lobes(material: &Material) -> Effects {
    let alpha = material.roughness * material.roughness;
    let mut effects = Vec::new();
    if let Some(bsdf) = material.constant_bsdf() {
        let has = |component| bsdf.has(component);
        let glossy = matches!(bsdf, Bsdf::Layered(_) | Bsdf::Extended(_)) && alpha >= SMOOTH_ALPHA;
        effects.extend(has(Component::DiracReflection).then_some(Effect::MirrorReflection));
        effects.extend(has(Component::DiracTransmission).then_some(Effect::ClearTransmission));
        effects.extend(glossy.then_some(Effect::GlossyReflection));
        effects.extend((glossy && material.transmission > 0.0).then_some(Effect::RoughTransmission));
    } else {
        // A texture may only lower the roughness.
        let (smooth, rough) =
            (alpha < SMOOTH_ALPHA || material.metallic_roughness_texture.is_some(), alpha >= SMOOTH_ALPHA);
        let specular = material.specular > 0.0 || material.metallic > 0.0;
        effects.extend((smooth && specular).then_some(Effect::MirrorReflection));
        effects.extend((rough && specular).then_some(Effect::GlossyReflection));
        effects.extend((smooth && material.transmission > 0.0).then_some(Effect::ClearTransmission));
        effects.extend((rough && material.transmission > 0.0).then_some(Effect::RoughTransmission));
    }
    effects.into_iter().collect()
}

/// Which effects a material calls for.
fn of_material(material: &Material) -> Effects {
    let textures = [
        &material.base_color_texture,
        &material.metallic_roughness_texture,
        &material.specular_texture,
        &material.specular_color_texture,
        &material.transmission_texture,
        &material.specular_glossiness.and_then(|gloss| gloss.texture),
    ];
    let has_texture = |texture: &Option<TextureUse>| texture.is_some();
    let layers = material.layers.as_deref().filter(|layers| layers.has_effect());
    let of_layers = |layers: &MaterialLayers| layers.textures().iter().any(|(_, texture)| texture.is_some());
    let emits = material.emission.max_element() > 0.0;
    let found = [
        (Effect::Textures, textures.into_iter().any(has_texture) || layers.is_some_and(of_layers)),
        (Effect::NormalMaps, material.normal_texture.is_some()),
        (Effect::Layers, layers.is_some()),
        (Effect::DiffuseTransmission, layers.is_some_and(|layers| layers.diffuse_transmission > 0.0)),
        (Effect::Dispersion, material.disperses()),
        (Effect::Absorption, material.is_solid() && material.absorption.max_element() > 0.0),
        (Effect::Scattering, material.medium().scatters()),
        (Effect::Masks, matches!(material.alpha_mode, AlphaMode::Mask { .. })),
        (Effect::Blending, material.alpha_mode == AlphaMode::Blend),
        (Effect::EmittingSurfaces, emits),
        (Effect::TexturedEmission, emits && material.emission_texture.is_some()),
    ];
    found.into_iter().filter(|(_, found)| *found).map(|(effect, _)| effect).collect::<Effects>().with(lobes(material))
}

impl Census {
    /// Counts the effects of a scene that is seen by a camera.
    pub fn of(description: &SceneDescription, camera: Option<&CameraDescription>) -> Self {
        let none = |effect: &Effect| Finding { effect: *effect, materials: Vec::new(), triangles: 0, count: 0 };
        let mut findings: Vec<Finding> = Effect::ALL.iter().map(none).collect();
        let mut triangles_of = vec![0u64; description.materials.len()];
        let mut uses = vec![0u64; description.meshes.len()];
        for placement in &description.placements {
            let mesh = &description.meshes[placement.mesh];
            let triangles = mesh.triangles.len() as u64;
            triangles_of[placement.material] += triangles;
            uses[placement.mesh] += 1;
            if mesh.colors.as_ref().is_some_and(|colors| colors.iter().any(|color| *color != glam::DVec4::ONE)) {
                let finding = &mut findings[Effect::VertexColors as usize];
                finding.triangles += triangles;
                finding.count += 1;
            }
        }
        for (index, material) in description.materials.iter().enumerate() {
            // A material that nothing has calls for nothing.
            if triangles_of[index] == 0 {
                continue;
            }
            for effect in of_material(material).iter() {
                let finding = &mut findings[effect as usize];
                finding.materials.push(index);
                finding.triangles += triangles_of[index];
            }
        }
        for light in &description.lights {
            let effect = match light {
                PunctualLight::Point { .. } | PunctualLight::Spot { .. } => Effect::PointLights,
                PunctualLight::Directional { .. } => Effect::DistantLights,
            };
            findings[effect as usize].count += 1;
        }
        findings[Effect::Environment as usize].count =
            description.environment.iter().filter(|environment| environment.total_luminance() > 0.0).count() as u64;
        findings[Effect::Absorption as usize].count = u64::from(description.medium.absorption.max_element() > 0.0);
        findings[Effect::Scattering as usize].count = u64::from(description.medium.scatters());
        match camera.map(|camera| camera.projection) {
            Some(Projection::Perspective { lens: Some(_), .. }) => findings[Effect::Aperture as usize].count = 1,
            Some(Projection::Orthographic { .. }) => findings[Effect::Orthographic as usize].count = 1,
            _ => {}
        }
        let instances = &mut findings[Effect::Instances as usize];
        for (uses, mesh) in uses.into_iter().zip(&description.meshes).filter(|(uses, _)| *uses > 1) {
            instances.count += uses;
            instances.triangles += uses * mesh.triangles.len() as u64;
        }
        Self { findings }
    }

    /// One finding for each effect, in the order of [`Effect::ALL`].
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }

    /// What was found.
    pub fn effects(&self) -> Effects {
        let found = |finding: &&Finding| finding.triangles > 0 || finding.count > 0;
        self.findings.iter().filter(found).map(|finding| finding.effect).collect()
    }
}

/// Effects that people ask for or rule out, whatever the scene has.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Forced {
    /// To be ready for.
    pub on: Vec<Effect>,
    /// To be left out.
    pub off: Vec<Effect>,
}

/// What a scene is rendered with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Plan {
    /// What the scene has.
    pub found: Effects,
    /// What the code is ready for.
    pub on: Effects,
}

impl Plan {
    /// Whether code is to be ready for an effect.
    #[inline]
    pub fn has(&self, effect: Effect) -> bool {
        self.on.has(effect)
    }

    /// Effects that the scene does not have and code is ready for.
    pub fn idle(&self) -> Effects {
        self.on.without(self.found)
    }

    /// Effects that the scene has and the picture lacks.
    pub fn missing(&self) -> Effects {
        self.found.without(self.on)
    }
}

impl SceneDescription {
    /// The plan for this scene seen by `camera`: what the census found, less what is forced off, and what is forced on. What is forced
    /// off is taken out of both. A projection cannot be forced off.
    pub fn plan(&mut self, camera: &mut CameraDescription, forced: &Forced) -> Plan {
        let found = Census::of(self, Some(camera)).effects();
        let off: Effects = forced.off.iter().copied().collect();
        for effect in off.and(found).iter() {
            self.remove(effect);
        }
        if let Projection::Perspective { lens, .. } = &mut camera.projection
            && off.has(Effect::Aperture)
        {
            *lens = None;
        }
        let on = found.without(off).with(forced.on.iter().copied().collect::<Effects>().without(off));
        self.ready_for = on.without(found);
        Plan { found, on }
    }

    fn remove(&mut self, effect: Effect) {
        let smooth_alpha = SMOOTH_ALPHA.sqrt() * 1.01;
        for material in &mut self.materials {
            match effect {
                Effect::Textures => {
                    let layers = material.layers.as_deref_mut();
                    layers.into_iter().for_each(MaterialLayers::remove_textures);
                    material.base_color_texture = None;
                    material.metallic_roughness_texture = None;
                    material.specular_texture = None;
                    material.specular_color_texture = None;
                    material.transmission_texture = None;
                    if let Some(gloss) = &mut material.specular_glossiness {
                        gloss.texture = None;
                    }
                }
                Effect::NormalMaps => material.normal_texture = None,
                Effect::Layers => material.layers = None,
                Effect::DiffuseTransmission => {
                    material.layers.iter_mut().for_each(|layers| layers.diffuse_transmission = 0.0);
                }
                // The smoothest surface that is not specular.
                Effect::MirrorReflection | Effect::ClearTransmission => {
                    material.roughness = material.roughness.max(smooth_alpha);
                }
                Effect::RoughTransmission => material.transmission = 0.0,
                Effect::GlossyReflection => (material.specular, material.metallic) = (0.0, 0.0),
                Effect::Dispersion => material.dispersion = 0.0,
                Effect::Absorption => material.absorption = ergodic_scattering::Rgb::ZERO,
                Effect::Scattering => material.scattering = ergodic_scattering::Rgb::ZERO,
                Effect::Masks | Effect::Blending => {
                    let masked = matches!(material.alpha_mode, AlphaMode::Mask { .. });
                    if masked == (effect == Effect::Masks) {
                        material.alpha_mode = AlphaMode::Opaque;
                    }
                }
                Effect::EmittingSurfaces => material.emission = ergodic_scattering::Rgb::ZERO,
                Effect::TexturedEmission => material.emission_texture = None,
                _ => {}
            }
        }
        match effect {
            Effect::VertexColors => self.meshes.iter_mut().for_each(|mesh| mesh.colors = None),
            Effect::PointLights => self.lights.retain(|light| matches!(light, PunctualLight::Directional { .. })),
            Effect::DistantLights => self.lights.retain(|light| !matches!(light, PunctualLight::Directional { .. })),
            Effect::Environment => self.environment = None,
            Effect::Absorption => self.medium.absorption = ergodic_scattering::Rgb::ZERO,
            Effect::Scattering => self.medium.scattering = ergodic_scattering::Rgb::ZERO,
            // Every copy becomes a mesh of its own.
            Effect::Instances => {
                let mut seen = vec![false; self.meshes.len()];
                for placement in &mut self.placements {
                    if std::mem::replace(&mut seen[placement.mesh], true) {
                        self.meshes.push(self.meshes[placement.mesh].clone());
                        placement.mesh = self.meshes.len() - 1;
                    }
                }
            }
            _ => {}
        }
    }
}
