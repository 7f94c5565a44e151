//! The scattering at one point of a surface, in world space: shading frame, geometric normal and BSDF.

use std::marker::PhantomData;

use ergodic_geometry::Frame;
use ergodic_geometry::phase::{self, Phase};
use glam::DVec3;

use crate::{Bsdf, Everything, HenyeyGreenstein, Repertoire, Rgb};

/// Part of the scattering that a path goes through at a vertex.
///
/// A Dirac component's delta is divided out of the scattering function and of every density, in one common unit: with n
/// the index of refraction around a direction w (1, but that of the solid below a solid's surface),
///
/// D = delta in projected solid angle about Ns of w, divided by n^2,
///
/// which conservation of étendue makes the same for both directions. So, with R or T the share of power,
/// eval = R n_eye^2 |w_light·Ns| / |w_light·Ng| and pdf = P(component | w_from) |w_to·Ns| n_to^2.
///
/// Where the only mirror is a coat with a normal Nc of its own, Nc stands for Ns in all of this.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Component {
    /// All lobes that are not Dirac together.
    Rough,
    /// Reflection by a perfectly smooth surface.
    DiracReflection,
    /// Refraction by a perfectly smooth surface, or straight transmission by a thin one.
    DiracTransmission,
}

/// Directions whose cosines with the two normals have a smaller product scatter nothing: they are in the surface, or the
/// normals disagree about their side, which would let light leak.
const LEAST_COSINE_PRODUCT: f64 = 1e-20;

/// The scattering at a point of a surface, or of a medium, where neither frame nor normal means anything.
///
/// Directions are unit vectors in world space, away from the surface. Opaque and thin-walled surfaces are the same on both
/// sides; for a solid, the side of `ng` is the outside.
#[derive(Clone, Copy, Debug)]
pub struct Interaction<R: Repertoire = Everything> {
    /// Shading frame: its normal is Ns, on the side of `ng`.
    pub frame: Frame,
    /// Unit geometric normal.
    pub ng: DVec3,
    /// How it scatters, in the shading frame.
    pub bsdf: Bsdf,
    repertoire: PhantomData<R>,
}

impl<R: Repertoire> Interaction<R> {
    /// The scattering by a BSDF in a shading frame, whose normal is on the side of the unit geometric normal `ng`.
    #[inline]
    pub fn new(frame: Frame, ng: DVec3, bsdf: Bsdf) -> Self {
        Self { frame, ng, bsdf, repertoire: PhantomData }
    }

    /// What stands for the scattering where there is no surface: nothing.
    pub fn none() -> Self {
        Self::new(Frame::from_normal(DVec3::Z), DVec3::Z, Bsdf::BLACK)
    }

    /// The same with another geometric normal.
    #[inline]
    #[must_use]
    pub fn with_normal(self, ng: DVec3) -> Self {
        Self { ng, ..self }
    }

    /// The scattering at a point of a medium.
    #[inline]
    #[must_use]
    pub fn in_medium(phase: HenyeyGreenstein) -> Self {
        Self { bsdf: Bsdf::Phase(phase), ..Self::none() }
    }

    /// Whether both normals see `w` on the same side, clear of the surface. A medium has no sides.
    #[inline]
    fn accepts(&self, w: DVec3) -> bool {
        if self.bsdf.is_medium::<R>() {
            return true;
        }
        w.dot(self.frame.n) * w.dot(self.ng) > LEAST_COSINE_PRODUCT
    }

    /// The scattering function f_s(light -> eye) in 1/sr for radiance, times |w_light·Ns| / |w_light·Ng|, so that the
    /// cosines of the path's geometric terms are those of `ng` alone (Veach 1997, section 5.3.2). Obeys
    /// f(a -> b) / n_b^2 = f(b -> a) / n_a^2 without that factor (Veach, eq. 5.14), which for the lobe of a coat with a
    /// normal of its own is |w_light·Nc| / |w_light·Ng|. For a Dirac component see [`Component`]: the directions must obey
    /// the law of reflection or refraction.
    #[inline(always)]
    pub fn eval(&self, w_light: DVec3, w_eye: DVec3, component: Component) -> Rgb {
        if !self.accepts(w_light) || !self.accepts(w_eye) {
            return Rgb::ZERO;
        }
        if self.bsdf.is_medium::<R>() {
            return self.bsdf.eval::<R>(&self.frame, w_light, w_eye, component);
        }
        let shading = w_light.dot(self.frame.n) / w_light.dot(self.ng);
        self.bsdf.eval::<R>(&self.frame, w_light, w_eye, component) * shading
    }

    /// Density in 1/sr of sampling `w_to` given `w_from`, including the probability of choosing the component. For a Dirac
    /// component see [`Component`].
    #[inline]
    pub fn pdf(&self, w_from: DVec3, w_to: DVec3, component: Component) -> f64 {
        if !self.accepts(w_from) || !self.accepts(w_to) {
            return 0.0;
        }
        self.bsdf.pdf::<R>(&self.frame, w_from, w_to, component)
    }

    /// A direction and its component, drawn with [`Self::pdf`] from three numbers in [0, 1). `None` when nothing scatters
    /// or the direction came out where the density is 0; that is part of the distribution, not to be redrawn.
    #[inline(always)]
    pub fn sample(&self, w_from: DVec3, u: [f64; 3]) -> Option<(DVec3, Component)> {
        let _phase = phase::enter(Phase::Shading);
        if !self.accepts(w_from) {
            return None;
        }
        self.bsdf
            .sample::<R>(&self.frame, w_from, u)
            .filter(|(w_to, component)| self.connects(w_from, *w_to, *component))
    }

    /// The one direction that a Dirac component leads to; `None` under total internal reflection, where the normals
    /// disagree about it, or if there is no such component.
    #[inline(always)]
    pub fn dirac_direction(&self, w_from: DVec3, component: Component) -> Option<DVec3> {
        let _phase = phase::enter(Phase::Shading);
        if !self.accepts(w_from) {
            return None;
        }
        self.bsdf
            .dirac_direction::<R>(&self.frame, w_from, component)
            .filter(|w_to| self.connects(w_from, *w_to, component))
    }

    /// Whether `w_to` is clear of the surface and, for a Dirac component, on the side that it leads to.
    #[inline]
    fn connects(&self, w_from: DVec3, w_to: DVec3, component: Component) -> bool {
        let same_side = w_from.dot(self.ng) * w_to.dot(self.ng) > 0.0;
        self.accepts(w_to)
            && match component {
                Component::Rough => true,
                Component::DiracReflection => same_side,
                Component::DiracTransmission => !same_side,
            }
    }

    /// The density of a Dirac component without its selection probability: |w_to·Ns| n_to^2 (see [`Component`]). 0 if
    /// there is none.
    #[inline]
    pub fn dirac_density(&self, w_to: DVec3, component: Component) -> f64 {
        self.bsdf.dirac_density::<R>(&self.frame, w_to, component)
    }

    /// The probabilities that [`Self::sample`] chooses a Dirac reflection and a Dirac transmission for light from `w_from`, whether or
    /// not there is a direction then. It chooses the rough lobes otherwise.
    #[inline]
    pub fn dirac_probabilities(&self, w_from: DVec3) -> [f64; 2] {
        if self.accepts(w_from) { self.bsdf.dirac_probabilities::<R>(&self.frame, w_from) } else { [0.0; 2] }
    }

    /// The share of what is emitted here that leaves along `w`: a coat takes some.
    #[inline]
    pub fn emission_factor(&self, w: DVec3) -> f64 {
        self.bsdf.emission_factor::<R>(&self.frame, w)
    }

    /// Whether any lobe here is not Dirac.
    #[inline]
    pub fn has_rough(&self) -> bool {
        self.bsdf.has_in::<R>(Component::Rough)
    }

    /// Whether the surface has the Dirac component; never for [`Component::Rough`].
    #[inline]
    pub fn has_dirac(&self, component: Component) -> bool {
        component != Component::Rough && self.bsdf.has_in::<R>(component)
    }

    /// Whether the surface bounds a refracting solid, which lies on the side of -`ng`.
    #[inline]
    pub fn medium_below(&self) -> bool {
        self.bsdf.is_solid::<R>()
    }

    /// Whether the scattering is that for one wavelength and would be another for another.
    #[inline]
    pub fn is_dispersive(&self) -> bool {
        self.bsdf.is_dispersive::<R>()
    }

    /// Index of refraction on the side of -`ng` relative to the other; 1 unless the surface bounds a solid.
    #[inline]
    pub fn index_below(&self) -> f64 {
        self.bsdf.index_below::<R>()
    }
}
