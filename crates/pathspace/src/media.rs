//! What fills space, and which filled solid a point lies in.
//!
//! A path that refracts into a solid knows it from the surface it crossed. One that starts inside, at a lamp, a light or the
//! camera, has to ask: a ray is sent out, and the first surface of a solid that it meets from within is that of the solid
//! around it.

use ergodic_geometry::{Anchor, Ray, World};
use ergodic_scattering::{Material, Medium};
use glam::DVec3;

use crate::{Effect, Effects};

/// Stands for what lies outside all solids.
pub(crate) const AIR: u32 = u32::MAX;

/// The media of a scene, and the solids that are filled otherwise than the space around them.
#[derive(Debug)]
pub(crate) struct Media {
    solids: Vec<Solid>,
    air: Medium,
    /// What fills solids, by material.
    of_material: Vec<Medium>,
    /// Whether there is nothing but vacuum, and nobody wants to know.
    empty: bool,
    /// Whether any medium scatters, or somebody wants to know.
    scatters: bool,
}

#[derive(Debug)]
struct Solid {
    instance: u32,
    material: u32,
    low: DVec3,
    high: DVec3,
}

/// Surfaces that the ray of one question may meet.
const MOST_SURFACES: usize = 1024;

/// The direction of that ray; none that a modeller would choose for an edge.
const DIRECTION: DVec3 = DVec3::new(0.356_822_089_773_089_9, 0.864_988_213_119_5, 0.352_681_442_197_5);

impl Media {
    /// Of these materials, by instance. All lengths are those of the scene's own space.
    pub(crate) fn new(
        world: &World,
        materials: &[Material],
        material_of_instance: &[u32],
        air: Medium,
        ready_for: Effects,
    ) -> Self {
        let of_material: Vec<Medium> = materials.iter().map(Material::medium).collect();
        let is_filled = |material: u32| {
            materials[material as usize].is_solid() && !(of_material[material as usize].is_vacuum() && air.is_vacuum())
        };
        let solids = (0u32..).zip(material_of_instance.iter().copied()).filter(|(_, material)| is_filled(*material));
        let solid = |(instance, material)| {
            let corners = (0..world.triangle_count(instance) as u32).flat_map(|t| world.triangle(instance, t));
            let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            let (low, high) = corners.fold(none, |(low, high), p| (low.min(p), high.max(p)));
            Solid { instance, material, low, high }
        };
        let solids: Vec<Solid> = solids.map(solid).collect();
        let scatters = air.scatters()
            || solids.iter().any(|solid| of_material[solid.material as usize].scatters())
            || ready_for.has(Effect::Scattering);
        let empty = air.is_vacuum() && solids.is_empty() && !scatters && !ready_for.has(Effect::Absorption);
        Self { solids, air, of_material, empty, scatters }
    }

    /// Whether there is nothing but vacuum, and nobody wants to know.
    #[inline]
    pub(crate) fn is_empty(&self) -> bool {
        self.empty
    }

    /// Whether any medium scatters, or somebody wants to know.
    #[inline]
    pub(crate) fn scatter(&self) -> bool {
        self.scatters
    }

    /// What lies outside all solids.
    #[inline]
    pub(crate) fn air(&self) -> &Medium {
        &self.air
    }

    /// The medium of a material, or [`AIR`].
    #[inline]
    pub(crate) fn medium(&self, index: u32) -> &Medium {
        self.of_material.get(index as usize).unwrap_or(&self.air)
    }

    /// The material of the innermost filled solid around a point, other than the instance `except`; [`AIR`] if there is
    /// none.
    pub(crate) fn around(&self, world: &World, point: DVec3, except: Option<u32>) -> u32 {
        let holds = |solid: &&Solid| {
            Some(solid.instance) != except && point.cmpge(solid.low).all() && point.cmple(solid.high).all()
        };
        let mut candidates: Vec<&Solid> = self.solids.iter().filter(holds).collect();
        let mut ray = Ray { origin: point, direction: DIRECTION.normalize() };
        for _ in 0..MOST_SURFACES {
            if candidates.is_empty() {
                return AIR;
            }
            crate::record::closest(&ray);
            let Some(hit) = world.intersect(&ray) else { return AIR };
            let surface = world.surface(&hit);
            if let Some(i) = candidates.iter().position(|solid| solid.instance == hit.instance) {
                if surface.ng.dot(ray.direction) > 0.0 {
                    return candidates[i].material;
                }
                // It is met from outside first, so the point is not in it.
                candidates.swap_remove(i);
            }
            ray = world.spawn(&Anchor { position: surface.position, normal: surface.ng }, ray.direction);
        }
        AIR
    }
}
