//! Surfaces that cover a part only of what lies behind them: rays that go on behind some hits, and the share of a segment's light
//! that passes all of them.
//!
//! What covers how much is the caller's to say. Worlds without such surfaces are asked by [`World::intersect`] and
//! [`World::visible`], which know nothing of this.

use glam::DVec3;

use crate::{Anchor, Hit, Ray, World};

/// Surfaces that a ray may pass. Where two of them meet in a sharp edge, a ray along it could leave the one only to meet the other,
/// again and again.
const MOST_SURFACES: usize = 4096;

impl World {
    /// The closest hit at which the ray stops; it goes on behind the others. `stops` is asked once for each hit, from the nearest
    /// on.
    pub fn intersect_where(&self, ray: &Ray, mut stops: impl FnMut(&Hit) -> bool) -> Option<Hit> {
        let mut ray = *ray;
        for _ in 0..MOST_SURFACES {
            let hit = self.intersect(&ray)?;
            if stops(&hit) {
                return Some(hit);
            }
            ray = self.behind(&hit, &ray);
        }
        None
    }

    /// The share of light that passes from one point to another, if each surface between them lets a share pass: the product of
    /// what `passes` says of them. Swapping the points gives the same bits, as for [`World::visible`], whose rules for near points
    /// hold here too.
    pub fn visibility(&self, a: &Anchor, b: &Anchor, passes: impl FnMut(&Hit) -> f64) -> f64 {
        let Some((low, high)) = self.segment(a, b) else { return 0.0 };
        let across = high - low;
        self.passing(Ray { origin: low, direction: across / across.length() }, Some(high), passes)
    }

    /// The share of light that passes between a point and infinity along the unit vector `direction`.
    pub fn visibility_from_afar(&self, a: &Anchor, direction: DVec3, passes: impl FnMut(&Hit) -> f64) -> f64 {
        self.passing(self.spawn(a, direction), None, passes)
    }

    /// The product over the surfaces on a ray, up to a point of it or to infinity.
    fn passing(&self, mut ray: Ray, end: Option<DVec3>, mut passes: impl FnMut(&Hit) -> f64) -> f64 {
        let mut share = 1.0;
        for _ in 0..MOST_SURFACES {
            let left = end.map_or(f64::INFINITY, |end| (end - ray.origin).dot(ray.direction));
            let Some(hit) = self.intersect(&ray).filter(|hit| hit.t < left) else { return share };
            share *= passes(&hit);
            if share <= 0.0 {
                return 0.0;
            }
            ray = self.behind(&hit, &ray);
        }
        0.0
    }

    /// The ray that goes on behind a hit, on the same line: as far off the surface as rays that start there, but not beside the line.
    /// A ray that was moved sideways at every surface would meet the one at its end, if that is seen at a grazing angle, before the
    /// end.
    fn behind(&self, hit: &Hit, ray: &Ray) -> Ray {
        let cos = self.surface(hit).ng.dot(ray.direction).abs();
        Ray { origin: ray.origin + ray.direction * (hit.t + self.offset() / cos), direction: ray.direction }
    }
}
