//! Whether independent replicas of an estimate agree with a reference, by statistics.
//!
//! A test that takes the samples of one image for independent rejects correct Markov chains, so the error of every block
//! comes from the spread over whole replicas, each with its own seed and its own b. Two gates look at the blocks: the
//! largest |t| (one block that is wrong) and how many exceed the 1 % point (many that are a little wrong).

use ergodic_laws::{Moments, sidak, student_two_sided};
use rand_core::Rng;
use rand_pcg::Pcg64Dxsm;

use crate::image::Image;
use crate::reference::{BLOCK, Reference, block_grid, block_means};

/// Most replicas; each has a bit of a 64-bit number.
const MOST: usize = 64;

/// How often signs are drawn for the distribution of exceedances.
const SIGN_FLIPS: u32 = 1 << 16;

/// The level whose exceedances are counted.
const COUNTED: f64 = 0.01;

/// A block whose spread comes from one replica by more than this share has seen rare bright samples: of 32 normal numbers, one
/// has so much about once in 10 000.
const DOMINATED: f64 = 0.5;

/// If more than this share of the blocks is dominated, rare bright samples make up the picture, and where none has been seen
/// yet, t is far below what Student allows. The blocks then decide nothing.
const RESOLVED: f64 = 0.02;

/// Blocks darker than this share of the mean block are left to their brighter neighbours: too few samples fall there for t to
/// be Student's.
const DARK: f64 = 0.02;

/// One block of an image against the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockTest {
    /// Column and row of its first pixel.
    pub at: (u32, u32),
    /// Difference over the reference's value.
    pub relative_difference: f64,
    /// Difference in standard errors, those of both sides together, with the skewness of the replicas taken out.
    pub t: f64,
    /// Probability of such a |t| by chance.
    pub p: f64,
    /// Share of the spread that comes from one replica, from 1 / n to 1.
    pub dominance: f64,
}

/// Replicas against a reference.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplicaTest {
    /// All blocks that are bright enough.
    pub blocks: Vec<BlockTest>,
    /// Probability that the largest |t| of all blocks is so large by chance (Sidak).
    pub p_largest: f64,
    /// How many blocks lie beyond the 1 % point, and the probability of so many by chance.
    pub exceedances: (usize, f64),
    /// The mean of the whole image, which for Metropolis light transport is b and proves nothing about the chains: relative
    /// difference, t and its probability.
    pub total: (f64, f64, f64),
}

/// What a test came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The replicas agree with the reference.
    Holds,
    /// The estimator finds a part of the light so rarely that blocks too dark mean nothing; the total agrees, and no block is too
    /// bright.
    Unresolved,
    /// They do not agree.
    Fails,
}

/// Student's t of the values against the reference, and its probability.
///
/// Means over few replicas of rare bright samples are skewed, and Student's t of skewed values lies far below 0 much too often:
/// where nothing bright was seen yet, the spread is small too. Hall's cubic transformation (Hall 1992) takes the skewness out
/// and keeps the order of values: t + a t² + a² t³ / 3 + γ / (6 √n), a = γ / (3 √n), γ the sample's skewness.
fn t_test(values: &[f64], reference: f64, reference_variance: f64) -> (f64, f64) {
    let sample: Moments = values.iter().copied().collect();
    let n = sample.count() as f64;
    let own = sample.variance() / n;
    let error = (own + reference_variance).sqrt();
    let difference = sample.mean() - reference;
    if difference == 0.0 {
        return (0.0, 1.0);
    }
    let cubes: f64 = values.iter().map(|v| (v - sample.mean()).powi(3)).sum();
    let third = if n > 2.0 { cubes * n / ((n - 1.0) * (n - 2.0)) } else { 0.0 };
    // Of the difference: the reference, with its many samples, adds variance but no skewness.
    let skewness = third / (error * n.sqrt()).powi(3);
    let t = without_skewness(difference / error, skewness, n);
    // Welch and Satterthwaite; the reference has so many samples that its variance counts as known.
    let dof = (n - 1.0) * ((own + reference_variance) / own).powi(2);
    (t, student_two_sided(t, if dof.is_finite() { dof } else { f64::MAX.sqrt() }))
}

fn without_skewness(t: f64, skewness: f64, n: f64) -> f64 {
    let a = skewness / (3.0 * n.sqrt());
    t + a * t * t + a * a * t * t * t / 3.0 + 0.5 * a
}

/// Tests replicas against a reference of the same size.
///
/// # Errors
///
/// A sentence, for fewer than two replicas or sizes that differ.
pub fn test_replicas(replicas: &[Image], reference: &Reference) -> Result<ReplicaTest, String> {
    let (width, height) = (reference.mean.width, reference.mean.height);
    if replicas.len() < 2 || replicas.len() > MOST {
        return Err(format!("there are {} replicas; give from 2 to {MOST}", replicas.len()));
    }
    if let Some(other) = replicas.iter().find(|r| (r.width, r.height) != (width, height)) {
        return Err(format!(
            "a replica has {} x {} pixels, but the reference {width} x {height}",
            other.width, other.height
        ));
    }
    let (expected, expected_total) = block_means(&reference.mean);
    let own: Vec<(Vec<f64>, f64)> = replicas.iter().map(block_means).collect();
    let columns = block_grid(width, height).0;
    let mean_block = expected.iter().sum::<f64>() / expected.len() as f64;
    let mut blocks = Vec::new();
    let mut residuals = Vec::new();
    for (i, (expected, variance)) in expected.iter().zip(&reference.block_variance).enumerate() {
        if *expected < DARK * mean_block {
            continue;
        }
        let values: Vec<f64> = own.iter().map(|(means, _)| means[i]).collect();
        let sample: Moments = values.iter().copied().collect();
        let (t, p) = t_test(&values, *expected, *variance);
        let at = ((i % columns) as u32 * BLOCK, (i / columns) as u32 * BLOCK);
        let deviations: Vec<f64> = values.iter().map(|v| v - sample.mean()).collect();
        let squares = deviations.iter().map(|d| d * d);
        let dominance = squares.clone().fold(0.0, f64::max) / squares.sum::<f64>().max(f64::MIN_POSITIVE);
        blocks.push(BlockTest { at, relative_difference: sample.mean() / expected - 1.0, t, p, dominance });
        residuals.push(deviations);
    }
    let smallest = blocks.iter().map(|b| b.p).fold(1.0, f64::min);
    let beyond = blocks.iter().filter(|b| b.p < COUNTED).count();
    let totals: Vec<f64> = own.iter().map(|(_, total)| *total).collect();
    let total: Moments = totals.iter().copied().collect();
    let (t, p) = t_test(&totals, expected_total, reference.total_variance);
    Ok(ReplicaTest {
        p_largest: any_of(blocks.len(), smallest),
        exceedances: (beyond, exceedance_probability(&residuals, beyond)),
        total: (total.mean() / expected_total - 1.0, t, p),
        blocks,
    })
}

/// Probability that so many blocks exceed the 1 % point by chance.
///
/// Blocks of one replica are correlated: all of them scale with its b. So the count is not binomial; its distribution comes
/// from the replicas themselves, with the sign of each one's deviations drawn anew many times.
fn exceedance_probability(residuals: &[Vec<f64>], beyond: usize) -> f64 {
    let Some(n) = residuals.first().map(Vec::len).filter(|_| beyond > 0) else { return 1.0 };
    let count = n as f64;
    let squares: Vec<f64> = residuals.iter().map(|r| r.iter().map(|v| v * v).sum()).collect();
    let limit = student_limit(COUNTED, count - 1.0);
    let mut rng = Pcg64Dxsm::new(0x7265_706c_6963_6173, 1);
    let mut as_many = 1u32;
    for _ in 0..SIGN_FLIPS {
        let signs = rng.next_u64();
        let exceeds = |(residuals, squares): (&Vec<f64>, &f64)| {
            let sum: f64 = residuals.iter().enumerate().map(|(i, v)| if signs >> i & 1 == 0 { *v } else { -*v }).sum();
            let variance = (squares - sum * sum / count) / (count - 1.0);
            sum * sum > limit * limit * variance * count
        };
        as_many += u32::from(residuals.iter().zip(&squares).filter(|pair| exceeds(*pair)).count() >= beyond);
    }
    f64::from(as_many) / f64::from(SIGN_FLIPS + 1)
}

/// Probability that the smallest of `count` independent probabilities is so small (Sidak).
fn any_of(count: usize, smallest: f64) -> f64 {
    -f64::exp_m1(count as f64 * f64::ln_1p(-smallest.min(1.0 - f64::EPSILON)))
}

/// The |t| that is exceeded with probability `p`, by bisection.
fn student_limit(p: f64, dof: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1e6);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if student_two_sided(middle, dof) > p { low = middle } else { high = middle }
    }
    high
}

impl ReplicaTest {
    /// The smallest of the three probabilities.
    pub fn p(&self) -> f64 {
        self.p_largest.min(self.exceedances.1).min(self.total.2)
    }

    /// Whether the replicas agree with the reference, at the level `alpha` for all three gates together.
    pub fn verdict(&self, alpha: f64) -> Verdict {
        let level = sidak(alpha, 3);
        if self.p() >= level {
            Verdict::Holds
        } else if self.dominated() > RESOLVED && self.total.2.min(self.p_too_bright()) >= level {
            Verdict::Unresolved
        } else {
            Verdict::Fails
        }
    }

    /// Probability of the brightest block by chance (Sidak). Rare light that was not seen yet makes blocks too dark only, so this
    /// decides where the other gates do not.
    fn p_too_bright(&self) -> f64 {
        any_of(self.blocks.len(), self.blocks.iter().filter(|b| b.t > 0.0).map(|b| b.p).fold(1.0, f64::min))
    }

    /// The share of the blocks whose spread comes from one replica.
    pub fn dominated(&self) -> f64 {
        let dominated = self.blocks.iter().filter(|b| b.dominance > DOMINATED).count();
        dominated as f64 / self.blocks.len().max(1) as f64
    }

    /// The block with the largest |t|.
    pub fn worst(&self) -> Option<&BlockTest> {
        self.blocks.iter().max_by(|a, b| a.t.abs().total_cmp(&b.t.abs()))
    }

    /// The blocks as a picture: t of each in grey, red where the replicas are too bright, blue where too dark; full colour
    /// at five standard errors.
    pub fn picture(&self, width: u32, height: u32) -> Image {
        let mut image = Image { width, height, pixels: vec![[0.0; 3]; (width * height) as usize] };
        for block in &self.blocks {
            let strength = (block.t.abs() / 5.0).min(1.0);
            let grey = 0.18 * (1.0 - strength);
            let color = if block.t > 0.0 { [grey + strength, grey, grey] } else { [grey, grey, grey + strength] };
            for y in block.at.1..(block.at.1 + BLOCK).min(height) {
                for x in block.at.0..(block.at.0 + BLOCK).min(width) {
                    image.pixels[(y * width + x) as usize] = color;
                }
            }
        }
        image
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shares of samples of 32 sums of a few exponential numbers whose t is beyond the 1 % and the 0.1 % point, over those
    /// shares; with and without the transformation.
    #[test]
    fn skewed_values_exceed_as_often_as_they_should() {
        let mut rng = Pcg64Dxsm::new(1, 1);
        let mut uniform = || (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        let (rounds, n, shape) = (40_000, 32, 2);
        let mut beyond = [[0.0; 2]; 2];
        for _ in 0..rounds {
            let values: Vec<f64> = (0..n).map(|_| -(0..shape).map(|_| (1.0 - uniform()).ln()).sum::<f64>()).collect();
            let sample: Moments = values.iter().copied().collect();
            let plain = (sample.mean() - f64::from(shape)) / (sample.variance() / f64::from(n)).sqrt();
            let (t, p) = t_test(&values, f64::from(shape), 0.0);
            assert!((student_two_sided(t, f64::from(n - 1)) - p).abs() < 1e-9);
            for (i, t) in [t, plain].into_iter().enumerate() {
                for (j, level) in [0.01, 0.001].into_iter().enumerate() {
                    let exceeds = student_two_sided(t, f64::from(n - 1)) < level;
                    beyond[i][j] += f64::from(u8::from(exceeds)) / (level * f64::from(rounds));
                }
            }
        }
        println!("{beyond:?}");
        assert!(beyond[0].iter().all(|share| *share < 2.0), "{beyond:?}");
        // Without it the test would give false alarms.
        assert!(beyond[1][1] > 3.0, "{beyond:?}");
    }

    #[test]
    fn the_limit_of_student_is_that_of_tables() {
        assert!((student_limit(0.01, 10.0) - 3.169_273).abs() < 1e-5);
        assert!((student_limit(0.01, 31.0) - 2.744_042).abs() < 1e-5);
    }
}
