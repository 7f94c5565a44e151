//! The volume law: averaged over a kernel's proposals, 1/T is the volume of what the kernel can reach.
//!
//! With T(x → y, plan) the density that proposals have, E[g(y) / T; plan] = ∫ g(y) dy over the states that the plan reaches
//! from x. A lost Jacobian, a forgotten choice or a missing way of making the same candidate shows as a wrong volume, with no
//! histogram over the many dimensions of y.

use std::collections::BTreeMap;

use ergodic_metropolis::{Mutation, RandomSource};

use crate::Moments;

/// One bin of the volume law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeBin {
    /// What the caller says the volume is; 0 for bins it did not list.
    pub expected: f64,
    /// g/T over *all* proposals, 0 for those that miss the bin or fail.
    pub moments: Moments,
    /// Distance from the expectation in standard errors.
    pub z: f64,
}

/// The outcome of the volume law.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume<B> {
    /// All bins that were listed or hit.
    pub bins: BTreeMap<B, VolumeBin>,
    /// Proposals whose density was zero or not a number. Must be 0.
    pub faults: u64,
}

impl<B> Volume<B> {
    /// The largest |z| over all bins; infinite after a fault.
    pub fn max_z(&self) -> f64 {
        let worst = self.bins.values().map(|bin| bin.z.abs()).fold(0.0, f64::max);
        if self.faults > 0 { f64::INFINITY } else { worst }
    }

    /// No fault, and no bin further away than `alpha` allows for all bins together (Sidak).
    pub fn holds(&self, alpha: f64) -> bool {
        !self.bins.is_empty() && self.max_z() <= crate::normal_limit(crate::sidak(alpha, self.bins.len()))
    }
}

/// Averages g(y) / T(x → y, plan) over `n` proposals from one state `x`, bin by bin.
///
/// `observe` gives the bin of a candidate and g there, or nothing to leave it out; g = 1 makes the expectation the plain
/// volume. Where 1/T has no finite variance choose a g that tames it, or the errors mean nothing. `expected` lists
/// the volume of every bin; a bin that is hit without being listed fails, as does one that is listed and never hit.
pub fn volume<M, R, B>(
    mutation: &M,
    space: &M::Space,
    x: &M::State,
    expected: &BTreeMap<B, f64>,
    mut observe: impl FnMut(&M::State, M::Plan) -> Option<(B, f64)>,
    n: u64,
    rng: &mut R,
) -> Volume<B>
where
    M: Mutation,
    M::State: Clone,
    R: RandomSource,
    B: Ord + Clone,
{
    let mut sums: BTreeMap<B, Moments> = expected.keys().map(|bin| (bin.clone(), Moments::new())).collect();
    let mut faults = 0;
    let mut y = x.clone();
    for _ in 0..n {
        let Ok(plan) = mutation.propose(space, x, &mut y, rng) else { continue };
        let Some((bin, g)) = observe(&y, plan) else { continue };
        let weight = g * (-mutation.ln_density(space, x, &y, plan)).exp();
        if weight.is_finite() {
            sums.entry(bin).or_default().add(weight);
        } else {
            faults += 1;
        }
    }
    let bins = sums
        .into_iter()
        .map(|(bin, mut moments)| {
            moments.add_zeros(n - moments.count());
            let volume = expected.get(&bin).copied().unwrap_or(0.0);
            let z = crate::z_score(moments.mean(), volume, moments.standard_error());
            (bin, VolumeBin { expected: volume, moments, z })
        })
        .collect();
    Volume { bins, faults }
}
