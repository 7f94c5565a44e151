//! Markov chains on finitely many states, where everything that is estimated elsewhere can be computed.
//!
//! A [`TransitionMatrix`] is checked once and then gives its stationary distribution, its structure and, if it is
//! reversible, its spectrum. [`TransitionMatrix::enumerate`] writes down the matrix of *any* mutation over an enumerable state
//! space with the acceptance rule that [`Chain`](crate::Chain) uses, so that the rule itself is open to exact arithmetic.

mod error;
mod kernel;
mod matrix;
mod spectrum;
mod stationary;
mod structure;

pub use error::FiniteError;
pub use kernel::{FiniteProposal, FiniteTarget};
pub use matrix::TransitionMatrix;
pub use spectrum::Spectrum;
