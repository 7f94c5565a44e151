//! Metropolis-Hastings and nothing else.
//!
//! A [`Mutation`] proposes a new state together with a plan that describes the way back, and gives the exact joint
//! density of both. A [`Mixture`] chooses among mutations and is itself a mutation. A [`Chain`] moves one state under
//! a [`Target`]. Nothing here knows about rendering, threads or files.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod diagnostics;
pub mod finite;
pub mod unit_cube;

mod chain;
mod density;
mod mixture;
mod mutation;
mod random;

pub use chain::{Chain, Fault, Step, acceptance};
pub use density::{Density, renormalisation};
pub use mixture::{Mixture, MixtureError, NotProposed};
pub use mutation::{Mutation, Target};
pub use random::{RandomSource, Replay};
