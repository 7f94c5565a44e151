//! The stationary distribution, without subtractions.

use super::{FiniteError, TransitionMatrix};

impl TransitionMatrix {
    /// The one distribution that a step leaves as it is.
    ///
    /// State reduction by Grassmann, Taksar and Heyman (1985): the last state is cut out and the ways through it are added
    /// to the ways around it, again and again. No subtraction occurs, so that every entry is right to almost full relative
    /// accuracy, tiny ones too.
    ///
    /// # Errors
    ///
    /// [`FiniteError::Reducible`]: there is more than one, or some states have none of it.
    pub fn stationary_distribution(&self) -> Result<Vec<f64>, FiniteError> {
        self.check_irreducible()?;
        let n = self.states();
        let mut a: Vec<Vec<f64>> = (0..n).map(|i| self.row(i).to_vec()).collect();
        for k in (1..n).rev() {
            let (before, from_k) = a.split_at_mut(k);
            let out = &from_k[0][..k];
            // The probability of leaving k for a smaller state is summed, not taken as 1 less that of staying.
            let leaving: f64 = out.iter().sum();
            for row in before {
                row[k] /= leaving;
                let through = row[k];
                row.iter_mut().zip(out).for_each(|(entry, onward)| *entry += through * onward);
            }
        }
        let mut distribution = vec![1.0];
        for k in 1..n {
            distribution.push(distribution.iter().zip(&a).map(|(p, row)| p * row[k]).sum());
        }
        let total: f64 = distribution.iter().sum();
        distribution.iter_mut().for_each(|p| *p /= total);
        Ok(distribution)
    }
}
