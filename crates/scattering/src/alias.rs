//! Choice among many things in constant time: the alias method (Walker 1977), built in linear time (Vose 1991).

/// A table that chooses index i with probability `weights[i]` over their sum, whatever their number.
#[derive(Clone, Debug, Default)]
pub struct AliasTable {
    /// Share of each column that stays with its own index; exactly 0 for an index of weight 0.
    own: Vec<f64>,
    /// Who has the rest of the column.
    alias: Vec<u32>,
    total: f64,
}

impl AliasTable {
    /// From weights, finite and not negative; at most 2³² of them. With no positive weight nothing can be chosen, and the
    /// table [is empty](Self::is_empty).
    pub fn new(weights: &[f64]) -> Self {
        let total = accurate_sum(weights);
        if !(total > 0.0 && total.is_finite()) {
            return Self::default();
        }
        let mean = total / weights.len() as f64;
        let mut own: Vec<f64> = weights.iter().map(|weight| weight / mean).collect();
        let mut alias: Vec<u32> = (0..weights.len() as u32).collect();
        let (mut small, mut large): (Vec<u32>, Vec<u32>) = alias.iter().partition(|&&i| own[i as usize] < 1.0);
        while let (Some(&s), Some(&l)) = (small.last(), large.last()) {
            small.pop();
            alias[s as usize] = l;
            // Both together less one column: in this order rounding is least.
            own[l as usize] = (own[l as usize] + own[s as usize]) - 1.0;
            if own[l as usize] < 1.0 {
                large.pop();
                small.push(l);
            }
        }
        for l in large {
            own[l as usize] = 1.0;
        }
        if !small.is_empty() {
            // Only rounding leaves these without a partner. What is missing of their columns goes to the heaviest, so that
            // a weight of 0 stays one.
            let heaviest = (0..weights.len()).max_by(|&a, &b| weights[a].total_cmp(&weights[b])).unwrap_or(0);
            for s in small {
                alias[s as usize] = heaviest as u32;
            }
        }
        Self { own, alias, total }
    }

    /// Whether nothing can be chosen.
    pub fn is_empty(&self) -> bool {
        self.own.is_empty()
    }

    /// The sum of the weights; 0 if the table is empty.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// The index that `u`, uniform on [0, 1), chooses, and a number uniform on [0, 1) that is left of it. The table must
    /// not be empty.
    #[inline]
    pub fn choose(&self, u: f64) -> (usize, f64) {
        let x = u * self.own.len() as f64;
        // The product may round up to the number of columns.
        let column = (x as usize).min(self.own.len() - 1);
        let rest = x - column as f64;
        let own = self.own[column];
        let (index, left) =
            if rest < own { (column, rest / own) } else { (self.alias[column] as usize, (rest - own) / (1.0 - own)) };
        (index, left.min(1.0 - f64::EPSILON))
    }

    /// The probability of each index, worked out from the table itself in linear time.
    pub fn probabilities(&self) -> Vec<f64> {
        let columns = self.own.len() as f64;
        let mut sums = vec![0.0; self.own.len()];
        for (column, (own, alias)) in self.own.iter().zip(&self.alias).enumerate() {
            sums[column] += own / columns;
            sums[*alias as usize] += (1.0 - own) / columns;
        }
        sums
    }
}

/// A sum without the rounding of the partial sums (Neumaier 1974): all columns together must be as many as there are, because the
/// last one has what is missing.
fn accurate_sum(numbers: &[f64]) -> f64 {
    let (mut sum, mut rest) = (0.0f64, 0.0);
    for &number in numbers {
        let next = sum + number;
        rest += if sum.abs() >= number.abs() { (sum - next) + number } else { (number - next) + sum };
        sum = next;
    }
    if sum.is_finite() { sum + rest } else { sum }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights over many orders of magnitude, with zeros among them.
    fn weights(n: usize) -> Vec<f64> {
        (0..n).map(|i| if i % 7 == 3 { 0.0 } else { (-((i * 37 % 101) as f64) * 0.3).exp() }).collect()
    }

    #[test]
    fn the_table_gives_every_index_its_probability() {
        for n in [1, 2, 3, 10, 1000, 100_000] {
            let weights = weights(n);
            let table = AliasTable::new(&weights);
            let total: f64 = weights.iter().sum();
            assert!((table.total() / total - 1.0).abs() < 1e-12);
            for (i, (found, weight)) in table.probabilities().iter().zip(&weights).enumerate() {
                let wanted = weight / total;
                assert!((found - wanted).abs() <= 1e-10 * wanted + 1e-14 / n as f64, "{i} of {n}: {found} {wanted}");
                assert!(*weight > 0.0 || *found == 0.0, "{i} of {n} has weight 0");
            }
        }
    }

    #[test]
    fn choices_follow_the_table_and_what_is_left_is_uniform() {
        let weights = weights(50);
        let table = AliasTable::new(&weights);
        let total: f64 = weights.iter().sum();
        let n = 1_000_000;
        let mut counts = vec![(0u32, 0.0); weights.len()];
        for i in 0..n {
            let (index, left) = table.choose((f64::from(i) + 0.5) / f64::from(n));
            assert!((0.0..1.0).contains(&left));
            counts[index].0 += 1;
            counts[index].1 += left;
        }
        for ((count, sum), weight) in counts.iter().zip(&weights) {
            // Evenly spaced numbers miss by less than two of them in each column.
            assert!((f64::from(*count) - weight / total * f64::from(n)).abs() < 100.0);
            assert!(*count < 1000 || (sum / f64::from(*count) - 0.5).abs() < 0.02);
        }
    }

    #[test]
    fn without_a_positive_weight_nothing_can_be_chosen() {
        for weights in [&[][..], &[0.0, 0.0], &[f64::NAN], &[f64::INFINITY, 1.0]] {
            assert!(AliasTable::new(weights).is_empty());
        }
    }

    #[test]
    fn equal_weights_that_do_not_add_up_exactly_are_all_chosen() {
        let table = AliasTable::new(&[0.1; 3000]);
        assert!(table.probabilities().iter().all(|p| (p * 3000.0 - 1.0).abs() < 1e-11));
    }
}
