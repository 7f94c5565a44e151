//! Which instructions a search uses. One file each; every one gives the same hits.
//!
//! The only module with unsafe code: a function that was compiled for certain instructions may be called only where the
//! processor has them. [`Isa`] can only be made for what it has, so each call is sound by the variant it matches.
#![allow(unsafe_code)]

mod plain;
mod search;
#[cfg(target_arch = "x86_64")]
mod x86;

use std::borrow::Borrow;

use super::{Block, Owner, node::Node, ray::TreeRay};
use crate::triangle::{Crossing, Shear};

/// A set of instructions that this processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Isa(Kind);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Plain,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

/// Names one of [`Isa::available`]; for tests and comparisons.
const VARIABLE: &str = "ERGODIC_ISA";

impl Isa {
    /// All sets that this processor has, the best last.
    pub fn available() -> Vec<Self> {
        let mut all = vec![Self(Kind::Plain)];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                all.push(Self(Kind::Avx2));
                let more = is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512vl");
                if more && is_x86_feature_detected!("avx512dq") && is_x86_feature_detected!("avx512bw") {
                    all.push(Self(Kind::Avx512));
                }
            }
        }
        all
    }

    /// The best set of this processor; the one that the environment variable `ERGODIC_ISA` names, if it has it.
    pub fn best() -> Self {
        let all = Self::available();
        let wanted = std::env::var(VARIABLE).ok();
        let named = all.iter().find(|isa| wanted.as_deref() == Some(isa.name()));
        *named.or(all.last()).unwrap_or(&Self(Kind::Plain))
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self.0 {
            Kind::Plain => "plain",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => "avx512",
        }
    }

    /// Calls `take` for every crossing with a triangle nearer than `t_max`, and with its owner; it returns the new `t_max`.
    #[inline]
    pub(crate) fn closest<'b, B: Borrow<Block>>(
        self,
        nodes: &[Node],
        ray: &TreeRay,
        shear: &Shear,
        t_max: f64,
        blocks: &'b [Block],
        view: impl Fn(&'b Block) -> B,
        take: impl FnMut(Crossing, Owner) -> Option<f64>,
    ) {
        match self.0 {
            Kind::Plain => plain::closest(nodes, ray, shear, t_max, blocks, view, take),
            // SAFETY: the variant is made only where the processor has these instructions.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => unsafe { x86::avx2::closest(nodes, ray, shear, t_max, blocks, view, take) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => unsafe { x86::avx512::closest(nodes, ray, shear, t_max, blocks, view, take) },
        }
    }

    /// The slot of any triangle that is crossed nearer than `t_max`.
    #[inline]
    pub(crate) fn any<'b, B: Borrow<Block>>(
        self,
        nodes: &[Node],
        ray: &TreeRay,
        shear: &Shear,
        t_max: f64,
        blocks: &'b [Block],
        view: impl Fn(&'b Block) -> B,
    ) -> Option<usize> {
        match self.0 {
            Kind::Plain => plain::any(nodes, ray, shear, t_max, blocks, view),
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => unsafe { x86::avx2::any(nodes, ray, shear, t_max, blocks, view) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => unsafe { x86::avx512::any(nodes, ray, shear, t_max, blocks, view) },
        }
    }

    /// Calls `look` for the primitives whose boxes the ray meets, until it returns true; it may lower the greatest parameter.
    #[inline]
    pub(crate) fn members(self, nodes: &[Node], ray: &TreeRay, look: impl FnMut(usize, &mut f32) -> bool) -> bool {
        match self.0 {
            Kind::Plain => plain::members(nodes, ray, look),
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => unsafe { x86::avx2::members(nodes, ray, look) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => unsafe { x86::avx512::members(nodes, ray, look) },
        }
    }
}
