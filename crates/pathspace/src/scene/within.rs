//! Which code a scene is rendered by: the smallest that has all its effects.

use super::*;

/// Work on a scene that is compiled once for each repertoire.
pub trait Within {
    /// What it comes to; the same whatever the repertoire.
    type Output;

    /// Does it by code of the repertoire R, which has all that the scene calls for.
    fn run<R: Repertoire>(self, scene: &Scene<R>) -> Self::Output;
}

/// The effects that code of a repertoire renders. One that is not listed here is rendered by [`Everything`] alone.
fn rendered_by<R: Repertoire>() -> Effects {
    use Effect::*;
    let groups: [(bool, &[Effect]); 10] = [
        // What they cost is not known to the code that has a repertoire.
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

impl Parts {
    /// Whether code of a repertoire renders this scene: it has no effect, forced on or not, and no surface that the repertoire lacks.
    fn fits<R: Repertoire>(&self) -> bool {
        let is_there = |bsdf: &Option<Bsdf>| match bsdf {
            None => R::TEXTURES,
            Some(Bsdf::Lambert(_)) => true,
            Some(Bsdf::Layered(_)) => R::LOBES,
            Some(Bsdf::Extended(_)) => R::LAYERS,
            Some(Bsdf::Phase(_)) => R::SCATTERING,
        };
        self.effects.without(rendered_by::<R>()).is_empty() && self.constant.iter().all(is_there)
    }
}

impl Scene {
    fn of<R: Repertoire>(&self) -> Scene<R> {
        Scene { parts: Arc::clone(&self.parts), camera: self.camera.within() }
    }

    /// Does `work` by the smallest code that has all that the scene calls for.
    pub fn within<W: Within>(&self, work: W) -> W::Output {
        if self.parts.fits::<Matte>() {
            work.run(&self.of::<Matte>())
        } else if self.parts.fits::<Core>() {
            work.run(&self.of::<Core>())
        } else {
            work.run(self)
        }
    }

    /// What the repertoire is called that [`Self::within`] chooses.
    pub fn repertoire(&self) -> &'static str {
        struct Name;
        impl Within for Name {
            type Output = &'static str;

            fn run<R: Repertoire>(self, _: &Scene<R>) -> &'static str {
                R::NAME
            }
        }
        self.within(Name)
    }
}
