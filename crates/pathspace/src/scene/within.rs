//! Which code a scene is rendered by: the smallest that has all its effects.

use super::*;

/// Work on a scene that is compiled once for each repertoire.
pub trait Within {
    /// What it comes to; the same whatever the repertoire.
    type Output;

    /// Does it by code of the repertoire R, which has all that the scene calls for.
    fn run<R: Repertoire>(self, scene: &Scene<R>) -> Self::Output;
}

/// The repertoires that code is compiled for, from the smallest on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compiled {
    /// [`Matte`].
    Matte,
    /// [`Core`].
    Core,
    /// [`Everything`].
    Everything,
}

/// The effects that code of a repertoire renders. One that is not listed here is rendered by [`Everything`] alone.
fn rendered_by<R: Repertoire>() -> Effects {
    use Effect::*;
    let groups: [(bool, &[Effect]); 10] = [
        // Code that has a repertoire is the same with and without them.
        (true, &[EmittingSurfaces, Instances]),
        (R::LOBES, &[GlossyReflection, MirrorReflection, RoughTransmission, ClearTransmission]),
        (R::LAYERS, &[Layers, DiffuseTransmission]),
        (R::TEXTURES, &[Textures, NormalMaps, VertexColors, TexturedEmission]),
        (R::MEDIA, &[Absorption]),
        (R::SCATTERING, &[Scattering]),
        (R::COVERAGE, &[Masks, Blending]),
        (R::DISPERSION, &[Dispersion]),
        (R::OTHER_LIGHTS, &[PointLights, DistantLights, Environment]),
        (R::OTHER_CAMERAS, &[Aperture, Orthographic]),
    ];
    groups.iter().filter(|(has, _)| *has).flat_map(|(_, effects)| effects.iter().copied()).collect()
}

/// Whether code of a repertoire renders a scene with these effects, forced on or not, and these materials.
fn fits<R: Repertoire>(effects: Effects, materials: &[Material]) -> bool {
    let is_there = |material: &Material| match material.constant_bsdf() {
        None => R::TEXTURES,
        Some(Bsdf::Lambert(_)) => true,
        Some(Bsdf::Layered(_)) => R::LOBES,
        Some(Bsdf::Extended(_)) => R::LAYERS,
        Some(Bsdf::Phase(_)) => R::SCATTERING,
    };
    effects.without(rendered_by::<R>()).is_empty() && materials.iter().all(is_there)
}

impl Compiled {
    /// The smallest that renders a scene with these effects and materials.
    pub fn smallest(effects: Effects, materials: &[Material]) -> Self {
        if fits::<Matte>(effects, materials) {
            Self::Matte
        } else if fits::<Core>(effects, materials) {
            Self::Core
        } else {
            Self::Everything
        }
    }

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Matte => Matte::NAME,
            Self::Core => Core::NAME,
            Self::Everything => Everything::NAME,
        }
    }

    /// What it has.
    pub fn about(self) -> &'static str {
        match self {
            Self::Matte => Matte::ABOUT,
            Self::Core => Core::ABOUT,
            Self::Everything => Everything::ABOUT,
        }
    }
}

impl Scene {
    fn of<R: Repertoire>(&self) -> Scene<R> {
        Scene { parts: Arc::clone(&self.parts), camera: self.camera.within() }
    }

    /// Does `work` by the smallest code that has all that the scene calls for, which is [`Self::repertoire`]'s.
    pub fn within<W: Within>(&self, work: W) -> W::Output {
        match self.repertoire() {
            Compiled::Matte => work.run(&self.of::<Matte>()),
            Compiled::Core => work.run(&self.of::<Core>()),
            Compiled::Everything => work.run(self),
        }
    }
}

impl<R: Repertoire> Scene<R> {
    /// The smallest repertoire that has all that the scene calls for.
    pub fn repertoire(&self) -> Compiled {
        self.parts.repertoire
    }
}
