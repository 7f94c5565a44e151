//! A ray in a tree's cube, in `f32`.

use glam::DVec3;

use crate::epsilon::{TREE_MIN_COMPONENT, TREE_PADDING, TREE_REACH, f32_above};

/// A ray in a tree's cube, with the map from its parameter to the caller's.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TreeRay {
    pub(crate) origin: [f32; 3],
    /// Reciprocals of the direction's components, all finite.
    pub(crate) inverse: [f32; 3],
    /// The plane that the ray meets first along each axis: 0 for the lower, 1 for the upper.
    pub(crate) near: [usize; 3],
    /// Greatest parameter.
    pub(crate) t_max: f32,
    /// The caller's t at the `f32` origin.
    entry: f64,
    /// `f32` parameter per caller's t.
    scale: f64,
}

/// Directions whose largest component is in this range are taken as they are; others are scaled, so that the unit of a world
/// may be anything.
const USUAL: std::ops::Range<f64> = 1e-6..1e6;

impl TreeRay {
    /// The part 0 <= t <= `t_max` of a ray given in the cube's coordinates; `None` if it misses the cube.
    #[inline(always)]
    pub(crate) fn new(mut origin: DVec3, direction: DVec3, t_max: f64) -> Option<Self> {
        let largest = direction.abs().max_element();
        let mut scale = 1.0;
        let mut d = direction;
        if !USUAL.contains(&largest) {
            // A zero direction and NaN hit nothing.
            if !(largest > 0.0 && largest < f64::INFINITY) {
                return None;
            }
            scale = largest;
            d = direction / largest;
        }
        if !(origin.x + origin.y + origin.z).is_finite() {
            return None;
        }
        let mut entry = 0.0;
        if origin.abs().max_element() > TREE_REACH {
            entry = enter_cube(origin, direction, t_max)?;
            origin += direction * entry;
        }
        let reciprocal = |d: f64| {
            let least = TREE_MIN_COMPONENT as f32;
            let d = d as f32;
            1.0 / d.abs().max(least).copysign(d)
        };
        let inverse = [reciprocal(d.x), reciprocal(d.y), reciprocal(d.z)];
        Some(Self {
            origin: origin.as_vec3().to_array(),
            inverse,
            near: inverse.map(|i| usize::from(i < 0.0)),
            t_max: f32_above((t_max - entry) * scale),
            entry,
            scale,
        })
    }

    /// A parameter of the tree that is certainly not below the caller's `t`.
    #[inline]
    pub(crate) fn above(&self, t: f64) -> f32 {
        f32_above((t - self.entry) * self.scale)
    }
}

/// Where a ray that starts outside enters the slightly enlarged cube.
#[cold]
fn enter_cube(origin: DVec3, direction: DVec3, t_max: f64) -> Option<f64> {
    let edge = DVec3::splat(1.0 + 2.0 * TREE_PADDING);
    let (mut near, mut far) = (0f64, t_max);
    for axis in 0..3 {
        let (o, d) = (origin[axis], direction[axis]);
        if d == 0.0 {
            if o.abs() > edge[axis] {
                return None;
            }
        } else {
            let (a, b) = ((-edge[axis] - o) / d, (edge[axis] - o) / d);
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
    }
    (near <= far).then_some(near)
}
