//! Path space (Veach 8-10): scene, vertices, paths, the measurement contribution, densities of every strategy, walks,
//! connection and multiple importance sampling.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod bidirectional;
mod brightness;
mod census;
mod contribution;
mod coverage;
pub mod density;
mod description;
mod edge;
mod error;
pub mod flight;
mod gap;
mod lights;
mod media;
mod path;
pub mod record;
mod scene;
mod space;
pub mod stability;
mod subpath;
mod vertex;

pub use bidirectional::{BidirectionalSampler, Connection, Lengths};
pub use brightness::BrightnessMap;
pub use census::{Census, Effect, Effects, Finding, Forced, Plan};
pub use contribution::{Contribution, contribution};
pub use coverage::Coverage;
pub use description::{CameraDescription, Placement, Projection, SceneDescription};
pub use edge::Edge;
pub use error::SceneError;
pub use path::{Path, PathClass};
pub use scene::{Compiled, Scene, View, Within, rays_traced};
pub use space::{LuminanceTarget, Measured, PathSpace};
pub use subpath::{End, Roulette, Subpath};
pub use vertex::{Kind, Vertex};
