//! Frames, instanced triangle meshes, a two-level BVH and one self-intersection policy.
//!
//! Positions, hits and surfaces are `f64`; only the search tree is `f32`, and it is conservative: it may visit more
//! triangles than it must, never fewer. The triangle test that decides is watertight and runs in world space, so a hit
//! has the same bits whether its mesh is baked into the static tree or shared by several instances.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod covering;
mod epsilon;
mod error;
mod frame;
mod hidden;
mod levels;
mod mesh;
pub mod phase;
mod placement;
mod places;
mod series;
mod surface;
mod tree;
mod triangle;
mod world;

pub use epsilon::spawn_offset;
pub use error::GeometryError;
pub use frame::Frame;
pub use mesh::Mesh;
pub use series::{asin, exp, sin_cos_eighth, sin_cos_turns};
pub use surface::Surface;
pub use tree::Isa;
pub use world::{Anchor, Hit, Instance, Ray, World};
