//! Mean, variance and standard error of a stream of numbers.

/// Streaming mean and variance (Welford 1962), mergeable (Chan, Golub and LeVeque 1979).
///
/// ```
/// let moments: ergodic_metropolis::diagnostics::Moments = [1.0, 2.0, 3.0, 4.0].into_iter().collect();
/// assert_eq!((moments.mean(), moments.count()), (2.5, 4));
/// assert!((moments.variance() - 5.0 / 3.0).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    count: u64,
    mean: f64,
    squares: f64,
}

impl Moments {
    /// Nothing seen yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// From what is known of `count` numbers: their mean and the sum of squared differences from it.
    pub(crate) fn of(count: u64, mean: f64, squares: f64) -> Self {
        Self { count, mean, squares }
    }

    /// Takes one number.
    #[inline]
    pub fn add(&mut self, value: f64) {
        self.count += 1;
        let before = value - self.mean;
        self.mean += before / self.count as f64;
        self.squares += before * (value - self.mean);
    }

    /// Takes `count` zeros: what a sum over rare events sees the rest of the time.
    pub fn add_zeros(&mut self, count: u64) {
        self.add_run(0.0, count);
    }

    /// Takes `count` times the same value.
    #[inline]
    pub fn add_run(&mut self, value: f64, count: u64) {
        self.merge(&Self { count, mean: value, squares: 0.0 });
    }

    /// Takes all that `other` has seen.
    pub fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        let (a, b) = (self.count as f64, other.count as f64);
        let difference = other.mean - self.mean;
        self.mean += difference * b / (a + b);
        self.squares += other.squares + difference * difference * a * b / (a + b);
        self.count += other.count;
    }

    /// How many numbers.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Their mean; 0 if there are none.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// The unbiased estimate of the variance; infinite for fewer than two numbers, about which it is not known.
    pub fn variance(&self) -> f64 {
        if self.count < 2 { f64::INFINITY } else { self.squares / (self.count - 1) as f64 }
    }

    /// The standard error of the mean, for *independent* numbers.
    pub fn standard_error(&self) -> f64 {
        (self.variance() / self.count as f64).sqrt()
    }
}

impl FromIterator<f64> for Moments {
    fn from_iter<I: IntoIterator<Item = f64>>(numbers: I) -> Self {
        let mut moments = Self::new();
        numbers.into_iter().for_each(|value| moments.add(value));
        moments
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_merge_to_the_whole() {
        let numbers: Vec<f64> = (0..100).map(|i| f64::from(i * i % 17) + 1e6).collect();
        let whole: Moments = numbers.iter().copied().collect();
        let mut parts = Moments::new();
        for part in numbers.chunks(13) {
            parts.merge(&part.iter().copied().collect());
        }
        assert_eq!(parts.count(), whole.count());
        assert!((parts.mean() - whole.mean()).abs() < 1e-9);
        assert!((parts.variance() / whole.variance() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn zeros_count() {
        let mut moments: Moments = [4.0].into_iter().collect();
        moments.add_zeros(3);
        let direct: Moments = [4.0, 0.0, 0.0, 0.0].into_iter().collect();
        assert!((moments.mean() - direct.mean()).abs() < 1e-15);
        assert!((moments.variance() - direct.variance()).abs() < 1e-14);
    }

    #[test]
    fn one_number_says_nothing_about_the_spread() {
        let one: Moments = [3.0].into_iter().collect();
        assert_eq!(one.standard_error(), f64::INFINITY);
    }
}
