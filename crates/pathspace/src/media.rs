//! Which absorbing solid a point lies in.
//!
//! A path that refracts into a solid knows it from the surface it crossed. One that starts inside, at a lamp, a light or the
//! camera, has to ask: a ray is sent out, and the first surface of a solid that it meets from within is that of the solid
//! around it.

use ergodic_geometry::{Anchor, Ray, World};
use glam::DVec3;

/// Stands for the air outside all solids, which does not absorb.
pub(crate) const AIR: u32 = u32::MAX;

/// The absorbing solids of a scene.
#[derive(Debug, Default)]
pub(crate) struct Media {
    solids: Vec<Solid>,
    /// Whether to ask though nothing absorbs.
    ready: bool,
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
    /// From `(instance, material)` of the solids that absorb.
    pub(crate) fn new(world: &World, solids: impl Iterator<Item = (u32, u32)>, ready: bool) -> Self {
        let solid = |(instance, material)| {
            let corners = (0..world.triangle_count(instance) as u32).flat_map(|t| world.triangle(instance, t));
            let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            let (low, high) = corners.fold(none, |(low, high), p| (low.min(p), high.max(p)));
            Solid { instance, material, low, high }
        };
        Self { solids: solids.map(solid).collect(), ready }
    }

    /// Whether nothing absorbs and nobody wants to know.
    #[inline]
    pub(crate) fn is_empty(&self) -> bool {
        self.solids.is_empty() && !self.ready
    }

    /// The material of the innermost absorbing solid around a point, other than the instance `except`; [`AIR`] if there is
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
