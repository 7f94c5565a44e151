//! The standard error of a chain's average while it runs, in constant memory.

use super::Moments;

/// Means of consecutive batches. The batches grow with the chain: when there are too many, neighbours are joined.
///
/// For batches much longer than the autocorrelation time their means are nearly independent, so that their spread gives
/// the standard error of the whole mean and, against the spread of single terms, the autocorrelation time.
///
/// ```
/// use ergodic_metropolis::RandomSource;
/// use ergodic_metropolis::diagnostics::BatchMeans;
///
/// // Every random number ten times over.
/// let mut rng = rand_pcg::Pcg64::new(1, 1);
/// let mut blocks = BatchMeans::new(64);
/// for _ in 0..2000 {
///     let value = rng.uniform();
///     (0..10).for_each(|_| blocks.add(value));
/// }
/// let time = blocks.autocorrelation_time().unwrap();
/// assert!((6.0..15.0).contains(&time), "{time}");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BatchMeans {
    /// Of all closed batches.
    terms: Moments,
    means: Vec<f64>,
    most: usize,
    length: u64,
    open: Open,
}

/// The batch under way: sums of powers of what its terms differ from a pivot, so that a term costs no division.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Open {
    count: u64,
    /// The mean so far where the batch began, which keeps the sums small.
    pivot: f64,
    sum: f64,
    squares: f64,
}

impl Open {
    #[inline]
    fn add(&mut self, value: f64, count: u64) {
        let difference = value - self.pivot;
        let sum = difference * count as f64;
        self.count += count;
        self.sum += sum;
        self.squares += difference * sum;
    }

    fn moments(&self) -> Moments {
        if self.count == 0 {
            return Moments::new();
        }
        let mean = self.sum / self.count as f64;
        Moments::of(self.count, self.pivot + mean, (self.squares - mean * self.sum).max(0.0))
    }
}

impl BatchMeans {
    /// Keeps between `batches` and `2 batches` batches once the chain is long enough (at least 8 are kept).
    ///
    /// The relative error of the autocorrelation time is about `sqrt(2 / batches)`, and a chain must be several times
    /// `batches` autocorrelation times long for the bias to be smaller than that.
    pub fn new(batches: usize) -> Self {
        let most = 2 * batches.max(8);
        Self { terms: Moments::new(), means: Vec::with_capacity(most), most, length: 1, open: Open::default() }
    }

    /// Takes the next term of the chain.
    #[inline]
    pub fn add(&mut self, value: f64) {
        self.add_run(value, 1);
    }

    /// Takes `count` terms of the same value: what [`Self::add`] would do so often.
    #[inline]
    pub fn add_run(&mut self, value: f64, mut count: u64) {
        while count > 0 {
            let part = count.min(self.length - self.open.count);
            self.open.add(value, part);
            count -= part;
            if self.open.count == self.length {
                self.close();
            }
        }
    }

    fn close(&mut self) {
        let batch = self.open.moments();
        self.terms.merge(&batch);
        self.means.push(batch.mean());
        self.open = Open { pivot: self.terms.mean(), ..Open::default() };
        if self.means.len() == self.most {
            for i in 0..self.most / 2 {
                self.means[i] = 0.5 * (self.means[2 * i] + self.means[2 * i + 1]);
            }
            self.means.truncate(self.most / 2);
            self.length *= 2;
        }
    }

    /// Count, mean and variance of the single terms. Their standard error is that of *independent* terms.
    pub fn terms(&self) -> Moments {
        let mut terms = self.terms;
        terms.merge(&self.open.moments());
        terms
    }

    /// The number of terms in a batch now.
    pub fn batch_length(&self) -> u64 {
        self.length
    }

    /// Integrated autocorrelation time τ in steps: batch length times the variance of the batch means over the variance of
    /// the terms. `None` before there are 8 batches of more than one term, and for a series that never changed.
    pub fn autocorrelation_time(&self) -> Option<f64> {
        if self.means.len() < 8 || self.length < 2 {
            return None;
        }
        let means: Moments = self.means.iter().copied().collect();
        let time = self.length as f64 * means.variance() / self.terms().variance();
        (time.is_finite() && time > 0.0).then_some(time)
    }

    /// The number of independent terms that would know the mean as well.
    pub fn effective_sample_size(&self) -> Option<f64> {
        self.autocorrelation_time().map(|time| self.terms().count() as f64 / time)
    }

    /// The standard error of the mean, with the autocorrelation taken into account.
    pub fn standard_error(&self) -> Option<f64> {
        self.effective_sample_size().map(|size| (self.terms().variance() / size).sqrt())
    }
}
