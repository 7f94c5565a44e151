//! glTF's surface: a Fresnel-weighted specular lobe over a mixture of diffuse reflection and transmission.
//!
//! glTF 2.0, appendix B; KHR_materials_specular, _ior, _transmission, _volume. With m metallic, t transmission, F the
//! dielectric's reflectance and F_m the metal's, the lobes are
//!
//! | lobe | factor |
//! |---|---|
//! | reflection | (1 - m) F + m F_m |
//! | diffuse | (1 - m) (1 - t) min(1 - max F, c) base |
//! | transmission | (1 - m) t (1 - max F) base |
//!
//! The cap c on the diffuse lobe is not glTF's: by its formula the lobe gains energy at grazing angles, where the dielectric
//! reflects almost all, but facets between the eye and light from everywhere do not. With E(w) the dielectric's directional
//! albedo, c is the lesser (1 - E(w)) / base of light and eye, so that what both lobes make of light along w is at most
//! E(w) + (1 - E(w)) = 1. Where E(w) + (1 - max F) base <= 1 in both directions, the lobe is the formula's to the bit.
//! Metal and transmission need no cap, for they are mixed with the dielectric by shares.
//!
//! What only some materials have (a thin film, diffuse transmission, different roughness along two axes) is in the type
//! parameters, so that the common surface, `Layered<f64, Plain>`, does not pay for it.
//!
//! Local directions: z is the cosine with the shading normal, z < 0 the other side. Solids have a medium of index `ior`
//! there; every other surface is the same from both sides.

use glam::DVec3;

use crate::effects::{Effects, Plain};
use crate::fresnel::DielectricFresnel;
use crate::ggx::Roughness;
use crate::interaction::Component;
use crate::{Rgb, SMOOTH_ALPHA, dirac, lambert, luminance};
use crate::{microfacet_reflection, microfacet_refraction, thin_transmission};

mod cap;

use cap::capped;

/// Solids whose index is this close to that of the outside refract as if they were smooth: the rough lobe would be a
/// thousand times narrower than the roughness that makes it.
const INDEX_MATCHED: f64 = 1e-3;

/// Lobes that vary over the microfacets are chosen with at least this share of their largest reflectance.
pub(crate) const SELECTION_FLOOR: f64 = 0.05;

/// What makes a [`Layered`] surface, after textures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Base colour.
    pub base: Rgb,
    /// Share of metal in [0, 1].
    pub metallic: f64,
    /// GGX's alpha: the square of the perceptual roughness.
    pub alpha: f64,
    /// Index of refraction.
    pub ior: f64,
    /// KHR_materials_specular's factor.
    pub specular: f64,
    /// KHR_materials_specular's colour.
    pub specular_color: Rgb,
    /// Share of the light under the specular layer that is transmitted, in [0, 1].
    pub transmission: f64,
    /// The surface belongs to a material that transmits, here or elsewhere: its reflectance is the exact one.
    pub transmissive: bool,
    /// The surface bounds a refracting solid; it must be `transmissive`.
    pub solid: bool,
    /// The index depends on the wavelength, and is the one at that of the light.
    pub dispersive: bool,
}

/// A lobe and the form it takes at this point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lobe {
    Absent,
    Diffuse,
    DiffuseTransmission,
    RoughReflection,
    MirrorReflection,
    RoughRefraction,
    SmoothRefraction,
    RoughThin,
    StraightThin,
}

impl Lobe {
    #[inline]
    fn component(self) -> Option<Component> {
        match self {
            Self::Absent => None,
            Self::Diffuse
            | Self::DiffuseTransmission
            | Self::RoughReflection
            | Self::RoughRefraction
            | Self::RoughThin => Some(Component::Rough),
            Self::MirrorReflection => Some(Component::DiracReflection),
            Self::SmoothRefraction | Self::StraightThin => Some(Component::DiracTransmission),
        }
    }
}

/// The layered surface at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layered<R = f64, E = Plain> {
    base: Rgb,
    dielectric: DielectricFresnel,
    metallic: f64,
    transmission: f64,
    alpha: R,
    effects: E,
    solid: bool,
    dispersive: bool,
    diffuse: Lobe,
    translucent: Lobe,
    reflection: Lobe,
    transmitted: Lobe,
}

/// Weights or probabilities of choosing each lobe.
#[derive(Clone, Copy)]
pub(crate) struct Selection {
    diffuse: f64,
    translucent: f64,
    reflection: f64,
    transmitted: f64,
}

impl Selection {
    /// The sum of the weights: about the share of the light that is scattered.
    #[inline]
    pub(crate) fn sum(&self) -> f64 {
        self.diffuse + self.reflection + self.transmitted + self.translucent
    }

    /// Weights made probabilities.
    #[inline]
    pub(crate) fn normalized(&self) -> Self {
        let sum = self.sum();
        let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        Self {
            diffuse: self.diffuse * scale,
            translucent: self.translucent * scale,
            reflection: self.reflection * scale,
            transmitted: self.transmitted * scale,
        }
    }
}

impl Layered {
    /// The surface with these parameters.
    pub fn new(p: &Parameters) -> Self {
        Self::with(p, p.alpha.clamp(0.0, 1.0), Plain)
    }
}

impl<R: Roughness, E: Effects> Layered<R, E> {
    /// The surface with these parameters, but for the roughness, which is `alpha`, and with `effects`.
    pub(crate) fn with(p: &Parameters, alpha: R, effects: E) -> Self {
        let dielectric = DielectricFresnel::new(p.ior, p.specular, p.specular_color, p.transmissive);
        let smooth = alpha.largest() < SMOOTH_ALPHA;
        let under = p.metallic < 1.0 && p.base != Rgb::ZERO;
        let (translucency, translucent_color) = effects.diffuse_transmission();
        let translucent = E::TRANSLUCENT
            && translucency > 0.0
            && translucent_color != Rgb::ZERO
            && p.metallic < 1.0
            && p.transmission < 1.0;
        let diffuse = if E::TRANSLUCENT {
            // In a solid, what cannot get out is reflected.
            translucent && p.solid || under && p.transmission < 1.0 && translucency < 1.0
        } else {
            under && p.transmission < 1.0
        };
        let reflection = if p.metallic == 0.0 && dielectric.is_zero() && !effects.has_film() {
            Lobe::Absent
        } else if smooth {
            Lobe::MirrorReflection
        } else {
            Lobe::RoughReflection
        };
        let transmitted = match (under && p.transmission > 0.0, p.solid) {
            (false, _) => Lobe::Absent,
            (true, true) if smooth || (p.ior - 1.0).abs() < INDEX_MATCHED => Lobe::SmoothRefraction,
            (true, true) => Lobe::RoughRefraction,
            (true, false) if smooth => Lobe::StraightThin,
            (true, false) => Lobe::RoughThin,
        };
        Self {
            base: p.base,
            dielectric,
            metallic: p.metallic,
            transmission: p.transmission,
            alpha,
            effects,
            solid: p.solid,
            dispersive: p.dispersive,
            diffuse: if diffuse { Lobe::Diffuse } else { Lobe::Absent },
            translucent: if translucent { Lobe::DiffuseTransmission } else { Lobe::Absent },
            reflection,
            transmitted,
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

    /// Whether any lobe belongs to `component`.
    #[inline]
    pub(crate) fn has(&self, component: Component) -> bool {
        [self.diffuse, self.reflection, self.transmitted].iter().any(|lobe| lobe.component() == Some(component))
            || (E::TRANSLUCENT && self.translucent.component() == Some(component))
    }

    /// Whether any lobe is Dirac.
    #[inline]
    pub(crate) fn has_dirac(&self) -> bool {
        self.has(Component::DiracReflection) || self.has(Component::DiracTransmission)
    }

    /// The probabilities of choosing a Dirac reflection and a Dirac transmission, given those of the lobes.
    #[inline]
    pub(crate) fn dirac_probabilities(&self, selection: &Selection) -> [f64; 2] {
        let of = |lobe: Lobe, probability| if lobe.component() == Some(Component::Rough) { 0.0 } else { probability };
        [of(self.reflection, selection.reflection), of(self.transmitted, selection.transmitted)]
    }

    /// Whether `w` lies in the medium below.
    #[inline]
    fn is_inside(&self, w: DVec3) -> bool {
        self.solid && w.z < 0.0
    }

    /// Index of refraction of the medium that `w` lies in.
    #[inline]
    pub(crate) fn index(&self, w: DVec3) -> f64 {
        if self.is_inside(w) { self.dielectric.ior } else { 1.0 }
    }

    /// Factor of the reflection lobe for light at cosine `cos` with its facet, given the dielectric's reflectance there.
    #[inline]
    fn reflectance(&self, cos: f64, dielectric: Rgb, inside: bool) -> Rgb {
        let outer = dielectric * (1.0 - self.metallic);
        if self.metallic == 0.0 || inside {
            return outer;
        }
        outer + self.effects.conductor(self.base, cos) * self.metallic
    }

    /// The dielectric's reflectance for a ray at cosine `cos` with its facet.
    #[inline]
    fn dielectric_at(&self, cos: f64, inside: bool) -> Rgb {
        self.effects.dielectric(&self.dielectric, cos, inside)
    }

    /// Whether the diffuse lobe scatters light on this side: inside a solid only if light gets there diffusely.
    #[inline]
    fn has_diffuse(&self, inside: bool) -> bool {
        self.diffuse == Lobe::Diffuse && (!inside || (E::TRANSLUCENT && self.translucent != Lobe::Absent))
    }

    /// Colour of all diffuse light, reflected and transmitted.
    #[inline]
    fn diffuse_color(&self) -> Rgb {
        if !E::TRANSLUCENT {
            return self.base;
        }
        let (share, color) = self.effects.diffuse_transmission();
        self.base * (1.0 - share) + color * share
    }

    /// Factor of the diffuse lobe of which the share `kept` is left.
    #[inline]
    fn diffuse_factor(&self, kept: f64, inside: bool) -> Rgb {
        let under = (1.0 - self.metallic) * (1.0 - self.transmission) * kept;
        if !E::TRANSLUCENT {
            return self.base * under;
        }
        let (share, color) = self.effects.diffuse_transmission();
        (self.base * (1.0 - share) + color * (share * (1.0 - self.escaping(inside)))) * under
    }

    /// The share of what is to be transmitted diffusely that gets across from this side. Radiance from all directions
    /// fills n^2 times as much étendue where the index is n; what does not fit is reflected.
    #[inline]
    fn escaping(&self, inside: bool) -> f64 {
        if !self.solid {
            return 1.0;
        }
        let n2 = self.dielectric.ior * self.dielectric.ior;
        (if inside { 1.0 / n2 } else { n2 }).min(1.0)
    }

    /// Factor of diffuse transmission from this side of which the share `kept` is left.
    #[inline]
    fn translucent_factor(&self, kept: f64, from_inside: bool) -> Rgb {
        let (share, color) = self.effects.diffuse_transmission();
        let under = (1.0 - self.metallic) * (1.0 - self.transmission) * kept;
        color * (under * share * self.escaping(from_inside))
    }

    /// Factor of the transmission lobe.
    #[inline]
    fn transmittance(&self, dielectric: Rgb) -> Rgb {
        self.base * ((1.0 - self.metallic) * self.transmission * through(dielectric))
    }

    /// The weights of choosing each lobe, for light from `w`: the one place where they are made. Near enough to the
    /// lobes' albedos, and above 0 wherever the lobe is.
    #[inline]
    pub(crate) fn weights(&self, w: DVec3) -> Selection {
        let inside = self.is_inside(w);
        let cos = w.z.abs();
        // Rough facets are on average met less obliquely than the surface: at grazing incidence at a cosine of about
        // 2 alpha while alpha is small.
        let alpha = self.alpha.largest();
        let softened = cos + (1.0 - cos) * (1.0 - cos) * alpha / (alpha + 0.5);
        let at = |cos: f64| self.dielectric_at(cos, inside);
        let reflected = at(if self.reflection == Lobe::MirrorReflection { cos } else { softened });
        let floored = |factor: Rgb, largest: f64| luminance(factor).max(SELECTION_FLOOR * largest);
        let under = luminance(self.base) * (1.0 - self.metallic);
        // The light that comes back along the normal stands for all of it, and leaves room for what is reflected.
        let kept = |inside: bool| {
            let kept = through(self.dielectric_at((0.5 * (1.0 + cos)).sqrt(), inside));
            if self.reflection == Lobe::Absent { kept } else { capped(kept, self.diffuse_color(), reflected) }
        };
        let diffuse = if self.has_diffuse(inside) {
            let largest = if E::TRANSLUCENT {
                luminance(self.diffuse_factor(1.0, inside))
            } else {
                under * (1.0 - self.transmission)
            };
            floored(self.diffuse_factor(kept(inside), inside), largest)
        } else {
            0.0
        };
        let translucent = if E::TRANSLUCENT && self.translucent != Lobe::Absent {
            let largest = luminance(self.translucent_factor(1.0, inside));
            floored(self.translucent_factor(kept(self.solid), inside), largest)
        } else {
            0.0
        };
        let reflection = match self.reflection {
            Lobe::Absent => 0.0,
            Lobe::MirrorReflection => luminance(self.reflectance(cos, reflected, inside)),
            _ => {
                let grazing = self.reflectance(0.0, Rgb::splat(self.dielectric.f90), inside);
                floored(self.reflectance(softened, reflected, inside), luminance(grazing))
            }
        };
        let transmitted = match self.transmitted {
            Lobe::Absent => 0.0,
            Lobe::SmoothRefraction | Lobe::StraightThin => luminance(self.transmittance(at(cos))),
            _ => floored(self.transmittance(at(softened)), under * self.transmission),
        };
        Selection { diffuse, translucent, reflection, transmitted }
    }

    /// The probabilities of choosing each lobe, for light from `w`.
    #[inline]
    pub(crate) fn selection(&self, w: DVec3) -> Selection {
        self.weights(w).normalized()
    }

    /// The scattering function in 1/sr from `light` to `eye`; the coefficient times n_eye^2 for a Dirac component.
    #[inline]
    pub(crate) fn eval(&self, light: DVec3, eye: DVec3, component: Component) -> Rgb {
        let inside = self.is_inside(eye);
        let same_side = light.z * eye.z > 0.0;
        match component {
            Component::Rough if same_side => self.eval_reflected(light, eye, inside),
            Component::Rough => self.eval_transmitted(light, eye, inside),
            Component::DiracReflection if same_side && self.reflection == Lobe::MirrorReflection => {
                let n = self.index(eye);
                let cos = eye.z.abs();
                self.reflectance(cos, self.dielectric_at(cos, inside), inside) * (n * n)
            }
            Component::DiracTransmission if !same_side => match self.transmitted {
                Lobe::SmoothRefraction => {
                    let n = self.index(eye);
                    let (outside, below) = if inside { (light.z, -eye.z) } else { (eye.z, -light.z) };
                    self.transmittance(self.effects.across(&self.dielectric, outside, below)) * (n * n)
                }
                Lobe::StraightThin => self.transmittance(self.dielectric_at(eye.z.abs(), false)),
                _ => Rgb::ZERO,
            },
            _ => Rgb::ZERO,
        }
    }

    #[inline]
    fn eval_reflected(&self, light: DVec3, eye: DVec3, inside: bool) -> Rgb {
        let sum = light + eye;
        let length = sum.length();
        // The cosine with the half vector, the same from both directions to the last bit.
        let cos = 0.5 * length;
        let dielectric = self.dielectric_at(cos, inside);
        let mut f = Rgb::ZERO;
        if self.has_diffuse(inside) {
            f += lambert::value(self.diffuse_factor(self.kept(dielectric, light, eye), inside));
        }
        if self.reflection == Lobe::RoughReflection {
            let lobe = microfacet_reflection::value(self.alpha, light, eye, sum / length);
            f += self.reflectance(cos, dielectric, inside) * lobe;
        }
        f
    }

    #[inline]
    fn eval_transmitted(&self, light: DVec3, eye: DVec3, inside: bool) -> Rgb {
        let specular = self.eval_transmitted_specularly(light, eye, inside);
        if E::TRANSLUCENT && self.translucent != Lobe::Absent {
            return specular + self.eval_translucent(light, eye);
        }
        specular
    }

    /// The diffuse transmission. Its Fresnel factor is that of the pair with one direction mirrored to the other's side,
    /// as for the thin wall, so that it is the same both ways.
    #[inline]
    fn eval_translucent(&self, light: DVec3, eye: DVec3) -> Rgb {
        let cos = 0.5 * (thin_transmission::mirrored(light) + eye).length();
        let kept = self.kept(self.dielectric_at(cos, self.solid), light, eye);
        lambert::value(self.translucent_factor(kept, self.is_inside(light)))
    }

    #[inline]
    fn eval_transmitted_specularly(&self, light: DVec3, eye: DVec3, inside: bool) -> Rgb {
        match self.transmitted {
            Lobe::RoughRefraction => {
                let (n_light, n_eye) = (self.index(light), self.index(eye));
                let Some(facet) = microfacet_refraction::facet(light, n_light, eye, n_eye) else {
                    return Rgb::ZERO;
                };
                let (outside, below) = if inside { (facet.cos_a, facet.cos_b) } else { (facet.cos_b, facet.cos_a) };
                let symmetric = microfacet_refraction::value(self.alpha, light, eye, &facet);
                self.transmittance(self.effects.across(&self.dielectric, outside, below)) * (symmetric * n_eye * n_eye)
            }
            Lobe::RoughThin => {
                let light = thin_transmission::mirrored(light);
                let sum = light + eye;
                let length = sum.length();
                let lobe = microfacet_reflection::value(self.alpha, light, eye, sum / length);
                self.transmittance(self.dielectric_at(0.5 * length, false)) * lobe
            }
            _ => Rgb::ZERO,
        }
    }

    /// Density of sampling `to` given `from`, with the probability of choosing the component; see [`Component`] for Dirac.
    #[inline(always)]
    pub(crate) fn pdf(&self, from: DVec3, to: DVec3, component: Component) -> f64 {
        self.pdf_with(&self.selection(from), from, to, component)
    }

    /// [`Self::pdf`] with given probabilities of the lobes.
    #[inline]
    pub(crate) fn pdf_with(&self, selection: &Selection, from: DVec3, to: DVec3, component: Component) -> f64 {
        let same_side = from.z * to.z > 0.0;
        match component {
            Component::Rough if same_side => {
                let upper = DVec3::new(from.x, from.y, from.z.abs());
                let to = DVec3::new(to.x, to.y, to.z.abs());
                let mut pdf = 0.0;
                if self.diffuse == Lobe::Diffuse {
                    pdf += selection.diffuse * lambert::pdf(to);
                }
                if self.reflection == Lobe::RoughReflection {
                    let h = (upper + to).normalize();
                    pdf += selection.reflection * microfacet_reflection::pdf(self.alpha, upper, h);
                }
                pdf
            }
            Component::Rough => {
                let specular = self.pdf_transmitted_specularly(selection, from, to);
                if E::TRANSLUCENT && self.translucent != Lobe::Absent {
                    return specular + selection.translucent * lambert::pdf(DVec3::new(to.x, to.y, to.z.abs()));
                }
                specular
            }
            Component::DiracReflection if same_side && self.reflection.component() == Some(component) => {
                selection.reflection * self.dirac_density(to.z)
            }
            Component::DiracTransmission if !same_side && self.transmitted.component() == Some(component) => {
                selection.transmitted * self.dirac_density(to.z)
            }
            _ => 0.0,
        }
    }

    /// Density of drawing `to` on the other side by the transmission lobe.
    #[inline]
    fn pdf_transmitted_specularly(&self, selection: &Selection, from: DVec3, to: DVec3) -> f64 {
        match self.transmitted {
            Lobe::RoughRefraction => {
                let (n_from, n_to) = (self.index(from), self.index(to));
                microfacet_refraction::facet(from, n_from, to, n_to).map_or(0.0, |facet| {
                    selection.transmitted * microfacet_refraction::pdf(self.alpha, from, n_to, &facet)
                })
            }
            Lobe::RoughThin => {
                let h = (from + thin_transmission::mirrored(to)).normalize();
                selection.transmitted * microfacet_reflection::pdf(self.alpha, from, h)
            }
            _ => 0.0,
        }
    }

    /// |cos| n^2 of a direction that a Dirac component leads to, `cos` its cosine with the shading normal.
    #[inline]
    pub(crate) fn dirac_density(&self, cos: f64) -> f64 {
        let n = if self.solid && cos < 0.0 { self.dielectric.ior } else { 1.0 };
        cos.abs() * n * n
    }

    /// The lobe that `u` in [0, 1) chooses with the probabilities of [`Self::selection`].
    #[inline]
    fn choose(&self, selection: &Selection, u: f64) -> Lobe {
        let Selection { diffuse, translucent, reflection, transmitted } = *selection;
        // The last lobe that can be chosen takes what rounding leaves.
        if E::TRANSLUCENT && translucent > 0.0 && u >= diffuse + reflection + transmitted {
            self.translucent
        } else if transmitted > 0.0 && u >= diffuse + reflection {
            self.transmitted
        } else if reflection > 0.0 && u >= diffuse {
            self.reflection
        } else if diffuse > 0.0 {
            self.diffuse
        } else {
            Lobe::Absent
        }
    }

    /// A direction drawn with [`Self::pdf`]; may come out on the wrong side, where the density is 0.
    #[inline]
    pub(crate) fn sample(&self, from: DVec3, u: [f64; 3]) -> Option<(DVec3, Component)> {
        self.sample_with(&self.selection(from), from, u)
    }

    /// [`Self::sample`] with given probabilities of the lobes.
    #[inline]
    pub(crate) fn sample_with(&self, selection: &Selection, from: DVec3, u: [f64; 3]) -> Option<(DVec3, Component)> {
        let lobe = self.choose(selection, u[0]);
        let component = lobe.component()?;
        if component != Component::Rough {
            return self.dirac_direction(from, component).map(|to| (to, component));
        }
        let up = DVec3::new(from.x, from.y, from.z.abs());
        let rest = [u[1], u[2]];
        let to = match lobe {
            Lobe::Diffuse => Some(lambert::sample(rest)),
            Lobe::DiffuseTransmission => Some(thin_transmission::mirrored(lambert::sample(rest))),
            Lobe::RoughRefraction => {
                let eta = self.index(from) / self.index(-from);
                microfacet_refraction::sample(self.alpha, eta, up, rest).filter(|to| to.z < 0.0)
            }
            _ => {
                let to = Some(microfacet_reflection::sample(self.alpha, up, rest)).filter(|to| to.z > 0.0);
                if lobe == Lobe::RoughThin { to.map(thin_transmission::mirrored) } else { to }
            }
        }?;
        Some((turned(to, from), component))
    }

    /// The direction a Dirac component leads to from `from`.
    #[inline]
    pub(crate) fn dirac_direction(&self, from: DVec3, component: Component) -> Option<DVec3> {
        let up = DVec3::new(from.x, from.y, from.z.abs());
        let turn = |w| turned(w, from);
        match (component, self.reflection, self.transmitted) {
            (Component::DiracReflection, Lobe::MirrorReflection, _) => Some(turn(dirac::reflected(up))),
            (Component::DiracTransmission, _, Lobe::SmoothRefraction) => {
                dirac::refracted(up, self.index(from) / self.index(-from)).map(turn)
            }
            (Component::DiracTransmission, _, Lobe::StraightThin) => Some(-from),
            _ => None,
        }
    }
}

/// `w` with its side turned over if `from` lies below.
#[inline]
fn turned(w: DVec3, from: DVec3) -> DVec3 {
    DVec3::new(w.x, w.y, w.z * from.z.signum())
}

/// What the dielectric layer lets through: glTF takes the largest channel so that no colour gains energy.
#[inline]
fn through(dielectric: Rgb) -> f64 {
    1.0 - dielectric.max_element()
}
