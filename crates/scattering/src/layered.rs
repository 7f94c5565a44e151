//! glTF's surface: a Fresnel-weighted specular lobe over a mixture of diffuse reflection and transmission.
//!
//! glTF 2.0, appendix B; KHR_materials_specular, _ior, _transmission, _volume. With m metallic, t transmission, F the
//! dielectric's reflectance and F_m the metal's, the lobes are
//!
//! | lobe | factor |
//! |---|---|
//! | reflection | (1 - m) F + m F_m |
//! | diffuse | (1 - m) (1 - t) (1 - max F) base |
//! | transmission | (1 - m) t (1 - max F) base |
//!
//! Local directions: z is the cosine with the shading normal, z < 0 the other side. Solids have a medium of index `ior`
//! there; every other surface is the same from both sides.

use glam::DVec3;

use crate::fresnel::{self, DielectricFresnel};
use crate::interaction::Component;
use crate::{Rgb, SMOOTH_ALPHA, dirac, lambert, luminance};
use crate::{microfacet_reflection, microfacet_refraction, thin_transmission};

/// Solids whose index is this close to that of the outside refract as if they were smooth: the rough lobe would be a
/// thousand times narrower than the roughness that makes it.
const INDEX_MATCHED: f64 = 1e-3;

/// Lobes that vary over the microfacets are chosen with at least this share of their largest reflectance.
const SELECTION_FLOOR: f64 = 0.05;

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
}

/// A lobe and the form it takes at this point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lobe {
    Absent,
    Diffuse,
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
            Self::Diffuse | Self::RoughReflection | Self::RoughRefraction | Self::RoughThin => Some(Component::Rough),
            Self::MirrorReflection => Some(Component::DiracReflection),
            Self::SmoothRefraction | Self::StraightThin => Some(Component::DiracTransmission),
        }
    }
}

/// The layered surface at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layered {
    base: Rgb,
    dielectric: DielectricFresnel,
    metallic: f64,
    transmission: f64,
    alpha: f64,
    solid: bool,
    diffuse: Lobe,
    reflection: Lobe,
    transmitted: Lobe,
}

/// Probabilities of choosing each lobe.
#[derive(Clone, Copy)]
struct Selection {
    diffuse: f64,
    reflection: f64,
    transmitted: f64,
}

impl Layered {
    /// The surface with these parameters.
    pub fn new(p: &Parameters) -> Self {
        let dielectric = DielectricFresnel::new(p.ior, p.specular, p.specular_color, p.transmissive);
        let smooth = p.alpha < SMOOTH_ALPHA;
        let under = p.metallic < 1.0 && p.base != Rgb::ZERO;
        let reflection = if p.metallic == 0.0 && dielectric.is_zero() {
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
            alpha: p.alpha.clamp(0.0, 1.0),
            solid: p.solid,
            diffuse: if under && p.transmission < 1.0 { Lobe::Diffuse } else { Lobe::Absent },
            reflection,
            transmitted,
        }
    }

    /// Whether a medium of its own index lies below.
    #[inline]
    pub fn is_solid(&self) -> bool {
        self.solid
    }

    /// Whether any lobe belongs to `component`.
    #[inline]
    pub fn has(&self, component: Component) -> bool {
        [self.diffuse, self.reflection, self.transmitted].iter().any(|lobe| lobe.component() == Some(component))
    }

    /// Whether `w` lies in the medium below.
    #[inline]
    fn is_inside(&self, w: DVec3) -> bool {
        self.solid && w.z < 0.0
    }

    /// Index of refraction of the medium that `w` lies in.
    #[inline]
    pub fn index(&self, w: DVec3) -> f64 {
        if self.is_inside(w) { self.dielectric.ior } else { 1.0 }
    }

    /// Factor of the reflection lobe for light at cosine `cos` with its facet, given the dielectric's reflectance there.
    #[inline]
    fn reflectance(&self, cos: f64, dielectric: Rgb, inside: bool) -> Rgb {
        let outer = dielectric * (1.0 - self.metallic);
        if self.metallic == 0.0 || inside {
            return outer;
        }
        outer + self.base.lerp(Rgb::ONE, fresnel::schlick_weight(cos)) * self.metallic
    }

    /// Factor of the diffuse lobe.
    #[inline]
    fn diffuse_factor(&self, dielectric: Rgb) -> Rgb {
        self.base * ((1.0 - self.metallic) * (1.0 - self.transmission) * through(dielectric))
    }

    /// Factor of the transmission lobe.
    #[inline]
    fn transmittance(&self, dielectric: Rgb) -> Rgb {
        self.base * ((1.0 - self.metallic) * self.transmission * through(dielectric))
    }

    /// The probabilities of choosing each lobe, for light from `w`: the one place where they are made. Near enough to the
    /// lobes' albedos, and above 0 wherever the lobe is.
    #[inline]
    fn selection(&self, w: DVec3) -> Selection {
        let inside = self.is_inside(w);
        let cos = w.z.abs();
        // Rough facets are on average met less obliquely than the surface: at grazing incidence at a cosine of about
        // 2 alpha while alpha is small.
        let softened = cos + (1.0 - cos) * (1.0 - cos) * self.alpha / (self.alpha + 0.5);
        let at = |cos: f64| self.dielectric.at(cos, inside);
        let floored = |factor: Rgb, largest: f64| luminance(factor).max(SELECTION_FLOOR * largest);
        let under = luminance(self.base) * (1.0 - self.metallic);
        let diffuse = match self.diffuse {
            Lobe::Diffuse if !inside => {
                // The light that comes back along the normal stands for all of it.
                let half = (0.5 * (1.0 + cos)).sqrt();
                floored(self.diffuse_factor(at(half)), under * (1.0 - self.transmission))
            }
            _ => 0.0,
        };
        let reflection = match self.reflection {
            Lobe::Absent => 0.0,
            Lobe::MirrorReflection => luminance(self.reflectance(cos, at(cos), inside)),
            _ => {
                let grazing = self.reflectance(0.0, Rgb::splat(self.dielectric.f90), inside);
                floored(self.reflectance(softened, at(softened), inside), luminance(grazing))
            }
        };
        let transmitted = match self.transmitted {
            Lobe::Absent => 0.0,
            Lobe::SmoothRefraction | Lobe::StraightThin => luminance(self.transmittance(at(cos))),
            _ => floored(self.transmittance(at(softened)), under * self.transmission),
        };
        let sum = diffuse + reflection + transmitted;
        let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        Selection { diffuse: diffuse * scale, reflection: reflection * scale, transmitted: transmitted * scale }
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
                self.reflectance(cos, self.dielectric.at(cos, inside), inside) * (n * n)
            }
            Component::DiracTransmission if !same_side => match self.transmitted {
                Lobe::SmoothRefraction => {
                    let n = self.index(eye);
                    let (outside, below) = if inside { (light.z, -eye.z) } else { (eye.z, -light.z) };
                    self.transmittance(self.dielectric.across(outside, below)) * (n * n)
                }
                Lobe::StraightThin => self.transmittance(self.dielectric.at(eye.z.abs(), false)),
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
        let dielectric = self.dielectric.at(cos, inside);
        let mut f = Rgb::ZERO;
        if self.diffuse == Lobe::Diffuse && !inside {
            f += lambert::value(self.diffuse_factor(dielectric));
        }
        if self.reflection == Lobe::RoughReflection {
            let lobe = microfacet_reflection::value(self.alpha, light, eye, sum / length);
            f += self.reflectance(cos, dielectric, inside) * lobe;
        }
        f
    }

    #[inline]
    fn eval_transmitted(&self, light: DVec3, eye: DVec3, inside: bool) -> Rgb {
        match self.transmitted {
            Lobe::RoughRefraction => {
                let (n_light, n_eye) = (self.index(light), self.index(eye));
                let Some(facet) = microfacet_refraction::facet(light, n_light, eye, n_eye) else {
                    return Rgb::ZERO;
                };
                let (outside, below) = if inside { (facet.cos_a, facet.cos_b) } else { (facet.cos_b, facet.cos_a) };
                let symmetric = microfacet_refraction::value(self.alpha, light, eye, &facet);
                self.transmittance(self.dielectric.across(outside, below)) * (symmetric * n_eye * n_eye)
            }
            Lobe::RoughThin => {
                let light = thin_transmission::mirrored(light);
                let sum = light + eye;
                let length = sum.length();
                let lobe = microfacet_reflection::value(self.alpha, light, eye, sum / length);
                self.transmittance(self.dielectric.at(0.5 * length, false)) * lobe
            }
            _ => Rgb::ZERO,
        }
    }

    /// Density of sampling `to` given `from`, with the probability of choosing the component; see [`Component`] for Dirac.
    #[inline]
    pub(crate) fn pdf(&self, from: DVec3, to: DVec3, component: Component) -> f64 {
        let selection = self.selection(from);
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
            Component::Rough => match self.transmitted {
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
            },
            Component::DiracReflection if same_side && self.reflection.component() == Some(component) => {
                selection.reflection * self.dirac_density(to.z)
            }
            Component::DiracTransmission if !same_side && self.transmitted.component() == Some(component) => {
                selection.transmitted * self.dirac_density(to.z)
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
        let Selection { diffuse, reflection, transmitted } = *selection;
        // The last lobe that can be chosen takes what rounding leaves.
        if transmitted > 0.0 && u >= diffuse + reflection {
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
        let lobe = self.choose(&self.selection(from), u[0]);
        let component = lobe.component()?;
        if component != Component::Rough {
            return self.dirac_direction(from, component).map(|to| (to, component));
        }
        let up = DVec3::new(from.x, from.y, from.z.abs());
        let rest = [u[1], u[2]];
        let to = match lobe {
            Lobe::Diffuse => Some(lambert::sample(rest)),
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
