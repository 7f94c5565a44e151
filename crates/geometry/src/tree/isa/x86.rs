//! x86-64 with AVX2 and FMA or more: eight boxes and four triangles at a time.

use std::arch::x86_64::*;
use std::hint::select_unpredictable;

use super::super::{
    Block,
    node::{Child, Node, WIDTH},
    ray::TreeRay,
};
use super::search::search;
use crate::triangle::Shear;

/// Asks for what a child refers to, which will be needed soon. No branch asks which it is: half of the time it would be foretold
/// wrong.
#[inline(always)]
fn fetch(nodes: &[Node], blocks: &[Block], child: Child) {
    /// Bytes of a cache line.
    const LINE: usize = 64;
    const { assert!(size_of::<Node>() == 4 * LINE && size_of::<Block>() == 5 * LINE) };
    let node: *const i8 = nodes.as_ptr().wrapping_add(child.0 as usize).cast();
    let block: *const i8 = blocks.as_ptr().wrapping_add(child.primitives().0).cast();
    let start = select_unpredictable(child.is_leaf(), block, node);
    // The last line of a node is asked for twice.
    let last = select_unpredictable(child.is_leaf(), 4, 3);
    for line in [0, 1, 2, 3, last] {
        // SAFETY: a prefetch reads nothing that the program sees and faults at no address, so the pointer need not be valid; it is
        // made without `unsafe`, by wrapping arithmetic. SSE is part of x86-64.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(line * LINE)) };
    }
}

/// Defines the search for a set of features. With more of them the same operations find more registers.
macro_rules! x86 {
    ($name:ident, $features:literal) => {
        pub(super) mod $name {
            use super::*;

            /// What a search keeps of its ray.
            #[derive(Clone, Copy)]
            struct Slabs {
                inverse: [__m256; 3],
                /// Origin times inverse: the parameter of a plane is then one fused operation.
                shift: [__m256; 3],
                near: [usize; 3],
            }

            impl Slabs {
                #[target_feature(enable = $features)]
                #[inline]
                fn new(ray: &TreeRay) -> Self {
                    let splat = |axis: usize| _mm256_set1_ps(ray.inverse[axis]);
                    let shift = |axis: usize| _mm256_set1_ps(ray.origin[axis] * ray.inverse[axis]);
                    Self { inverse: [splat(0), splat(1), splat(2)], shift: [shift(0), shift(1), shift(2)], near: ray.near }
                }

                /// Which children's boxes the ray meets before `t_max`, and where it enters them.
                #[target_feature(enable = $features)]
                #[inline]
                fn meets(&self, node: &Node, t_max: f32) -> (u32, [f32; WIDTH]) {
                    let plane = |axis: usize, side: usize| {
                        let planes: __m256 = bytemuck::cast(node.planes[axis][side & 1]);
                        _mm256_fmsub_ps(planes, self.inverse[axis], self.shift[axis])
                    };
                    let [x, y, z] = self.near;
                    let near =
                        _mm256_max_ps(_mm256_max_ps(plane(0, x), plane(1, y)), _mm256_max_ps(plane(2, z), _mm256_setzero_ps()));
                    let far = _mm256_min_ps(
                        _mm256_min_ps(plane(0, x ^ 1), plane(1, y ^ 1)),
                        _mm256_min_ps(plane(2, z ^ 1), _mm256_set1_ps(t_max)),
                    );
                    let mask = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far));
                    (mask as u32, bytemuck::cast(near))
                }
            }

            /// The ray of [`Shear`] for a block at a time.
            #[derive(Clone, Copy)]
            struct Edges {
                origin: [__m256d; 3],
                slope: [__m256d; 2],
                per_z: __m256d,
                axes: [usize; 3],
            }

            impl Edges {
                #[target_feature(enable = $features)]
                #[inline]
                fn new(shear: &Shear) -> Self {
                    Self {
                        origin: [
                            _mm256_set1_pd(shear.origin[0]),
                            _mm256_set1_pd(shear.origin[1]),
                            _mm256_set1_pd(shear.origin[2]),
                        ],
                        slope: [_mm256_set1_pd(shear.slope[0]), _mm256_set1_pd(shear.slope[1])],
                        per_z: _mm256_set1_pd(shear.per_z),
                        axes: shear.axes,
                    }
                }

                /// Which triangles the ray crosses up to `t_max`, and where.
                ///
                /// Nothing is fused here and every operation is one of the whole test, [`Shear::cross`], in its order, so every
                /// sign and every number is the one that it sees. Where an edge function is zero, only the whole test knows.
                #[target_feature(enable = $features)]
                #[inline]
                fn cross(&self, block: &Block, t_max: f64) -> Crossings {
                    let sheared = |corner: usize| {
                        let along = |i: usize| {
                            let quad: __m256d = bytemuck::cast(block.vertices[corner][self.axes[i]]);
                            _mm256_sub_pd(quad, self.origin[i])
                        };
                        let depth = along(2);
                        let across = |i: usize| _mm256_sub_pd(along(i), _mm256_mul_pd(self.slope[i], depth));
                        (across(0), across(1), depth)
                    };
                    let ((ax, ay, az), (bx, by, bz), (cx, cy, cz)) = (sheared(0), sheared(1), sheared(2));
                    let wa = _mm256_sub_pd(_mm256_mul_pd(cx, by), _mm256_mul_pd(cy, bx));
                    let wb = _mm256_sub_pd(_mm256_mul_pd(ax, cy), _mm256_mul_pd(ay, cx));
                    let wc = _mm256_sub_pd(_mm256_mul_pd(bx, ay), _mm256_mul_pd(by, ax));
                    let zero = _mm256_setzero_pd();
                    let least = _mm256_min_pd(_mm256_min_pd(wa, wb), wc);
                    let greatest = _mm256_max_pd(_mm256_max_pd(wa, wb), wc);
                    let below = _mm256_cmp_pd::<_CMP_LT_OQ>(least, zero);
                    let above = _mm256_cmp_pd::<_CMP_GT_OQ>(greatest, zero);
                    let inside = !_mm256_movemask_pd(_mm256_and_pd(below, above)) & 0xF;
                    if inside == 0 {
                        return Crossings::possible(0);
                    }
                    let inverse = _mm256_div_pd(_mm256_set1_pd(1.0), _mm256_add_pd(_mm256_add_pd(wa, wb), wc));
                    let depth = _mm256_add_pd(
                        _mm256_add_pd(_mm256_mul_pd(wa, az), _mm256_mul_pd(wb, bz)),
                        _mm256_mul_pd(wc, cz),
                    );
                    let t = _mm256_mul_pd(_mm256_mul_pd(depth, self.per_z), inverse);
                    let ahead = _mm256_cmp_pd::<_CMP_GT_OQ>(t, zero);
                    let near = _mm256_cmp_pd::<_CMP_LE_OQ>(t, _mm256_set1_pd(t_max));
                    let is_zero = |w| _mm256_cmp_pd::<_CMP_EQ_OQ>(w, zero);
                    let unsure = _mm256_movemask_pd(_mm256_or_pd(_mm256_or_pd(is_zero(wa), is_zero(wb)), is_zero(wc)));
                    // No weight of a sure lane is zero or NaN and all have one sign, so their sum is not zero either.
                    let crossed = _mm256_movemask_pd(_mm256_and_pd(ahead, near));
                    Crossings {
                        possible: (inside & (unsure | crossed)) as u32,
                        certain: (inside & crossed & !unsure) as u32,
                        t: bytemuck::cast(t),
                        u: bytemuck::cast(_mm256_mul_pd(wb, inverse)),
                        v: bytemuck::cast(_mm256_mul_pd(wc, inverse)),
                    }
                }
            }

            search!(#[target_feature(enable = $features)]);
        }
    };
}

x86!(avx2, "avx2,fma");
x86!(avx512, "avx2,fma,avx512f,avx512vl,avx512dq,avx512bw");
