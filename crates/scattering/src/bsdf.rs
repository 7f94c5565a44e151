//! The closed set of surfaces, and of media, and the dispatch to them. A new surface is one file and one arm in each function here.
//!
//! What a repertoire does not have is never met; it counts as what scatters nothing, so that nothing is compiled for it.

use ergodic_geometry::Frame;
use glam::DVec3;

use crate::{Component, Everything, Extended, HenyeyGreenstein, Lambert, Layered, Repertoire, Rgb};

/// How a surface scatters at one point, in its shading frame; or a medium, which has none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bsdf {
    /// Lambertian and nothing else.
    Lambert(Lambert),
    /// glTF's layered surface.
    Layered(Layered),
    /// The same with a coat, a sheen and other effects.
    Extended(Extended),
    /// A medium.
    Phase(HenyeyGreenstein),
}

impl Bsdf {
    /// A surface that scatters nothing.
    pub const BLACK: Self = Self::Lambert(Lambert { albedo: Rgb::ZERO });

    /// Whether any lobe belongs to `component`.
    #[inline]
    pub fn has(&self, component: Component) -> bool {
        self.has_in::<Everything>(component)
    }

    /// The same in a repertoire.
    #[inline]
    pub(crate) fn has_in<R: Repertoire>(&self, component: Component) -> bool {
        match self {
            Self::Lambert(lambert) => component == Component::Rough && lambert.albedo != Rgb::ZERO,
            Self::Layered(layered) => R::LOBES && layered.has(component),
            Self::Extended(extended) => R::LAYERS && extended.has(component),
            Self::Phase(_) => R::SCATTERING && component == Component::Rough,
        }
    }

    /// Whether this is a medium, which has no sides.
    #[inline]
    pub(crate) fn is_medium<R: Repertoire>(&self) -> bool {
        R::SCATTERING && matches!(self, Self::Phase(_))
    }

    /// Index of refraction below the surface relative to above; 1 unless the surface bounds a solid.
    #[inline]
    pub(crate) fn index_below<R: Repertoire>(&self) -> f64 {
        match self {
            Self::Layered(layered) if R::LOBES => layered.index(DVec3::NEG_Z),
            Self::Extended(extended) if R::LAYERS => extended.index_below(),
            Self::Lambert(_) | Self::Layered(_) | Self::Extended(_) | Self::Phase(_) => 1.0,
        }
    }

    /// The density of a Dirac component in direction `to`, without its selection probability.
    #[inline]
    pub(crate) fn dirac_density<R: Repertoire>(&self, frame: &Frame, to: DVec3, component: Component) -> f64 {
        match self {
            Self::Layered(layered) if R::LOBES && component != Component::Rough && layered.has(component) => {
                layered.dirac_density(to.dot(frame.n))
            }
            Self::Extended(extended) if R::LAYERS => extended.dirac_density(frame.to_local(to), component),
            Self::Lambert(_) | Self::Layered(_) | Self::Extended(_) | Self::Phase(_) => 0.0,
        }
    }

    /// The probabilities of choosing a Dirac reflection and a Dirac transmission for light from `from`.
    #[inline]
    pub(crate) fn dirac_probabilities<R: Repertoire>(&self, frame: &Frame, from: DVec3) -> [f64; 2] {
        match self {
            Self::Layered(layered) if R::LOBES && layered.has_dirac() => {
                layered.dirac_probabilities(&layered.selection(frame.to_local(from)))
            }
            Self::Extended(extended) if R::LAYERS => extended.dirac_probabilities(frame.to_local(from)),
            Self::Lambert(_) | Self::Layered(_) | Self::Extended(_) | Self::Phase(_) => [0.0; 2],
        }
    }

    /// Whether the surface bounds a solid.
    #[inline]
    pub(crate) fn is_solid<R: Repertoire>(&self) -> bool {
        match self {
            Self::Lambert(_) | Self::Phase(_) => false,
            Self::Layered(layered) => R::LOBES && layered.is_solid(),
            Self::Extended(extended) => R::LAYERS && extended.is_solid(),
        }
    }

    /// Whether the surface is that for one wavelength.
    #[inline]
    pub(crate) fn is_dispersive<R: Repertoire>(&self) -> bool {
        match self {
            Self::Lambert(_) | Self::Phase(_) => false,
            Self::Layered(layered) => R::DISPERSION && layered.is_dispersive(),
            Self::Extended(extended) => R::DISPERSION && extended.is_dispersive(),
        }
    }

    /// The share of the emitted light that leaves along `w`.
    #[inline]
    pub(crate) fn emission_factor<R: Repertoire>(&self, frame: &Frame, w: DVec3) -> f64 {
        match self {
            Self::Extended(extended) if R::LAYERS => extended.emission_factor(frame.to_local(w)),
            Self::Lambert(_) | Self::Layered(_) | Self::Extended(_) | Self::Phase(_) => 1.0,
        }
    }

    /// The scattering function without the shading-normal factor.
    #[inline(always)]
    pub(crate) fn eval<R: Repertoire>(&self, frame: &Frame, light: DVec3, eye: DVec3, component: Component) -> Rgb {
        match self {
            Self::Lambert(lambert) if component == Component::Rough => {
                lambert.eval(light.dot(frame.n), eye.dot(frame.n))
            }
            Self::Layered(layered) if R::LOBES => layered.eval(frame.to_local(light), frame.to_local(eye), component),
            Self::Extended(extended) if R::LAYERS => {
                extended.eval(frame.to_local(light), frame.to_local(eye), component)
            }
            Self::Phase(phase) if R::SCATTERING && component == Component::Rough => phase.eval(light, eye),
            Self::Lambert(_) | Self::Layered(_) | Self::Extended(_) | Self::Phase(_) => Rgb::ZERO,
        }
    }

    /// Density of sampling `to` given `from`.
    #[inline]
    pub(crate) fn pdf<R: Repertoire>(&self, frame: &Frame, from: DVec3, to: DVec3, component: Component) -> f64 {
        match self {
            Self::Lambert(lambert) if component == Component::Rough => lambert.pdf(from.dot(frame.n), to.dot(frame.n)),
            Self::Layered(layered) if R::LOBES => layered.pdf(frame.to_local(from), frame.to_local(to), component),
            Self::Extended(extended) if R::LAYERS => extended.pdf(frame.to_local(from), frame.to_local(to), component),
            Self::Phase(phase) if R::SCATTERING && component == Component::Rough => phase.pdf(from, to),
            Self::Lambert(_) | Self::Layered(_) | Self::Extended(_) | Self::Phase(_) => 0.0,
        }
    }

    /// A direction drawn with [`Self::pdf`].
    #[inline(always)]
    pub(crate) fn sample<R: Repertoire>(&self, frame: &Frame, from: DVec3, u: [f64; 3]) -> Option<(DVec3, Component)> {
        match self {
            Self::Lambert(lambert) => {
                lambert.sample(frame, from.dot(frame.n), [u[1], u[2]]).map(|to| (to, Component::Rough))
            }
            Self::Layered(layered) if R::LOBES => {
                layered.sample(frame.to_local(from), u).map(|(to, component)| (frame.to_world(to), component))
            }
            Self::Extended(extended) if R::LAYERS => {
                extended.sample(frame.to_local(from), u).map(|(to, component)| (frame.to_world(to), component))
            }
            Self::Phase(phase) if R::SCATTERING => Some((phase.sample(from, [u[1], u[2]]), Component::Rough)),
            Self::Layered(_) | Self::Extended(_) | Self::Phase(_) => None,
        }
    }

    /// The direction a Dirac component leads to.
    #[inline]
    pub(crate) fn dirac_direction<R: Repertoire>(
        &self,
        frame: &Frame,
        from: DVec3,
        component: Component,
    ) -> Option<DVec3> {
        match self {
            Self::Layered(layered) if R::LOBES => {
                layered.dirac_direction(frame.to_local(from), component).map(|to| frame.to_world(to))
            }
            Self::Extended(extended) if R::LAYERS => {
                extended.dirac_direction(frame.to_local(from), component).map(|to| frame.to_world(to))
            }
            Self::Lambert(_) | Self::Layered(_) | Self::Extended(_) | Self::Phase(_) => None,
        }
    }
}
