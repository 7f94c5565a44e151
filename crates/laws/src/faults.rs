//! Planted faults: the mistakes that the laws are there to find.
//!
//! Each wrapper samples as the kernel inside does and lies about the density, which is what a real mistake looks like.

use std::fmt::Debug;
use std::sync::atomic::{AtomicU64, Ordering};

use ergodic_metropolis::{Mixture, Mutation, NotProposed, RandomSource};

/// Forgets the probability of the choice among the members.
#[derive(Clone, Debug)]
pub struct Forgetful<M>(pub Mixture<M>);

/// Takes the probability of the choice from the state that is moved *to*.
#[derive(Clone, Debug)]
pub struct WrongPath<M>(pub Mixture<M>);

/// Everything of a mutation but its density, from the mutation in the field `$inner`.
macro_rules! sample_like {
    ($inner:tt, $state:ty, $space:ty, $plan:ty, $failure:ty) => {
        type Space = $space;
        type State = $state;
        type Plan = $plan;
        type Failure = $failure;

        fn suitability(&self, space: &Self::Space, x: &Self::State) -> f64 {
            self.$inner.suitability(space, x)
        }

        fn propose(
            &self,
            space: &Self::Space,
            x: &Self::State,
            y: &mut Self::State,
            rng: &mut impl RandomSource,
        ) -> Result<Self::Plan, Self::Failure> {
            self.$inner.propose(space, x, y, rng)
        }
    };
}

impl<M: Mutation> Mutation for Forgetful<M> {
    sample_like!(0, M::State, M::Space, (usize, M::Plan), NotProposed<M::Failure>);

    fn ln_density(&self, space: &M::Space, from: &M::State, to: &M::State, (index, plan): Self::Plan) -> f64 {
        self.0.members()[index].1.ln_density(space, from, to, plan)
    }
}

impl<M: Mutation> Mutation for WrongPath<M> {
    sample_like!(0, M::State, M::Space, (usize, M::Plan), NotProposed<M::Failure>);

    fn ln_density(&self, space: &M::Space, from: &M::State, to: &M::State, (index, plan): Self::Plan) -> f64 {
        self.0.probability(index, space, to).ln() + self.0.members()[index].1.ln_density(space, from, to, plan)
    }
}

/// Multiplies the density by a factor of (from, to, plan): a Jacobian lost on one side, a density too large by a
/// constant in half the domain, a range checked against the wrong state.
#[derive(Clone, Debug)]
pub struct Scaled<M, F> {
    /// The correct kernel.
    pub mutation: M,
    /// The wrong factor, not negative.
    pub factor: F,
}

impl<M, F> Mutation for Scaled<M, F>
where
    M: Mutation,
    F: Fn(&M::State, &M::State, M::Plan) -> f64,
{
    sample_like!(mutation, M::State, M::Space, M::Plan, M::Failure);

    fn ln_density(&self, space: &M::Space, from: &M::State, to: &M::State, plan: M::Plan) -> f64 {
        self.mutation.ln_density(space, from, to, plan) + (self.factor)(from, to, plan).ln()
    }
}

/// Gives NaN for every `period`-th density.
#[derive(Debug)]
pub struct NonFinite<M> {
    mutation: M,
    period: u64,
    calls: AtomicU64,
}

impl<M> NonFinite<M> {
    /// `mutation` with NaN for every `period`-th density asked for.
    pub fn new(mutation: M, period: u64) -> Self {
        Self { mutation, period: period.max(1), calls: AtomicU64::new(0) }
    }
}

impl<M: Mutation> Mutation for NonFinite<M> {
    sample_like!(mutation, M::State, M::Space, M::Plan, M::Failure);

    fn ln_density(&self, space: &M::Space, from: &M::State, to: &M::State, plan: M::Plan) -> f64 {
        let call = self.calls.fetch_add(1, Ordering::Relaxed) + 1;
        if call.is_multiple_of(self.period) { f64::NAN } else { self.mutation.ln_density(space, from, to, plan) }
    }
}
