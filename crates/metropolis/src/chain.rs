//! One Markov chain.

use crate::{Mutation, RandomSource, Target};

/// A number that no correct kernel or target gives. The proposal is rejected and the fault reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The target density of the candidate, or of the state the chain was started at, is NaN or infinite.
    Target,
    /// The density of the proposal just made is NaN, infinite or zero.
    Forward,
    /// The density of the way back is NaN or infinite.
    Backward,
}

impl Fault {
    /// All faults, in the order in which tables show them.
    pub const ALL: [Self; 3] = [Self::Target, Self::Forward, Self::Backward];

    /// A name for tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Target => "target",
            Self::Forward => "forward",
            Self::Backward => "backward",
        }
    }
}

/// What one transition did. Statistics and splats are folds over these.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step<P, F> {
    /// No candidate was built: the chain stays.
    NotProposed(F),
    /// A candidate was built and accepted with probability `acceptance`.
    Tried {
        /// The plan of the proposal.
        plan: P,
        /// Hastings' acceptance probability, in `[0, 1]`.
        acceptance: f64,
        /// Whether the chain moved.
        accepted: bool,
    },
    /// A candidate was built but a density of it was not a number: rejected.
    Faulty {
        /// The plan of the proposal.
        plan: P,
        /// Which density.
        fault: Fault,
    },
}

/// A state, the room for a candidate, and the target's value at each.
///
/// ```
/// use std::convert::Infallible;
///
/// use ergodic_metropolis::{Chain, Mutation, RandomSource, Step, Target};
///
/// /// exp(-x²/2): the normal distribution, without its constant.
/// struct Bell;
///
/// impl Target for Bell {
///     type State = f64;
///     type Value = f64;
///
///     fn evaluate(&self, x: &f64) -> f64 {
///         -0.5 * x * x
///     }
///
///     fn ln_density(value: &f64) -> f64 {
///         *value
///     }
/// }
///
/// /// A step of at most 2 to either side.
/// struct Stroll;
///
/// impl Mutation for Stroll {
///     type Space = ();
///     type State = f64;
///     type Plan = ();
///     type Failure = Infallible;
///
///     fn propose(&self, _: &(), x: &f64, y: &mut f64, rng: &mut impl RandomSource) -> Result<(), Infallible> {
///         *y = x + 4.0 * rng.uniform() - 2.0;
///         Ok(())
///     }
///
///     fn ln_density(&self, _: &(), _: &f64, _: &f64, _: ()) -> f64 {
///         0.25f64.ln()
///     }
/// }
///
/// let mut rng = rand_pcg::Pcg64::new(1, 1);
/// let mut chain = Chain::new(0.0, &Bell);
/// let (mut squares, n) = (0.0, 100_000);
/// for _ in 0..n {
///     let step = chain.step(&Bell, &Stroll, &(), &mut rng);
///     assert!(matches!(step, Step::Tried { .. }));
///     squares += chain.current().0.powi(2);
/// }
/// assert!((squares / f64::from(n) - 1.0).abs() < 0.05);
/// ```
#[derive(Clone, Debug)]
pub struct Chain<S, V> {
    current: S,
    other: S,
    value: V,
    other_value: V,
}

impl<S: Clone, V: Copy> Chain<S, V> {
    /// A chain that starts at `state`.
    pub fn new<T: Target<State = S, Value = V>>(state: S, target: &T) -> Self {
        let value = target.evaluate(&state);
        Self { other: state.clone(), current: state, value, other_value: value }
    }

    /// Where the chain is, with the target's value there.
    pub fn current(&self) -> (&S, &V) {
        (&self.current, &self.value)
    }

    /// After [`Step::Tried`]: the state the chain is *not* in (the candidate if it was rejected, the state before if it
    /// was accepted), with the target's value there.
    pub fn other(&self) -> (&S, &V) {
        (&self.other, &self.other_value)
    }

    /// One Metropolis-Hastings transition (Hastings 1970): from x propose y with density T(x→y), accept with
    /// probability `min(1, f(y) T(y→x) / (f(x) T(x→y)))`.
    ///
    /// A candidate is never redrawn: whatever cannot be built or has no way back is a rejection.
    #[inline]
    pub fn step<T, M>(
        &mut self,
        target: &T,
        mutation: &M,
        space: &M::Space,
        rng: &mut impl RandomSource,
    ) -> Step<M::Plan, M::Failure>
    where
        T: Target<State = S, Value = V>,
        M: Mutation<State = S>,
    {
        let plan = match mutation.propose(space, &self.current, &mut self.other, rng) {
            Ok(plan) => plan,
            Err(reason) => return Step::NotProposed(reason),
        };
        self.other_value = target.evaluate(&self.other);
        let (x, y) = ((&self.current, &self.value), (&self.other, &self.other_value));
        let acceptance = match acceptance::<T, M>(mutation, space, x, y, plan) {
            Ok(acceptance) => acceptance,
            Err(fault) => return Step::Faulty { plan, fault },
        };
        let accepted = rng.uniform() < acceptance;
        if accepted {
            std::mem::swap(&mut self.current, &mut self.other);
            std::mem::swap(&mut self.value, &mut self.other_value);
        }
        Step::Tried { plan, acceptance, accepted }
    }
}

/// Hastings' acceptance probability `min(1, f(y) T(y→x) / (f(x) T(x→y)))` for the candidate y that `plan` made of x; the very
/// function that [`Chain::step`] uses.
///
/// Each state comes with the target's value there. A candidate where the target is 0, or from which there is no way back,
/// has probability 0; from a state where the target is 0 every other candidate has probability 1.
///
/// # Errors
///
/// A target or a density that is not a number: see [`Fault`].
#[inline]
pub fn acceptance<T, M>(
    mutation: &M,
    space: &M::Space,
    (x, value_x): (&M::State, &T::Value),
    (y, value_y): (&M::State, &T::Value),
    plan: M::Plan,
) -> Result<f64, Fault>
where
    T: Target<State = M::State>,
    M: Mutation,
{
    let (fx, fy) = (T::density(value_x), T::density(value_y));
    if !fx.is_valid() || !fy.is_valid() {
        return Err(Fault::Target);
    }
    if fy.is_zero() {
        return Ok(0.0);
    }
    let forward = mutation.density(space, x, y, plan);
    if !forward.is_valid() || forward.is_zero() {
        return Err(Fault::Forward);
    }
    let backward = mutation.density(space, y, x, plan);
    if !backward.is_valid() {
        return Err(Fault::Backward);
    }
    if backward.is_zero() {
        return Ok(0.0);
    }
    if fx.is_zero() {
        return Ok(1.0);
    }
    Ok(fy.times(backward).ratio_to(fx.times(forward)).min(1.0))
}
