//! Surfaces with more than glTF's core: a coat over a sheen over a layered base with thin film, diffuse transmission and
//! anisotropic roughness. KHR_materials_clearcoat, _sheen, _iridescence, _diffuse_transmission, _anisotropy.
//!
//! With k_c what the coat lets through and k_s what the sheen does, both the same for light and eye exchanged,
//!
//! f = coat + k_c (sheen + k_s base).
//!
//! Materials without any of this are [`crate::Layered`] and cost nothing more. An [`Extended`] is stored in few bytes and
//! unpacked where it is asked. Local directions: z is the cosine with the shading normal; x is along the anisotropy.

use glam::DVec3;

use crate::coat::Coat;
use crate::effects::FilmAndTranslucency;
use crate::ggx::Anisotropic;
use crate::interaction::Component;
use crate::layered::Selection;
use crate::packed::{Direction, Share, color, shares};
use crate::sheen::{self, Sheen};
use crate::thin_film::ThinFilm;
use crate::{Layered, Parameters, Rgb, SMOOTH_ALPHA, dirac};

/// What an [`Extended`] surface has over its base, after textures. The defaults are without effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExtendedParameters {
    /// clearcoatFactor.
    pub coat: f64,
    /// GGX's alpha of the coat.
    pub coat_alpha: f64,
    /// The coat's normal in the shading frame, where it is not the base's.
    pub coat_normal: Option<DVec3>,
    /// sheenColorFactor.
    pub sheen_color: Rgb,
    /// sheenRoughnessFactor.
    pub sheen_roughness: f64,
    /// anisotropyStrength.
    pub anisotropy: f64,
    /// iridescenceFactor.
    pub film: f64,
    /// iridescenceIor.
    pub film_ior: f64,
    /// Thickness of the film in nanometres.
    pub film_thickness: f64,
    /// diffuseTransmissionFactor.
    pub translucency: f64,
    /// diffuseTransmissionColorFactor.
    pub translucent_color: Rgb,
}

impl Default for ExtendedParameters {
    fn default() -> Self {
        Self {
            coat: 0.0,
            coat_alpha: 0.0,
            coat_normal: None,
            sheen_color: Rgb::ZERO,
            sheen_roughness: 0.0,
            anisotropy: 0.0,
            film: 0.0,
            film_ior: 1.3,
            film_thickness: 400.0,
            translucency: 0.0,
            translucent_color: Rgb::ONE,
        }
    }
}

impl ExtendedParameters {
    /// Whether anything here changes the base.
    pub fn has_effect(&self) -> bool {
        self.coat > 0.0
            || self.sheen_color != Rgb::ZERO
            || self.anisotropy > 0.0
            || self.film > 0.0
            || self.translucency > 0.0
    }
}

/// A surface with layers and effects at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extended {
    base: [f32; 3],
    specular_color: [f32; 3],
    ior: f32,
    alpha: [f32; 2],
    coat_alpha: f32,
    coat_normal: Direction,
    film_ior: f32,
    film_thickness: f32,
    specular: Share,
    metallic: Share,
    transmission: Share,
    coat: Share,
    sheen: [Share; 3],
    sheen_roughness: Share,
    film: Share,
    translucency: Share,
    translucent_color: [Share; 3],
    transmissive: bool,
    solid: bool,
    dispersive: bool,
    /// Whether the coat has a normal of its own.
    tilted: bool,
}

/// The same, unpacked.
struct Stack {
    base: Layered<Anisotropic, FilmAndTranslucency>,
    sheen: Sheen,
    coat: Coat,
    solid: bool,
}

/// Probabilities of choosing each layer, and of each of the base's lobes once it is chosen.
struct Choice {
    coat: f64,
    sheen: f64,
    base: f64,
    lobes: Selection,
}

impl Extended {
    /// The surface with the base's parameters and these effects.
    pub fn new(p: &Parameters, effects: &ExtendedParameters) -> Self {
        let alpha = p.alpha.clamp(0.0, 1.0);
        let strength = effects.anisotropy.clamp(0.0, 1.0);
        let along = alpha + (1.0 - alpha) * strength * strength;
        // A surface that is rough along one axis only would scatter into a curve.
        let across = if along >= SMOOTH_ALPHA { alpha.max(SMOOTH_ALPHA) } else { alpha };
        // A smooth coat and a smooth base with other normals would make two mirror directions; there is room for one.
        let mirror = along < SMOOTH_ALPHA;
        let coat_alpha = effects.coat_alpha.clamp(0.0, 1.0);
        let coat_alpha =
            if mirror && effects.coat_normal.is_some() { coat_alpha.max(SMOOTH_ALPHA) } else { coat_alpha };
        let single = |color: Rgb| color.as_vec3().to_array();
        Self {
            base: single(p.base),
            specular_color: single(p.specular_color),
            ior: p.ior as f32,
            alpha: [along as f32, across as f32],
            coat_alpha: coat_alpha as f32,
            coat_normal: Direction::new(effects.coat_normal.unwrap_or(DVec3::Z)),
            film_ior: effects.film_ior as f32,
            film_thickness: effects.film_thickness as f32,
            specular: Share::new(p.specular),
            metallic: Share::new(p.metallic),
            transmission: Share::new(p.transmission),
            coat: Share::new(effects.coat),
            sheen: shares(effects.sheen_color),
            sheen_roughness: Share::new(effects.sheen_roughness),
            film: Share::new(effects.film),
            translucency: Share::new(effects.translucency),
            translucent_color: shares(effects.translucent_color),
            transmissive: p.transmissive,
            solid: p.solid,
            dispersive: p.dispersive,
            tilted: effects.coat_normal.is_some(),
        }
    }

    #[inline]
    fn stack(&self) -> Stack {
        let double = |color: [f32; 3]| Rgb::from_array(color.map(f64::from));
        let [x, y] = self.alpha.map(f64::from);
        let parameters = Parameters {
            base: double(self.base),
            metallic: self.metallic.get(),
            alpha: x,
            ior: f64::from(self.ior),
            specular: self.specular.get(),
            specular_color: double(self.specular_color),
            transmission: self.transmission.get(),
            transmissive: self.transmissive,
            solid: self.solid,
            dispersive: self.dispersive,
        };
        let film = ThinFilm {
            strength: self.film.get(),
            ior: f64::from(self.film_ior),
            thickness: f64::from(self.film_thickness),
        };
        let effects = FilmAndTranslucency {
            film,
            translucency: self.translucency.get(),
            translucent_color: color(self.translucent_color),
        };
        let normal = self.tilted.then(|| self.coat_normal.get());
        Stack {
            base: Layered::with(&parameters, Anisotropic { x, y }, effects),
            sheen: Sheen::new(color(self.sheen), self.sheen_roughness.get()),
            coat: Coat::new(self.coat.get(), f64::from(self.coat_alpha), normal, !self.solid),
            solid: self.solid,
        }
    }

    /// Whether a medium of its own index lies below.
    #[inline]
    pub(crate) fn is_solid(&self) -> bool {
        self.solid
    }

    /// Whether the surface is that for one wavelength.
    #[inline]
    pub(crate) fn is_dispersive(&self) -> bool {
        self.dispersive
    }

    /// Index of refraction below the surface relative to above.
    #[inline]
    pub(crate) fn index_below(&self) -> f64 {
        if self.solid { f64::from(self.ior) } else { 1.0 }
    }

    /// Whether any lobe belongs to `component`.
    #[inline]
    pub(crate) fn has(&self, component: Component) -> bool {
        let stack = self.stack();
        stack.base.has(component)
            || match component {
                Component::Rough => stack.sheen.is_present() || (stack.coat.is_present() && !stack.coat.is_smooth()),
                Component::DiracReflection => stack.coat.is_smooth(),
                Component::DiracTransmission => false,
            }
    }

    /// The share of light emitted below the layers that leaves along `w`.
    #[inline]
    pub(crate) fn emission_factor(&self, w: DVec3) -> f64 {
        1.0 - self.stack().coat.shadow(w)
    }

    /// See [`crate::Interaction::dirac_density`].
    #[inline]
    pub(crate) fn dirac_density(&self, to: DVec3, component: Component) -> f64 {
        let stack = self.stack();
        match component {
            Component::DiracReflection if stack.coat_is_the_mirror() => stack.coat.cosine(to),
            Component::Rough => 0.0,
            _ if stack.base.has(component) => stack.base.dirac_density(to.z),
            _ => 0.0,
        }
    }

    /// The scattering function in 1/sr from `light` to `eye`; see [`crate::Interaction::eval`].
    #[inline]
    pub(crate) fn eval(&self, light: DVec3, eye: DVec3, component: Component) -> Rgb {
        let stack = self.stack();
        let below = stack.coat.shadow(light).max(stack.coat.shadow(eye));
        let mut f = stack.base.eval(light, eye, component);
        if stack.sheen.is_present() {
            f = stack.under_sheen(f, light, eye, component);
        }
        f *= 1.0 - below;
        if light.z * eye.z > 0.0 {
            f += match component {
                Component::Rough => stack.coat.value(light, eye),
                Component::DiracReflection => stack.coat.mirror_value(light, eye),
                Component::DiracTransmission => 0.0,
            };
        }
        f
    }

    /// Density of sampling `to` given `from`; see [`crate::Interaction::pdf`].
    #[inline]
    pub(crate) fn pdf(&self, from: DVec3, to: DVec3, component: Component) -> f64 {
        let stack = self.stack();
        let choice = stack.choice(from);
        let mut pdf = choice.base * stack.base.pdf_with(&choice.lobes, from, to, component);
        if from.z * to.z > 0.0 {
            match component {
                Component::Rough => {
                    pdf += choice.sheen * sheen::PDF;
                    if choice.coat > 0.0 {
                        pdf += choice.coat * stack.coat.pdf(from, to);
                    }
                }
                Component::DiracReflection if choice.coat > 0.0 && stack.coat.is_smooth() => {
                    pdf += choice.coat * stack.coat.cosine(to);
                }
                _ => {}
            }
        }
        pdf
    }

    /// The probabilities of choosing a Dirac reflection and a Dirac transmission for light from `from`.
    #[inline]
    pub(crate) fn dirac_probabilities(&self, from: DVec3) -> [f64; 2] {
        let stack = self.stack();
        let of_coat = stack.coat.is_smooth();
        if !of_coat && !stack.base.has_dirac() {
            return [0.0; 2];
        }
        let choice = stack.choice(from);
        let [reflection, transmission] = stack.base.dirac_probabilities(&choice.lobes).map(|p| p * choice.base);
        [reflection + if of_coat { choice.coat } else { 0.0 }, transmission]
    }

    /// A direction drawn with [`Self::pdf`].
    #[inline]
    pub(crate) fn sample(&self, from: DVec3, u: [f64; 3]) -> Option<(DVec3, Component)> {
        let stack = self.stack();
        let choice = stack.choice(from);
        let rest = [u[1], u[2]];
        if choice.coat > 0.0 && u[0] < choice.coat {
            if stack.coat.is_smooth() {
                return stack.coat.mirror(from).map(|to| (to, Component::DiracReflection));
            }
            return stack.coat.sample(from, rest).map(|to| (to, Component::Rough));
        }
        let u0 = u[0] - choice.coat;
        if choice.sheen > 0.0 && (u0 < choice.sheen || choice.base == 0.0) {
            let to = sheen::sample(rest);
            return Some((DVec3::new(to.x, to.y, to.z.copysign(from.z)), Component::Rough));
        }
        if choice.base == 0.0 {
            return None;
        }
        let u0 = ((u0 - choice.sheen) / choice.base).clamp(0.0, 1.0);
        stack.base.sample_with(&choice.lobes, from, [u0, u[1], u[2]])
    }

    /// The direction that a Dirac component leads to from `from`.
    #[inline]
    pub(crate) fn dirac_direction(&self, from: DVec3, component: Component) -> Option<DVec3> {
        let stack = self.stack();
        if component != Component::DiracReflection {
            return stack.base.dirac_direction(from, component);
        }
        if stack.base.has(component) {
            // The coat's mirror, if there is one, has the same normal.
            let up = dirac::reflected(DVec3::new(from.x, from.y, from.z.abs()));
            return Some(DVec3::new(up.x, up.y, up.z.copysign(from.z)));
        }
        stack.coat.mirror(from)
    }
}

impl Stack {
    /// Whether the mirror reflection is the coat's alone, about its own normal.
    #[inline]
    fn coat_is_the_mirror(&self) -> bool {
        self.coat.is_smooth() && !self.base.has(Component::DiracReflection)
    }

    /// Whether the side that `w` lies on has the sheen: a solid has it outside.
    #[inline]
    fn has_sheen(&self, w: DVec3) -> bool {
        self.sheen.is_present() && (!self.solid || w.z > 0.0)
    }

    /// What the base scatters, `base`, with the sheen over it.
    #[inline]
    fn under_sheen(&self, base: Rgb, light: DVec3, eye: DVec3, component: Component) -> Rgb {
        let up = |w: DVec3| DVec3::new(w.x, w.y, w.z.abs());
        let same_side = light.z * eye.z > 0.0;
        if component == Component::Rough && same_side && self.has_sheen(eye) {
            let (lobe, through) = self.sheen.value(up(light), up(eye));
            return lobe + base * through;
        }
        let shadow = |w: DVec3| if self.has_sheen(w) { self.sheen.shadow(w.z.abs()) } else { 0.0 };
        base * (1.0 - shadow(light).max(shadow(eye)))
    }

    /// The probabilities of choosing each layer for light from `w`: the one place where they are made.
    #[inline]
    fn choice(&self, w: DVec3) -> Choice {
        let lobes = self.base.weights(w);
        let coat = self.coat.selection_weight(w);
        let below = 1.0 - self.coat.shadow(w);
        let (mut sheen, mut through) = (0.0, 1.0);
        if self.has_sheen(w) {
            sheen = below * self.sheen.weight(w.z.abs());
            through = 1.0 - self.sheen.shadow(w.z.abs());
        }
        let base = lobes.sum() * (below * through);
        let sum = coat + sheen + base;
        let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        Choice { coat: coat * scale, sheen: sheen * scale, base: base * scale, lobes: lobes.normalized() }
    }
}
