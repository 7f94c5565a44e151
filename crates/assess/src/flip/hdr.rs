//! FLIP for high dynamic range: the worst over a range of exposures.

use super::flip_ldr;
use crate::color::luminance;
use crate::image::Image;

/// The tone curve (a x^2 + b x + c) / (d x^2 + e x + f) that approximates ACES, as the authors use it.
const CURVE: [f64; 6] = [0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14];
/// Tone-mapped level that the brightest and the median luminance get at the two ends of the range.
const LEVEL: f64 = 0.85;

fn tone_map(v: f64) -> f64 {
    let [a, b, c, d, e, f] = CURVE;
    (((a * v + b) * v + c) / ((d * v + e) * v + f)).clamp(0.0, 1.0)
}

/// The value that the curve maps to [`LEVEL`].
fn value_at_level() -> f64 {
    let [a, b, c, d, e, f] = CURVE;
    let (a, b, c) = (a - LEVEL * d, b - LEVEL * e, c - LEVEL * f);
    let half = -0.5 * b / a;
    half + (half * half - c / a).sqrt()
}

/// First and last exposure in stops, from the reference's luminance.
fn exposures(reference: &Image) -> (f64, f64) {
    let mut luminances: Vec<f64> = reference.pixels.iter().map(|p| luminance(p.map(|v| v.max(0.0)))).collect();
    luminances.sort_unstable_by(f64::total_cmp);
    let n = luminances.len();
    let (median, brightest) = (luminances[n / 2], luminances[n - 1]);
    let value = value_at_level();
    let stops = |luminance: f64| (value / luminance.max(f64::EPSILON)).log2();
    (stops(brightest), stops(median))
}

/// FLIP of each pixel, for linear values without bound: the greatest over exposures from the one that shows the
/// reference's brightest pixel to the one that shows its median. Both images have the same size.
pub fn flip_hdr(image: &Image, reference: &Image) -> Vec<f64> {
    let (start, stop) = exposures(reference);
    let count = ((stop - start).ceil() as usize).max(2);
    let step = (stop - start) / (count - 1) as f64;
    let mut worst = vec![0.0; image.pixels.len()];
    for i in 0..count {
        let factor = (start + step * i as f64).exp2();
        let expose = |image: &Image| Image {
            pixels: image.pixels.iter().map(|p| p.map(|v| tone_map(v.max(0.0) * factor))).collect(),
            ..*image
        };
        for (worst, flip) in worst.iter_mut().zip(flip_ldr(&expose(image), &expose(reference))) {
            *worst = f64::max(*worst, flip);
        }
    }
    worst
}
