//! Sine and cosine of parts of a full turn, for angles drawn uniformly.
//!
//! The series of the textbook over an eighth of a turn to either side, where they end early. It has no branch that depends on the
//! angle and no multiplication by the period to undo, so it takes a third of the time of the general functions; and the numbers are
//! the same on every platform.

use std::f64::consts::TAU;

/// (sin, cos) of `turns` full turns, for `turns` in [0, 1]. Errors below 3e-16.
#[inline]
pub fn sin_cos_turns(turns: f64) -> (f64, f64) {
    // The nearest quarter. Both it and what is left are exact.
    let quarter = (4.0 * turns + 0.5) as i32;
    let (sin, cos) = sin_cos_eighth(turns - 0.25 * f64::from(quarter));
    let odd = quarter & 1 == 1;
    let (s, c) = (if odd { cos } else { sin }, if odd { sin } else { cos });
    // The signs of the quarters, moved to the place of a double's sign.
    let sign = |x: f64, negative: i32| f64::from_bits(x.to_bits() ^ (negative as u64 & 1) << 63);
    (sign(s, quarter >> 1), sign(c, (quarter + 1) >> 1))
}

/// (-1)^n / (2n+1)! for n = 1 ..= 8: the series of sin(x)/x less its first term. The first term left out is below 2e-18.
const SIN: [f64; 8] = [
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
    1.0 / 355_687_428_096_000.0,
];

/// (-1)^n / (2n)! for n = 2 ..= 9: the series of cos(x) less its first two terms.
const COS: [f64; 8] = [
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
    -1.0 / 6_402_373_705_728_000.0,
];

/// The polynomial with these coefficients, by halves (Estrin), so that few operations wait for each other.
#[inline]
fn polynomial(c: &[f64; 8], x: f64) -> f64 {
    let (x2, x4) = (x * x, (x * x) * (x * x));
    let low = (c[0] + c[1] * x) + (c[2] + c[3] * x) * x2;
    let high = (c[4] + c[5] * x) + (c[6] + c[7] * x) * x2;
    low + high * x4
}

/// (sin, cos) of `turns` full turns, for `turns` in [-1/8, 1/8]. Errors below 3e-16.
#[inline]
pub fn sin_cos_eighth(turns: f64) -> (f64, f64) {
    let x = TAU * turns;
    let square = x * x;
    let (sin, cos) = (polynomial(&SIN, square), polynomial(&COS, square));
    (x + x * square * sin, 1.0 - (0.5 * square - square * square * cos))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_sine_and_cosine_everywhere() {
        let mut worst = 0.0f64;
        for i in 0..=1_000_000 {
            let turns = f64::from(i) / 1e6;
            // The general functions of an angle that was rounded: the angle's own error is taken off.
            let angle = TAU * turns;
            let off = TAU.mul_add(turns, -angle) + 2.449_293_598_294_706_4e-16 * turns;
            let (sin, cos) = angle.sin_cos();
            let (s, c) = sin_cos_turns(turns);
            worst = worst.max((s - (sin + cos * off)).abs()).max((c - (cos - sin * off)).abs());
        }
        assert!(worst < 3e-16, "{worst:e}");
    }

    #[test]
    fn quarters_are_exact() {
        let quarters = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 1.0)];
        for (i, (sin, cos)) in (0u32..).zip(quarters) {
            assert_eq!(sin_cos_turns(0.25 * f64::from(i)), (sin, cos));
        }
    }
}
