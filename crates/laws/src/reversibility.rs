//! The way back: every proposal that is made must be one that could be made in the other direction.

use ergodic_metropolis::{Mutation, RandomSource, Target, acceptance};

/// What became of the proposals that [`way_back`] looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WayBack<P> {
    /// Proposals asked for.
    pub asked: u64,
    /// Candidates that were built.
    pub built: u64,
    /// Candidates that `propose` made though `ln_density` says it cannot, or gives no number. Must be 0.
    pub forward_faults: u64,
    /// Candidates whose density back is NaN or infinite. Must be 0.
    pub backward_faults: u64,
    /// Candidates without a way back. Each is a sure rejection: some kernels have a few by nature, most have none.
    pub one_way: u64,
    /// The plan of the first candidate that was counted under any of the three.
    pub example: Option<P>,
}

impl<P> WayBack<P> {
    /// No faults, something was built, and at most the share `one_way` of the candidates has no way back.
    pub fn holds(&self, one_way: f64) -> bool {
        self.built > 0
            && self.forward_faults == 0
            && self.backward_faults == 0
            && self.one_way as f64 <= one_way * self.built as f64
    }
}

/// Proposes once from each of `n` states of `draw` and looks at the density both ways.
pub fn way_back<M, R>(
    mutation: &M,
    space: &M::Space,
    mut draw: impl FnMut(&mut R) -> M::State,
    n: u64,
    rng: &mut R,
) -> WayBack<M::Plan>
where
    M: Mutation,
    M::State: Clone,
    R: RandomSource,
{
    let mut report = WayBack { asked: n, built: 0, forward_faults: 0, backward_faults: 0, one_way: 0, example: None };
    for _ in 0..n {
        let x = draw(rng);
        let mut y = x.clone();
        let Ok(plan) = mutation.propose(space, &x, &mut y, rng) else { continue };
        report.built += 1;
        let forward = mutation.ln_density(space, &x, &y, plan);
        let backward = mutation.ln_density(space, &y, &x, plan);
        let fault = if !forward.is_finite() {
            &mut report.forward_faults
        } else if backward == f64::NEG_INFINITY {
            &mut report.one_way
        } else if !backward.is_finite() {
            &mut report.backward_faults
        } else {
            continue;
        };
        *fault += 1;
        report.example.get_or_insert(plan);
    }
    report
}

/// How well K(x→y) f(x) = K(y→x) f(y) holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetailedBalance<P> {
    /// Pairs with f > 0 at both ends.
    pub pairs: u64,
    /// Pairs for which a density was not a number.
    pub faults: u64,
    /// Largest |ln (K(x→y) f(x)) - ln (K(y→x) f(y))|.
    pub worst: f64,
    /// The plan of that pair.
    pub worst_plan: Option<P>,
}

impl<P> DetailedBalance<P> {
    /// Some pairs were looked at, none was faulty, and the residual is at most `tolerance`.
    pub fn holds(&self, tolerance: f64) -> bool {
        self.pairs > 0 && self.faults == 0 && self.worst <= tolerance
    }
}

/// Compares the flow both ways for the pairs that one proposal from each of `n` states of `draw` makes, with the
/// acceptance function that the chain itself uses.
///
/// This holds for *any* symmetric use of a density, right or wrong: it finds a mistake in the acceptance rule or in what
/// plan and states a density reads. That the density is the sampler's own is the business of [`volume`](crate::volume())
/// and [`Invariance`](crate::Invariance).
pub fn detailed_balance<T, M, R>(
    target: &T,
    mutation: &M,
    space: &M::Space,
    mut draw: impl FnMut(&mut R) -> M::State,
    n: u64,
    rng: &mut R,
) -> DetailedBalance<M::Plan>
where
    T: Target<State = M::State>,
    M: Mutation,
    M::State: Clone,
    R: RandomSource,
{
    let mut report = DetailedBalance { pairs: 0, faults: 0, worst: 0.0, worst_plan: None };
    for _ in 0..n {
        let x = draw(rng);
        let mut y = x.clone();
        let Ok(plan) = mutation.propose(space, &x, &mut y, rng) else { continue };
        let (fx, fy) = (target.evaluate(&x), target.evaluate(&y));
        let (ln_fx, ln_fy) = (T::ln_density(&fx), T::ln_density(&fy));
        if ln_fx == f64::NEG_INFINITY || ln_fy == f64::NEG_INFINITY {
            continue;
        }
        report.pairs += 1;
        let there = acceptance::<T, M>(mutation, space, (&x, &fx), (&y, &fy), plan);
        // Without a way back the chain never takes the way there, and there is nothing to balance.
        if there == Ok(0.0) && mutation.ln_density(space, &y, &x, plan) == f64::NEG_INFINITY {
            continue;
        }
        let back = acceptance::<T, M>(mutation, space, (&y, &fy), (&x, &fx), plan);
        let (Ok(there), Ok(back)) = (there, back) else {
            report.faults += 1;
            continue;
        };
        let forth = mutation.ln_density(space, &x, &y, plan) + there.ln() + ln_fx;
        let home = mutation.ln_density(space, &y, &x, plan) + back.ln() + ln_fy;
        let residual = if forth == home { 0.0 } else { (forth - home).abs() };
        // A residual that is not a number is the worst there is.
        if residual.is_nan() || residual > report.worst || report.worst_plan.is_none() {
            report.worst = if residual.is_nan() { f64::INFINITY } else { residual.max(report.worst) };
            report.worst_plan = Some(plan);
        }
    }
    report
}
