//! Which states lead where: irreducibility and period.

use super::{FiniteError, TransitionMatrix};

impl TransitionMatrix {
    /// Whether every state can be reached from every other.
    pub fn is_irreducible(&self) -> bool {
        self.check_irreducible().is_ok()
    }

    /// Whether the chain is irreducible and its returns have no common period, so that it converges from every start.
    pub fn is_ergodic(&self) -> bool {
        self.period() == Ok(1)
    }

    /// The greatest common divisor of the lengths of all ways back to a state; 1 means aperiodic.
    ///
    /// # Errors
    ///
    /// [`FiniteError::Reducible`]: only an irreducible chain has one period for all states.
    pub fn period(&self) -> Result<usize, FiniteError> {
        self.check_irreducible()?;
        // With breadth-first levels d from state 0, every edge i -> j closes ways whose lengths differ by d_i + 1 - d_j.
        let level = self.levels(|i, j| self.row(i)[j] > 0.0);
        let mut period = 0;
        for i in 0..self.states() {
            for j in 0..self.states() {
                if self.row(i)[j] > 0.0
                    && let (Some(from), Some(to)) = (level[i], level[j])
                {
                    period = gcd(period, (from + 1).abs_diff(to));
                }
            }
        }
        Ok(period)
    }

    pub(super) fn check_irreducible(&self) -> Result<(), FiniteError> {
        let unreached = |levels: Vec<Option<usize>>| levels.iter().position(Option::is_none);
        if let Some(to) = unreached(self.levels(|i, j| self.row(i)[j] > 0.0)) {
            return Err(FiniteError::Reducible { from: 0, to });
        }
        if let Some(from) = unreached(self.levels(|i, j| self.row(j)[i] > 0.0)) {
            return Err(FiniteError::Reducible { from, to: 0 });
        }
        Ok(())
    }

    /// The number of edges on the shortest way from state 0 to each state, if there is one.
    fn levels(&self, edge: impl Fn(usize, usize) -> bool) -> Vec<Option<usize>> {
        let mut level = vec![None; self.states()];
        level[0] = Some(0);
        let mut front = vec![0];
        let mut depth = 0;
        while !front.is_empty() {
            depth += 1;
            let mut next = Vec::new();
            for &i in &front {
                for (j, seen) in level.iter_mut().enumerate() {
                    if seen.is_none() && edge(i, j) {
                        *seen = Some(depth);
                        next.push(j);
                    }
                }
            }
            front = next;
        }
        level
    }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}
