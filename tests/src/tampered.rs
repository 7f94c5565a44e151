//! Kernels with a planted fault: proposals as they are, densities changed.

use std::fmt;

use ergodic_metropolis::{Mutation, RandomSource};
use ergodic_pathspace::{Path, PathSpace};

/// A kernel whose ln density is what `ln_density` makes of the right one, given the space, both paths and the plan.
pub struct Tampered<M, F> {
    /// The kernel that proposes.
    pub inner: M,
    /// The change.
    pub ln_density: F,
}

impl<M: fmt::Debug, F> fmt::Debug for Tampered<M, F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Tampered").field("inner", &self.inner).finish_non_exhaustive()
    }
}

impl<M, F> Mutation for Tampered<M, F>
where
    M: Mutation<Space = PathSpace, State = Path>,
    F: Fn(&PathSpace, &Path, &Path, M::Plan, f64) -> f64,
{
    type Space = PathSpace;
    type State = Path;
    type Plan = M::Plan;
    type Failure = M::Failure;

    fn suitability(&self, space: &PathSpace, x: &Path) -> f64 {
        self.inner.suitability(space, x)
    }

    fn propose(
        &self,
        space: &PathSpace,
        x: &Path,
        y: &mut Path,
        rng: &mut impl RandomSource,
    ) -> Result<Self::Plan, Self::Failure> {
        self.inner.propose(space, x, y, rng)
    }

    fn ln_density(&self, space: &PathSpace, from: &Path, to: &Path, plan: Self::Plan) -> f64 {
        (self.ln_density)(space, from, to, plan, self.inner.ln_density(space, from, to, plan))
    }
}
