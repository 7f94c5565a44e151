//! One point of a path: where it is and how light interacts there. No density, weight or throughput is kept in it, so a
//! chain cannot remember how a path was found.

use ergodic_geometry::Anchor;
use ergodic_scattering::{Component, Everything, Interaction, Repertoire, Rgb};
use glam::DVec3;

use crate::Coverage;

/// What a vertex is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A point of a surface. At the light end of a path it is the point that emits.
    Surface,
    /// A point of a medium. Its measure is volume.
    Volume,
    /// The pinhole.
    Camera,
    /// A point of the camera's lens, whose normal `ng` is the camera's axis.
    Aperture,
    /// An orthographic camera: like a distant light it has a direction, the axis `ng` along which it looks, but no position.
    DistantCamera,
    /// A point or spot light; the index counts the scene's punctual lights.
    PointLight(u32),
    /// A directional light: infinitely far, so that it has a direction but no position.
    DistantLight(u32),
    /// The environment: infinitely far in a direction that is part of the vertex. Its measure is solid angle, where that of
    /// points of surfaces is area.
    Environment,
}

/// Marks a vertex that lies on no emitter.
pub(crate) const NO_EMITTER: u32 = u32::MAX;

/// Marks a vertex on the environment.
pub(crate) const ENVIRONMENT: u32 = u32::MAX - 1;

/// A vertex of a path. What it cannot be in a scene of its repertoire is not asked.
#[derive(Clone, Copy, Debug)]
pub struct Vertex<R: Repertoire = Everything> {
    /// What it is.
    pub kind: Kind,
    /// How light scatters here on this path. Endpoints carry [`Component::Rough`].
    pub component: Component,
    /// The share of what lies behind that the surface covers here. Whole where there is no surface.
    pub coverage: Coverage,
    /// Index into the scene's emissive triangles, or [`ENVIRONMENT`] or [`NO_EMITTER`].
    pub(crate) emitter: u32,
    /// Index of the material.
    pub(crate) material: u32,
    /// Index of the material of the filled solid that it is met in, outside its own if it bounds one; or
    /// [`crate::media::AIR`]. A property of the place: every way of finding it gives the same.
    pub(crate) medium: u32,
    /// Position in the scene's own (recentred, rescaled) space; zero for a distant light or camera and the environment.
    pub position: DVec3,
    /// The scattering here; for a distant light and the environment `ng` is the direction in which its light travels.
    pub interaction: Interaction<R>,
    /// Radiance emitted here into the front, before the one-sided test; of the environment that of its direction.
    pub emission: Rgb,
}

impl<R: Repertoire> Vertex<R> {
    /// Whether this is a point of a surface.
    #[inline]
    pub fn is_surface(&self) -> bool {
        self.kind == Kind::Surface
    }

    /// The same vertex in another repertoire, which must have what it is.
    #[inline]
    #[must_use]
    pub(crate) fn within<S: Repertoire>(self) -> Vertex<S> {
        let Self { kind, component, coverage, emitter, material, medium, position, interaction, emission } = self;
        let interaction = Interaction::new(interaction.frame, interaction.ng, interaction.bsdf);
        Vertex { kind, component, coverage, emitter, material, medium, position, interaction, emission }
    }

    /// Whether the vertex lies on an area, so that a cosine goes with it.
    #[inline]
    pub(crate) fn has_area(&self) -> bool {
        self.kind == Kind::Surface || R::OTHER_CAMERAS && self.kind == Kind::Aperture
    }

    /// Whether it is a light without extent: a point, or a single direction.
    #[inline]
    pub fn is_without_extent(&self) -> bool {
        R::OTHER_LIGHTS && matches!(self.kind, Kind::PointLight(_) | Kind::DistantLight(_))
    }

    /// Whether this is the camera's end of a path.
    #[inline]
    pub fn is_eye(&self) -> bool {
        self.kind == Kind::Camera || R::OTHER_CAMERAS && matches!(self.kind, Kind::Aperture | Kind::DistantCamera)
    }

    /// Whether this is an orthographic camera, or a point of its film.
    #[inline]
    pub fn is_on_film(&self) -> bool {
        R::OTHER_CAMERAS && self.kind == Kind::DistantCamera
    }

    /// Whether this is a point of a medium.
    #[inline]
    pub fn is_in_medium(&self) -> bool {
        R::SCATTERING && self.kind == Kind::Volume
    }

    /// What names the medium that the vertex is met in.
    #[inline]
    pub fn medium(&self) -> u32 {
        self.medium
    }

    /// Whether light is scattered here, so that walks go on.
    #[inline]
    pub fn scatters(&self) -> bool {
        self.is_surface() || self.is_in_medium()
    }

    /// Whether the vertex is infinitely far away: light travels along its `interaction.ng` and has no position.
    #[inline]
    pub fn is_distant(&self) -> bool {
        R::OTHER_LIGHTS && matches!(self.kind, Kind::DistantLight(_) | Kind::Environment)
    }

    /// Whether the vertex is a direction of the environment.
    #[inline]
    pub(crate) fn is_environment(&self) -> bool {
        R::OTHER_LIGHTS && self.kind == Kind::Environment
    }

    /// Whether the vertex may end a path as its light: a point of a surface, or a direction of the environment. Other lights have
    /// no extent, so that no walk from the eye meets them.
    #[inline]
    pub fn can_be_met(&self) -> bool {
        self.is_surface() || self.is_environment()
    }

    /// Whether the vertex emits from its surface, or is the environment.
    #[inline]
    pub fn emits(&self) -> bool {
        self.emitter != NO_EMITTER
    }

    /// Whether a connection may end here on this path: everything but a Dirac component.
    #[inline]
    pub fn is_connectable(&self) -> bool {
        self.component == Component::Rough
    }

    /// The end of a shadow segment here.
    #[inline]
    pub fn anchor(&self) -> Anchor {
        let normal = if self.is_surface() { self.interaction.ng } else { DVec3::ZERO };
        Anchor { position: self.position, normal }
    }
}
