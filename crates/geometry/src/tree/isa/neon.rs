//! AArch64 with NEON: eight boxes and four triangles at a time, in two registers each.

use std::arch::aarch64::*;

use super::super::{
    Block,
    node::{Node, WIDTH},
    ray::TreeRay,
};
use super::search::search;
use crate::triangle::Shear;

/// Eight numbers.
type Eight = [float32x4_t; 2];

/// Four numbers.
type Four = [float64x2_t; 2];

/// What a search keeps of its ray.
#[derive(Clone, Copy)]
struct Slabs {
    inverse: [float32x4_t; 3],
    /// Minus origin times inverse: the parameter of a plane is then one fused operation.
    shift: [float32x4_t; 3],
    near: [usize; 3],
}

impl Slabs {
    #[target_feature(enable = "neon")]
    #[inline]
    fn new(ray: &TreeRay) -> Self {
        let inverse = |axis: usize| vdupq_n_f32(ray.inverse[axis]);
        let shift = |axis: usize| vdupq_n_f32(-ray.origin[axis] * ray.inverse[axis]);
        Self { inverse: [inverse(0), inverse(1), inverse(2)], shift: [shift(0), shift(1), shift(2)], near: ray.near }
    }

    /// Which children's boxes the ray meets before `t_max`, and where it enters them.
    #[target_feature(enable = "neon")]
    #[inline]
    fn meets(&self, node: &Node, t_max: f32) -> (u32, [f32; WIDTH]) {
        let plane = |axis: usize, side: usize| -> Eight {
            let planes: Eight = bytemuck::cast(node.planes[axis][side & 1]);
            planes.map(|planes| vfmaq_f32(self.shift[axis], planes, self.inverse[axis]))
        };
        let [x, y, z] = self.near;
        let first = [plane(0, x), plane(1, y), plane(2, z)];
        let second = [plane(0, x ^ 1), plane(1, y ^ 1), plane(2, z ^ 1)];
        let (zero, t_max) = (vdupq_n_f32(0.0), vdupq_n_f32(t_max));
        let near = [0, 1].map(|half| {
            let [x, y, z] = first.map(|planes| planes[half]);
            vmaxq_f32(vmaxq_f32(x, y), vmaxq_f32(z, zero))
        });
        let far = [0, 1].map(|half| {
            let [x, y, z] = second.map(|planes| planes[half]);
            vminq_f32(vminq_f32(x, y), vminq_f32(z, t_max))
        });
        let bits: uint32x4_t = bytemuck::cast([1u32, 2, 4, 8]);
        let [low, high] = [0, 1].map(|half| vaddvq_u32(vandq_u32(vcleq_f32(near[half], far[half]), bits)));
        (low | high << 4, bytemuck::cast(near))
    }
}

/// The ray of [`Shear`] for a block at a time.
#[derive(Clone, Copy)]
struct Edges {
    origin: [float64x2_t; 3],
    slope: [float64x2_t; 2],
    axes: [usize; 3],
}

impl Edges {
    #[target_feature(enable = "neon")]
    #[inline]
    fn new(shear: &Shear) -> Self {
        let origin = |axis: usize| vdupq_n_f64(shear.origin[axis]);
        Self {
            origin: [origin(0), origin(1), origin(2)],
            slope: [vdupq_n_f64(shear.slope[0]), vdupq_n_f64(shear.slope[1])],
            axes: shear.axes,
        }
    }

    /// Which triangles the line may cross; where, is left to [`Shear::cross`].
    ///
    /// Nothing is fused here, so every sign is the one that the whole test sees. The least and the greatest of numbers are NaN if
    /// one of them is; then neither is compared as true, and the triangle is kept for the whole test.
    #[target_feature(enable = "neon")]
    #[inline]
    fn cross(&self, block: &Block, _t_max: f64) -> Crossings {
        let corners = block.vertices.map(|corner| self.axes.map(|axis| bytemuck::cast::<_, Four>(corner[axis])));
        let pair = |half: usize| {
            let [(ax, ay), (bx, by), (cx, cy)] = corners.map(|corner| {
                let along = |i: usize| vsubq_f64(corner[i][half], self.origin[i]);
                let depth = along(2);
                let across = |i: usize| vsubq_f64(along(i), vmulq_f64(self.slope[i], depth));
                (across(0), across(1))
            });
            let wa = vsubq_f64(vmulq_f64(cx, by), vmulq_f64(cy, bx));
            let wb = vsubq_f64(vmulq_f64(ax, cy), vmulq_f64(ay, cx));
            let wc = vsubq_f64(vmulq_f64(bx, ay), vmulq_f64(by, ax));
            let zero = vdupq_n_f64(0.0);
            let below = vcltq_f64(vminq_f64(vminq_f64(wa, wb), wc), zero);
            let above = vcgtq_f64(vmaxq_f64(vmaxq_f64(wa, wb), wc), zero);
            let bits: uint64x2_t = bytemuck::cast([1u64, 2]);
            vaddvq_u64(vandq_u64(vandq_u64(below, above), bits)) as u32
        };
        Crossings::possible(!(pair(0) | pair(1) << 2) & 0xF)
    }
}

/// The processor is left to fetch what it needs: the intrinsic that asks for it is not yet stable.
#[inline(always)]
fn fetch(_nodes: &[Node], _blocks: &[Block], _child: Child) {}

search!(#[target_feature(enable = "neon")]);
