//! Proposal kernels and targets.

use std::fmt::Debug;

use crate::{Density, RandomSource};

/// A proposal kernel with an explicit transition density.
///
/// # Law
///
/// `propose` from `x` yields `(plan, y)` with joint density `exp(ln_density(x, y, plan))`, in `y`'s own measure, and the
/// *same* plan describes the way back: the reverse transition has density `exp(ln_density(y, x, plan))`. Where several
/// internal choices lead to the same `(plan, y)`, the density is the sum over all of them.
///
/// A mutation counts nothing and keeps nothing: statistics are folds over the [`Step`](crate::Step)s of a chain.
pub trait Mutation {
    /// What the states live in (a scene, a matrix); `()` if nothing is needed.
    type Space: ?Sized;
    /// A state of the chain.
    type State;
    /// What a proposal kept and replaced. Symmetric in the two states.
    type Plan: Copy + PartialEq + Debug;
    /// Why no candidate was produced.
    type Failure: Copy + PartialEq + Debug;

    /// The relative weight with which this kernel wants to be chosen from `x`: 0 where it cannot apply.
    ///
    /// A [`Mixture`](crate::Mixture) multiplies it into the user's weight; it is part of the transition density there.
    fn suitability(&self, _space: &Self::Space, _x: &Self::State) -> f64 {
        1.0
    }

    /// Writes a candidate to `y` and returns the plan, or says why none could be built. A failure is a rejection.
    ///
    /// `y` arrives holding some earlier state; its buffers may be reused, its content may not be relied on.
    fn propose(
        &self,
        space: &Self::Space,
        x: &Self::State,
        y: &mut Self::State,
        rng: &mut impl RandomSource,
    ) -> Result<Self::Plan, Self::Failure>;

    /// The natural logarithm of the joint density of `(plan, to)` given `from`; `-inf` where it cannot happen.
    fn ln_density(&self, space: &Self::Space, from: &Self::State, to: &Self::State, plan: Self::Plan) -> f64;

    /// The same density without its logarithm; what a [`Chain`](crate::Chain) asks for. A kernel whose density is a product
    /// gives it here and has its logarithm in [`Self::ln_density`].
    #[inline]
    fn density(&self, space: &Self::Space, from: &Self::State, to: &Self::State, plan: Self::Plan) -> Density {
        Density::from_ln(self.ln_density(space, from, to, plan))
    }
}

/// The unnormalised density that a chain should spend its time by.
pub trait Target {
    /// A state of the chain.
    type State;
    /// All that one evaluation yields; kept by the chain beside the state, so that it is computed once.
    type Value: Copy + Debug;

    /// Evaluates the target at `x`.
    fn evaluate(&self, x: &Self::State) -> Self::Value;

    /// The natural logarithm of the target density, in the same measure as [`Mutation::ln_density`]; `-inf` for 0.
    fn ln_density(value: &Self::Value) -> f64;

    /// The same density without its logarithm; what a [`Chain`](crate::Chain) asks for.
    #[inline]
    fn density(value: &Self::Value) -> Density {
        Density::from_ln(Self::ln_density(value))
    }
}
