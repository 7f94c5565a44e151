//! The closed set of surfaces, and of media, and the dispatch to them. A new surface is one file and one arm in each function here.

use ergodic_geometry::Frame;
use glam::DVec3;

use crate::{Component, Extended, HenyeyGreenstein, Lambert, Layered, Rgb};

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
        match self {
            Self::Lambert(lambert) => component == Component::Rough && lambert.albedo != Rgb::ZERO,
            Self::Layered(layered) => layered.has(component),
            Self::Extended(extended) => extended.has(component),
            Self::Phase(_) => component == Component::Rough,
        }
    }

    /// Index of refraction below the surface relative to above; 1 unless the surface bounds a solid.
    #[inline]
    pub(crate) fn index_below(&self) -> f64 {
        match self {
            Self::Lambert(_) | Self::Phase(_) => 1.0,
            Self::Layered(layered) => layered.index(DVec3::NEG_Z),
            Self::Extended(extended) => extended.index_below(),
        }
    }

    /// The density of a Dirac component in direction `to`, without its selection probability.
    #[inline]
    pub(crate) fn dirac_density(&self, frame: &Frame, to: DVec3, component: Component) -> f64 {
        match self {
            Self::Layered(layered) if component != Component::Rough && layered.has(component) => {
                layered.dirac_density(to.dot(frame.n))
            }
            Self::Extended(extended) => extended.dirac_density(frame.to_local(to), component),
            _ => 0.0,
        }
    }

    /// The probabilities of choosing a Dirac reflection and a Dirac transmission for light from `from`.
    #[inline]
    pub(crate) fn dirac_probabilities(&self, frame: &Frame, from: DVec3) -> [f64; 2] {
        match self {
            Self::Lambert(_) | Self::Phase(_) => [0.0; 2],
            Self::Layered(layered) if layered.has_dirac() => {
                layered.dirac_probabilities(&layered.selection(frame.to_local(from)))
            }
            Self::Layered(_) => [0.0; 2],
            Self::Extended(extended) => extended.dirac_probabilities(frame.to_local(from)),
        }
    }

    /// Whether the surface bounds a solid.
    #[inline]
    pub(crate) fn is_solid(&self) -> bool {
        match self {
            Self::Lambert(_) | Self::Phase(_) => false,
            Self::Layered(layered) => layered.is_solid(),
            Self::Extended(extended) => extended.is_solid(),
        }
    }

    /// Whether the surface is that for one wavelength.
    #[inline]
    pub(crate) fn is_dispersive(&self) -> bool {
        match self {
            Self::Lambert(_) | Self::Phase(_) => false,
            Self::Layered(layered) => layered.is_dispersive(),
            Self::Extended(extended) => extended.is_dispersive(),
        }
    }

    /// The share of the emitted light that leaves along `w`.
    #[inline]
    pub(crate) fn emission_factor(&self, frame: &Frame, w: DVec3) -> f64 {
        match self {
            Self::Extended(extended) => extended.emission_factor(frame.to_local(w)),
            Self::Lambert(_) | Self::Layered(_) | Self::Phase(_) => 1.0,
        }
    }

    /// The scattering function without the shading-normal factor.
    #[inline]
    pub(crate) fn eval(&self, frame: &Frame, light: DVec3, eye: DVec3, component: Component) -> Rgb {
        match self {
            Self::Lambert(lambert) if component == Component::Rough => {
                lambert.eval(light.dot(frame.n), eye.dot(frame.n))
            }
            Self::Lambert(_) => Rgb::ZERO,
            Self::Layered(layered) => layered.eval(frame.to_local(light), frame.to_local(eye), component),
            Self::Extended(extended) => extended.eval(frame.to_local(light), frame.to_local(eye), component),
            Self::Phase(phase) if component == Component::Rough => phase.eval(light, eye),
            Self::Phase(_) => Rgb::ZERO,
        }
    }

    /// Density of sampling `to` given `from`.
    #[inline]
    pub(crate) fn pdf(&self, frame: &Frame, from: DVec3, to: DVec3, component: Component) -> f64 {
        match self {
            Self::Lambert(lambert) if component == Component::Rough => lambert.pdf(from.dot(frame.n), to.dot(frame.n)),
            Self::Lambert(_) => 0.0,
            Self::Layered(layered) => layered.pdf(frame.to_local(from), frame.to_local(to), component),
            Self::Extended(extended) => extended.pdf(frame.to_local(from), frame.to_local(to), component),
            Self::Phase(phase) if component == Component::Rough => phase.pdf(from, to),
            Self::Phase(_) => 0.0,
        }
    }

    /// A direction drawn with [`Self::pdf`].
    #[inline]
    pub(crate) fn sample(&self, frame: &Frame, from: DVec3, u: [f64; 3]) -> Option<(DVec3, Component)> {
        match self {
            Self::Lambert(lambert) => {
                lambert.sample(frame, from.dot(frame.n), [u[1], u[2]]).map(|to| (to, Component::Rough))
            }
            Self::Layered(layered) => {
                layered.sample(frame.to_local(from), u).map(|(to, component)| (frame.to_world(to), component))
            }
            Self::Extended(extended) => {
                extended.sample(frame.to_local(from), u).map(|(to, component)| (frame.to_world(to), component))
            }
            Self::Phase(phase) => Some((phase.sample(from, [u[1], u[2]]), Component::Rough)),
        }
    }

    /// The direction a Dirac component leads to.
    #[inline]
    pub(crate) fn dirac_direction(&self, frame: &Frame, from: DVec3, component: Component) -> Option<DVec3> {
        match self {
            Self::Lambert(_) | Self::Phase(_) => None,
            Self::Layered(layered) => {
                layered.dirac_direction(frame.to_local(from), component).map(|to| frame.to_world(to))
            }
            Self::Extended(extended) => {
                extended.dirac_direction(frame.to_local(from), component).map(|to| frame.to_world(to))
            }
        }
    }
}
