//! Every tolerance of the crate, and why each is what it is.
//!
//! The errors to cover are of two kinds. The search tree is `f32`: its boxes must be padded so that rounding never hides a
//! triangle. The hits are `f64`: a point computed on a triangle lies off it by a few units in the last place of its
//! coordinates, so rays that leave it start a little way out.

use glam::DVec3;

/// Coordinates and their squares stay finite below this.
pub(crate) const MAX_COORDINATE: f64 = 1e100;

/// Padding of every box of a search tree, in units of the tree's cube [-1, 1]³.
///
/// Along each axis, in units of u = 2⁻²⁴ with the origin within [`TREE_REACH`] = 4, so that a plane of the cube is at most 5 away
/// from it: rounding of the box 1, of the ray's origin 4, of origin times inverse 4, of the direction and its inverse 2 times 5, and
/// of the parameter of the plane, `fma(p, 1/d, -o/d)` or `(p - o) * (1/d)`, at most 2 times 5. That is 29 u; 64 u = 32
/// `f32::EPSILON` leaves a factor of two. Widened by it along every axis, a box is entered before and left after all that lies in
/// it, also where t itself is rounded: |d| is at most 1, so the padding is worth at least 64 u in t, and t is at most 9.
pub(crate) const TREE_PADDING: f64 = 32.0 * f32::EPSILON as f64;

/// Rays whose origin is farther out, in units of the tree's cube, start where they enter the cube: rounding a far origin to `f32`
/// would undo the padding.
pub(crate) const TREE_REACH: f64 = 4.0;

/// Smallest component of a direction inside a tree: over the whole cube it moves the ray by less than any padding, and its
/// reciprocal is finite, so that `0 * (1 / d)` is never NaN.
pub(crate) const TREE_MIN_COMPONENT: f64 = 1e-18;

/// Triangles whose sine at the corner is below this, with edges measured by the longest, have no direction left after
/// rounding: they count as degenerate.
pub(crate) const DEGENERATE_SINE: f64 = 1e-15;

/// Error of a ray transformed to a tree's cube above which a mesh is baked instead: a sixteenth of the padding.
pub(crate) const MAX_TRANSFORM_ERROR: f64 = TREE_PADDING / 16.0;

/// A hit's position is exact to about 4 units of 2⁻⁵² of its coordinates. Rays leave surfaces at 1e-12 of the scene's
/// diagonal plus 64 such units of its farthest coordinate: three orders of magnitude above the error. Both error and offset
/// grow by the same 1 / cos along a grazing ray, so the ratio holds at any angle and no slack in t is needed: rays start at
/// t = 0.
///
/// It should be no larger than it must be: a ray drawn in one direction arrives where another direction from the surface itself
/// would have, which is an error of twice the offset over the distance in every density of a short edge.
const OFFSET_PER_DIAGONAL: f64 = 1e-12;
const OFFSET_PER_COORDINATE: f64 = 64.0 * f64::EPSILON;

/// How far off the surface rays start, in the units of the world, given the corners of the box around it.
pub fn spawn_offset(min: DVec3, max: DVec3) -> f64 {
    (max - min).length() * OFFSET_PER_DIAGONAL + min.abs().max(max.abs()).max_element() * OFFSET_PER_COORDINATE
}

/// The smallest `f32` that is certainly not below `t`: culling with it keeps every box that holds something nearer.
#[inline]
pub(crate) fn f32_above(t: f64) -> f32 {
    (t as f32).next_up()
}
