//! The search trees: the only folder that knows `f32`, obvhs and SIMD.
//!
//! A tree lives in a cube [-1, 1]³ of its own. Its boxes are padded `f32` boxes and only choose which triangles are looked
//! at: a box that holds a hit is never left out. A block of triangles is then asked, in `f64` and with the very operations of
//! [`Shear::cross`], which of its triangles the line may cross; those alone go through the whole test. So what is hit, and
//! where, has the same bits whichever instructions the processor has.

mod blocks;
mod build;
mod cube;
mod isa;
mod node;
mod pages;
mod ray;
mod stack;

pub(crate) use blocks::{Block, Owner};
pub(crate) use build::{Place, Tree};
pub(crate) use cube::{Cube, CubeMap};
pub use isa::Isa;
pub(crate) use node::Child;
pub(crate) use pages::Pages;
pub(crate) use ray::TreeRay;

#[cfg(doc)]
use crate::triangle::Shear;
