//! Random streams keyed by seed, purpose and index, so that no result depends on which thread did the work.

use rand_pcg::Pcg64Dxsm;

/// What a stream is for. Streams of different purposes never coincide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Samples of the path tracer.
    PathTracer = 1,
    /// Samples of bidirectional path tracing.
    Bidirectional = 2,
    /// The direct light of a chain's picture.
    Direct = 3,
    /// Seeds of chains and the estimate of b.
    Seeding = 4,
    /// The choice of starts among the seeds.
    Starts = 5,
    /// The chains themselves.
    Chain = 6,
    /// The shares of the lengths in multiplexed sampling.
    Pilot = 7,
    /// The seeds that are kept where there are too many.
    Thinning = 8,
    /// The first stage, which sees how bright each part of the image is.
    FirstStage = 9,
    /// Steps that only tell how long a step takes.
    Trial = 10,
}

/// One round of the mixing function of splitmix64 (Steele, Lea, Flood 2014).
fn mix(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// The stream of a (seed, purpose, index). State and increment are both hashed: neighbouring indices share nothing.
pub fn stream(seed: u64, purpose: Purpose, index: u64) -> Pcg64Dxsm {
    let word = |lane: u64| mix(mix(mix(seed ^ lane.rotate_left(48)) ^ purpose as u64) ^ index);
    let wide = |lane: u64| u128::from(word(lane)) << 64 | u128::from(word(lane + 1));
    Pcg64Dxsm::new(wide(1), wide(3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ergodic_metropolis::RandomSource;

    #[test]
    fn neighbouring_streams_are_uncorrelated() {
        let n = 4096;
        let streams: Vec<Vec<f64>> = (0..128)
            .map(|index| {
                let mut rng = stream(7, Purpose::Chain, index);
                (0..n).map(|_| rng.uniform() - 0.5).collect()
            })
            .collect();
        let correlation = |a: &[f64], b: &[f64]| 12.0 * a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>() / n as f64;
        let mut largest: f64 = 0.0;
        for i in 0..streams.len() {
            for j in 0..i {
                largest = largest.max(correlation(&streams[i], &streams[j]).abs());
            }
        }
        // 8128 pairs, each of standard deviation 1 / sqrt(n).
        assert!(largest < 5.5 / f64::from(n).sqrt(), "{largest}");
        // The same stream twice would be seen.
        assert!(correlation(&streams[3], &streams[3]) > 0.9);
    }
}
