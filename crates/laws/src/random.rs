//! Generators for tests.

use rand_pcg::Pcg64;

/// A generator for the test (or part of a test) numbered `seed`.
///
/// Both the state and the stream are scrambled from the seed: neighbouring streams of one generator are not
/// independent enough for a chi-square test over millions of numbers.
pub fn generator(seed: u64) -> Pcg64 {
    let mut state = seed;
    let mut word = || u128::from(split_mix(&mut state));
    let start = (word() << 64) | word();
    let stream = (word() << 64) | word();
    Pcg64::new(start, stream)
}

/// SplitMix64 (Steele, Lea and Flood 2014).
fn split_mix(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}
