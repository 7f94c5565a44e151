//! Which instructions a search uses. One file each; every one gives the same hits.
//!
//! The only module with unsafe code: a function that was compiled for certain instructions may be called only where the
//! processor has them. [`Isa`] can only be made for what it has, so each call is sound by the variant it matches.
#![allow(unsafe_code)]

#[cfg(test)]
mod faults;
#[cfg(target_arch = "aarch64")]
mod neon;
mod plain;
mod search;
#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
mod x86;

use std::borrow::Borrow;

use super::{Block, Owner, node::Node, ray::TreeRay};
use crate::{
    GeometryError,
    triangle::{Crossing, Shear},
};

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
    #[cfg(target_arch = "aarch64")]
    Neon,
    #[cfg(test)]
    Fused,
    #[cfg(test)]
    Hasty,
    #[cfg(test)]
    Unpadded,
}

/// Calls one of the three searches of the module that a set of instructions has.
macro_rules! dispatch {
    ($isa:expr, $search:ident($($argument:expr),*)) => {
        match $isa.0 {
            Kind::Plain => plain::$search($($argument),*),
            // SAFETY: the function needs AVX2 and FMA, and nothing else of its caller. `Kind::Avx2` is made in `Isa::available`
            // alone, where the processor was seen to have both.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => unsafe { x86::avx2::$search($($argument),*) },
            // SAFETY: the function needs AVX2, FMA and AVX-512 F, VL, DQ and BW. `Kind::Avx512` is made in `Isa::available`
            // alone, where the processor was seen to have them all.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => unsafe { x86::avx512::$search($($argument),*) },
            // SAFETY: the function needs NEON. `Kind::Neon` is made in `Isa::available` alone, where the processor was seen to
            // have it.
            #[cfg(target_arch = "aarch64")]
            Kind::Neon => unsafe { neon::$search($($argument),*) },
            #[cfg(test)]
            Kind::Fused => faults::fused::$search($($argument),*),
            #[cfg(test)]
            Kind::Hasty => faults::hasty::$search($($argument),*),
            #[cfg(test)]
            Kind::Unpadded => faults::unpadded::$search($($argument),*),
        }
    };
}

/// The environment variable that names one of [`Isa::available`], for comparisons and to rule a set out.
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
        #[cfg(target_arch = "aarch64")]
        if std::arch::is_aarch64_feature_detected!("neon") {
            all.push(Self(Kind::Neon));
        }
        all
    }

    /// The best set of this processor.
    pub fn best() -> Self {
        Self::available().pop().unwrap_or(Self(Kind::Plain))
    }

    /// The set that the environment variable `ERGODIC_ISA` names; the best if it is not set or empty.
    ///
    /// A name that this processor has no set for is an error: whoever sets the variable wants to know what is measured or ruled
    /// out, and would not find out from the answers, which are the same with all.
    pub fn from_environment() -> Result<Self, GeometryError> {
        match std::env::var_os(VARIABLE) {
            Some(name) => Self::named(&name.to_string_lossy()),
            None => Ok(Self::best()),
        }
    }

    fn named(name: &str) -> Result<Self, GeometryError> {
        if name.is_empty() {
            return Ok(Self::best());
        }
        let all = Self::available();
        all.iter().find(|isa| isa.name() == name).copied().ok_or_else(|| GeometryError::Instructions {
            name: name.to_owned(),
            available: all.iter().map(|isa| isa.name()).collect::<Vec<_>>().join(", "),
        })
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self.0 {
            Kind::Plain => "plain",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => "avx512",
            #[cfg(target_arch = "aarch64")]
            Kind::Neon => "neon",
            #[cfg(test)]
            Kind::Fused => "fused",
            #[cfg(test)]
            Kind::Hasty => "hasty",
            #[cfg(test)]
            Kind::Unpadded => "unpadded",
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
        dispatch!(self, closest(nodes, ray, shear, t_max, blocks, view, take))
    }

    /// Whether any triangle is crossed nearer than `t_max`.
    #[inline]
    pub(crate) fn any<'b, B: Borrow<Block>>(
        self,
        nodes: &[Node],
        ray: &TreeRay,
        shear: &Shear,
        t_max: f64,
        blocks: &'b [Block],
        view: impl Fn(&'b Block) -> B,
    ) -> bool {
        dispatch!(self, any(nodes, ray, shear, t_max, blocks, view))
    }

    /// Calls `look` for the primitives whose boxes the ray meets, until it returns true; it may lower the greatest parameter.
    #[inline]
    pub(crate) fn members(self, nodes: &[Node], ray: &TreeRay, look: impl FnMut(usize, &mut f32) -> bool) -> bool {
        dispatch!(self, members(nodes, ray, look))
    }
}
