//! Where the numbers come from: one trait, so that the same builder serves independent sampling, replayed streams and
//! primary sample space.

/// A source of numbers uniform on `[0, 1)`.
pub trait RandomSource {
    /// The next number, in `[0, 1)`: never 1, in steps of 2⁻⁵³.
    fn uniform(&mut self) -> f64;

    /// Says what the numbers drawn next are for: place `index` of the walk `walk`.
    ///
    /// Sources that give one number after the other need not know. A point of primary sample space does: each of its coordinates
    /// keeps its meaning when another walk gets longer.
    #[inline]
    fn enter(&mut self, _walk: usize, _index: usize) {}

    /// An index uniform on `0..n`. `n` must not be 0.
    #[inline]
    fn below(&mut self, n: usize) -> usize {
        // The product can round up to n only for n beyond 2^52; min() makes the bound unconditional.
        ((self.uniform() * n as f64) as usize).min(n - 1)
    }
}

impl<R: rand_core::Rng> RandomSource for R {
    #[inline]
    fn uniform(&mut self) -> f64 {
        // The top 53 bits fill the mantissa exactly, so the largest value is 1 - 2^-53 and never rounds to 1.
        (self.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }
}

/// Replays given numbers, then repeats the last of them; `0.5` when there are none.
///
/// For tests, and for looking again at how one proposal was made.
#[derive(Clone, Debug)]
pub struct Replay {
    numbers: Vec<f64>,
    next: usize,
}

impl Replay {
    /// A source that gives `numbers` in order.
    pub fn new(numbers: Vec<f64>) -> Self {
        Self { numbers, next: 0 }
    }
}

impl RandomSource for Replay {
    fn uniform(&mut self) -> f64 {
        let last = self.numbers.len().saturating_sub(1);
        let value = self.numbers.get(self.next.min(last)).copied().unwrap_or(0.5);
        self.next += 1;
        value
    }
}
