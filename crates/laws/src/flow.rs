//! Under detailed balance as much flows from cell i to cell j as back.

use std::collections::BTreeMap;

/// Accumulates the flow w a between cells of state space, w = f(x)/p(x) the start's weight and a the acceptance
/// probability.
///
/// For each pair of cells, z = (F_ij - F_ji) / sqrt(sum of squares) has mean 0 and variance 1 if the kernel is reversible, so
/// that Q, the sum of z² over P pairs, is about chi-square with P degrees of freedom.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flow {
    /// By (smaller cell, larger cell): the flow upward less the flow downward, and the sum of squares.
    pairs: BTreeMap<(usize, usize), (f64, f64)>,
    faults: u64,
}

/// The outcome of the flow law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowVerdict {
    /// Sum of z² over the pairs; infinite if a flow was not a number.
    pub q: f64,
    /// Number of pairs with any flow.
    pub dof: usize,
    /// Q may not exceed P + 5 sqrt(2 P).
    pub limit: f64,
    /// Whether the law holds. It does not if nothing flowed.
    pub holds: bool,
    /// The pair of cells with the largest z, and its z: positive if too much flows from the first to the second.
    pub worst: Option<((usize, usize), f64)>,
}

impl Flow {
    /// Nothing has flowed yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes the flow `weight * acceptance` of one step from `cell_x` to `cell_y`.
    pub fn record(&mut self, flow: f64, cell_x: usize, cell_y: usize) {
        if !flow.is_finite() || flow < 0.0 {
            self.faults += 1;
            return;
        }
        if cell_x == cell_y || flow == 0.0 {
            return;
        }
        let (key, signed) = if cell_x < cell_y { ((cell_x, cell_y), flow) } else { ((cell_y, cell_x), -flow) };
        let (net, squares) = self.pairs.entry(key).or_default();
        *net += signed;
        *squares += flow * flow;
    }

    /// Takes all that `other` has seen.
    pub fn merge(&mut self, other: &Self) {
        for (key, (net, squares)) in &other.pairs {
            let mine = self.pairs.entry(*key).or_default();
            *mine = (mine.0 + net, mine.1 + squares);
        }
        self.faults += other.faults;
    }

    /// Whether the flow is symmetric.
    pub fn verdict(&self) -> FlowVerdict {
        let dof = self.pairs.len();
        let mut q = if self.faults > 0 { f64::INFINITY } else { 0.0 };
        let mut worst: Option<((usize, usize), f64)> = None;
        for (&key, (net, squares)) in &self.pairs {
            let z = net / squares.sqrt();
            q += z * z;
            if worst.is_none_or(|(_, other)| z.abs() > other.abs()) {
                worst = Some((key, z));
            }
        }
        let limit = dof as f64 + 5.0 * (2.0 * dof as f64).sqrt();
        FlowVerdict { q, dof, limit, holds: dof > 0 && q <= limit, worst }
    }
}
