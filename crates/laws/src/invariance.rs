//! One step from the target must lead to the target.
//!
//! Let x have density p and weight w = f/p. One step of a correct chain leaves the weighted distribution as it is, so
//! the mean of D = w a (h(y) - h(x)) is 0 for every test function h, with a the acceptance probability. Neither burn-in
//! nor mixing nor the normalisation of f enters. This finds what a histogram of proposals cannot: mistakes in the way back.

use ergodic_metropolis::{Chain, Mutation, RandomSource, Step, Target};

use crate::{normal_limit, sidak};

/// Accumulates one-step drifts of several test functions.
#[derive(Clone, Debug, PartialEq)]
pub struct Invariance {
    sums: Vec<(f64, f64)>,
    steps: u64,
    moves: u64,
    faults: u64,
}

/// The outcome of the invariance law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InvarianceVerdict {
    /// Largest |t| over the test functions; infinite if a faulty number was seen or nothing ever moved.
    pub max_t: f64,
    /// The test function that has it.
    pub function: usize,
    /// The |t| that `alpha` allows for all functions together (Sidak).
    pub limit: f64,
    /// Whether the law holds.
    pub holds: bool,
}

impl Invariance {
    /// For `functions` test functions.
    pub fn new(functions: usize) -> Self {
        Self { sums: vec![(0.0, 0.0); functions], steps: 0, moves: 0, faults: 0 }
    }

    /// Takes one step: the start's weight w = f(x)/p(x), the candidate's acceptance probability, and the test functions at
    /// both.
    ///
    /// # Panics
    ///
    /// If the slices are not as long as the number of test functions.
    pub fn record(&mut self, weight: f64, acceptance: f64, h_x: &[f64], h_y: &[f64]) {
        assert!(h_x.len() == self.sums.len() && h_y.len() == self.sums.len(), "one value for each test function");
        self.steps += 1;
        let flow = weight * acceptance;
        if !flow.is_finite() || flow < 0.0 {
            self.faults += 1;
            return;
        }
        if flow == 0.0 {
            return;
        }
        self.moves += 1;
        for ((sum, squares), (x, y)) in self.sums.iter_mut().zip(h_x.iter().zip(h_y)) {
            let drift = flow * (y - x);
            *sum += drift;
            *squares += drift * drift;
        }
    }

    /// Takes one step for which no candidate was built.
    pub fn record_stay(&mut self) {
        self.steps += 1;
    }

    /// Takes one step whose densities were not numbers. The law fails.
    pub fn record_fault(&mut self) {
        self.steps += 1;
        self.faults += 1;
    }

    /// Takes all that `other` has seen.
    ///
    /// # Panics
    ///
    /// If the two have not the same number of test functions.
    pub fn merge(&mut self, other: &Self) {
        assert_eq!(self.sums.len(), other.sums.len(), "the same test functions");
        for (mine, theirs) in self.sums.iter_mut().zip(&other.sums) {
            *mine = (mine.0 + theirs.0, mine.1 + theirs.1);
        }
        self.steps += other.steps;
        self.moves += other.moves;
        self.faults += other.faults;
    }

    /// Steps taken, moves possible (weight and acceptance above 0) and faults among them.
    pub fn counts(&self) -> (u64, u64, u64) {
        (self.steps, self.moves, self.faults)
    }

    /// t = ΣD / sqrt(ΣD²) of each test function; 0 for one that never changed, infinite for one that was not a number.
    pub fn t(&self) -> Vec<f64> {
        let t = |&(sum, squares): &(f64, f64)| {
            if squares == 0.0 {
                0.0
            } else {
                let t = sum / squares.sqrt();
                if t.is_nan() { f64::INFINITY } else { t }
            }
        };
        self.sums.iter().map(t).collect()
    }

    /// Whether all test functions are at rest, at the level `alpha` for all together.
    pub fn verdict(&self, alpha: f64) -> InvarianceVerdict {
        let (function, mut max_t) = self
            .t()
            .into_iter()
            .map(f64::abs)
            .enumerate()
            .fold((0, 0.0), |worst, (i, t)| if t > worst.1 { (i, t) } else { worst });
        // A kernel that never moves leaves everything invariant; that is not what is asked.
        if self.faults > 0 || self.moves == 0 {
            max_t = f64::INFINITY;
        }
        let limit = normal_limit(sidak(alpha, self.sums.len()));
        InvarianceVerdict { max_t, function, limit, holds: max_t <= limit }
    }
}

/// Takes one step of a chain from each of `n` states of `draw`, which gives a state with its weight f/p, or nothing for a
/// sample of weight 0. `h` are the test functions.
pub fn one_step_invariance<T, M, R, const N: usize>(
    target: &T,
    mutation: &M,
    space: &M::Space,
    mut draw: impl FnMut(&mut R) -> Option<(M::State, f64)>,
    h: impl Fn(&M::State) -> [f64; N],
    n: u64,
    rng: &mut R,
) -> Invariance
where
    T: Target<State = M::State>,
    M: Mutation,
    M::State: Clone,
    R: RandomSource,
{
    let mut invariance = Invariance::new(N);
    for _ in 0..n {
        let Some((x, weight)) = draw(rng) else {
            invariance.record_stay();
            continue;
        };
        let h_x = h(&x);
        let mut chain = Chain::new(x, target);
        match chain.step(target, mutation, space, rng) {
            Step::NotProposed(_) => invariance.record_stay(),
            Step::Faulty { .. } => invariance.record_fault(),
            Step::Tried { acceptance, accepted, .. } => {
                let (y, _) = if accepted { chain.current() } else { chain.other() };
                invariance.record(weight, acceptance, &h_x, &h(y));
            }
        }
    }
    invariance
}
