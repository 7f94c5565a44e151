//! Transmission through a rough thin wall: the reflection lobe, mirrored through the surface (KHR_materials_transmission).
//!
//! Local directions on opposite sides. Everything but the mirroring is [`crate::microfacet_reflection`].

use glam::DVec3;

/// `w` on the other side of the surface.
#[inline]
pub(crate) fn mirrored(w: DVec3) -> DVec3 {
    DVec3::new(w.x, w.y, -w.z)
}
