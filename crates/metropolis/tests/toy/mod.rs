//! A toy path space with everything that makes light paths hard: states of different dimension, a choice among kernels that
//! depends on the state, candidates that can arise in several ways, proposals that fail, and a kernel with a Jacobian.
//!
//! A state is 1 to [`LONGEST`] numbers in [0, 1). The target is f(x) = 0.7^n Π (1 + x_i), whose integral over paths of n numbers is
//! 1.05^n and which can be sampled exactly.

use std::sync::LazyLock;

use ergodic_metropolis::{Density, Mixture, Mutation, RandomSource, Target};

pub type Path = Vec<f64>;

pub const LONGEST: usize = 4;

/// How many numbers survive at each end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Splice {
    pub prefix: usize,
    pub suffix: usize,
}

/// The candidate would leave the unit interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outside;

#[derive(Clone, Copy, Debug)]
pub struct Toy;

impl Target for Toy {
    type State = Path;
    type Value = f64;

    fn evaluate(&self, x: &Path) -> f64 {
        let mut product = Density::ONE;
        x.iter().for_each(|v| product.multiply(0.7 * (1.0 + v)));
        product.ln()
    }

    fn ln_density(value: &f64) -> f64 {
        *value
    }
}

/// An independent sample of the toy target.
pub fn exact(rng: &mut impl RandomSource) -> Path {
    let integrals: [f64; LONGEST] = std::array::from_fn(|i| 1.05f64.powi(i as i32 + 1));
    let mut u = rng.uniform() * integrals.iter().sum::<f64>();
    let mut length = LONGEST;
    for (i, integral) in integrals.iter().enumerate() {
        if u < *integral {
            length = i + 1;
            break;
        }
        u -= integral;
    }
    (0..length).map(|_| (1.0 + 3.0 * rng.uniform()).sqrt() - 1.0).collect()
}

/// The kernels of the toy, as one type.
#[derive(Clone, Debug)]
pub enum Kernel {
    /// Cut out a range and walk new numbers in from both ends.
    Resample,
    /// Move one number by a distance between the two radii, density 1/r.
    Perturb { least: f64, most: f64 },
}

pub fn kernels() -> Mixture<Kernel> {
    Mixture::new(vec![(1.0, Kernel::Resample), (0.7, Kernel::Perturb { least: 0.01, most: 0.3 })])
        .expect("the weights are positive")
}

type Choice = (usize, usize, usize);

static CHOICES: LazyLock<[Vec<Choice>; LONGEST + 1]> = LazyLock::new(|| {
    std::array::from_fn(|n| {
        let mut choices = vec![];
        for cut in 0..=n {
            for prefix in 0..=n - cut {
                for put in 0..=LONGEST {
                    if (1..=LONGEST).contains(&(n - cut + put)) && (cut, put) != (0, 0) {
                        choices.push((prefix, cut, put));
                    }
                }
            }
        }
        choices
    })
});

/// What [`Kernel::Resample`] may do to a path of `n`: (prefix, numbers cut out, numbers put in), all equally likely.
pub fn choices(n: usize) -> &'static [Choice] {
    &CHOICES[n]
}

/// Number b beside number a: density 1 + a (2 b - 1).
fn walk_pdf(a: f64, b: f64) -> f64 {
    1.0 + a * (2.0 * b - 1.0)
}

fn walk(a: f64, u: f64) -> f64 {
    if a < 1e-9 { u } else { ((a - 1.0) + ((1.0 - a).powi(2) + 4.0 * a * u).sqrt()) / (2.0 * a) }
}

fn walk_along(start: f64, numbers: impl Iterator<Item = f64>) -> f64 {
    let mut before = start;
    let mut density = 1.0;
    for number in numbers {
        density *= walk_pdf(before, number);
        before = number;
    }
    density
}

impl Mutation for Kernel {
    type Space = ();
    type State = Path;
    type Plan = Splice;
    type Failure = Outside;

    fn suitability(&self, (): &(), x: &Path) -> f64 {
        match self {
            Self::Resample => 1.0,
            Self::Perturb { .. } => {
                if x.len() >= 2 {
                    3.0
                } else {
                    0.0
                }
            }
        }
    }

    fn propose(&self, (): &(), x: &Path, y: &mut Path, rng: &mut impl RandomSource) -> Result<Splice, Outside> {
        match *self {
            Self::Resample => {
                let choices = choices(x.len());
                let (prefix, cut, put) = choices[rng.below(choices.len())];
                let from_left = rng.below(put + 1);
                y.clear();
                y.extend_from_slice(&x[..prefix]);
                let mut before = y.last().copied().unwrap_or(0.0);
                for _ in 0..from_left {
                    before = walk(before, rng.uniform());
                    y.push(before);
                }
                let kept = &x[prefix + cut..];
                let mut before = kept.first().copied().unwrap_or(0.0);
                let right: Vec<f64> = (from_left..put)
                    .map(|_| {
                        before = walk(before, rng.uniform());
                        before
                    })
                    .collect();
                y.extend(right.iter().rev());
                y.extend_from_slice(kept);
                Ok(Splice { prefix, suffix: kept.len() })
            }
            Self::Perturb { least, most } => {
                let i = rng.below(x.len());
                let r = most * (-(most / least).ln() * rng.uniform()).exp();
                let moved = x[i] + if rng.uniform() < 0.5 { r } else { -r };
                if !(0.0..1.0).contains(&moved) {
                    return Err(Outside);
                }
                y.clone_from(x);
                y[i] = moved;
                Ok(Splice { prefix: i, suffix: x.len() - i - 1 })
            }
        }
    }

    fn ln_density(&self, (): &(), from: &Path, to: &Path, plan: Splice) -> f64 {
        match *self {
            Self::Resample => {
                let new = &to[plan.prefix..to.len() - plan.suffix];
                let left = if plan.prefix > 0 { to[plan.prefix - 1] } else { 0.0 };
                let right = if plan.suffix > 0 { to[to.len() - plan.suffix] } else { 0.0 };
                // Each split of the insertion between the two walks could have made the same path.
                let sum: f64 = (0..=new.len())
                    .map(|split| {
                        walk_along(left, new[..split].iter().copied())
                            * walk_along(right, new[split..].iter().rev().copied())
                    })
                    .sum();
                (sum / (new.len() + 1) as f64 / choices(from.len()).len() as f64).ln()
            }
            Self::Perturb { least, most } => {
                let r = (to[plan.prefix] - from[plan.prefix]).abs();
                // The radius comes back from a difference: the rounding of that must not put it out of range.
                if r < least * (1.0 - 1e-9) || r > most * (1.0 + 1e-9) {
                    return f64::NEG_INFINITY;
                }
                -(2.0 * r * (most / least).ln() * from.len() as f64).ln()
            }
        }
    }
}
