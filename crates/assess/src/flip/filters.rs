//! The filters of FLIP: contrast sensitivity of the eye, edges and points.

use std::f64::consts::PI;

use super::color::from_ycxcz;

/// A grid of values.
pub(super) struct Plane<T> {
    pub width: usize,
    pub height: usize,
    pub values: Vec<T>,
}

impl<T: Copy> Plane<T> {
    fn map<U>(&self, f: impl Fn(T) -> U) -> Plane<U> {
        Plane { width: self.width, height: self.height, values: self.values.iter().map(|&v| f(v)).collect() }
    }
}

impl Plane<f64> {
    /// Convolves rows with `across` and columns with `down`, both of odd length; the edge pixels go on outside.
    fn convolve(&self, across: &[f64], down: &[f64]) -> Self {
        let clamp = |i: usize, offset: usize, radius: usize, n: usize| (i + offset).saturating_sub(radius).min(n - 1);
        let (width, height) = (self.width, self.height);
        let radius = across.len() / 2;
        let mut rows = vec![0.0; self.values.len()];
        for y in 0..height {
            let row = &self.values[y * width..][..width];
            for x in 0..width {
                let terms = across.iter().enumerate().map(|(i, weight)| weight * row[clamp(x, i, radius, width)]);
                rows[y * width + x] = terms.sum();
            }
        }
        let radius = down.len() / 2;
        let mut values = vec![0.0; self.values.len()];
        for y in 0..height {
            for (i, weight) in down.iter().enumerate() {
                let from = clamp(y, i, radius, height) * width;
                for x in 0..width {
                    values[y * width + x] += weight * rows[from + x];
                }
            }
        }
        Self { width, height, values }
    }
}

/// A sum of two Gaussians of visual angle, the impulse response of one channel of the eye (table 1 of the paper).
struct Response {
    a: [f64; 2],
    b: [f64; 2],
}

const ACHROMATIC: Response = Response { a: [1.0, 0.0], b: [0.0047, 1e-5] };
const RED_GREEN: Response = Response { a: [1.0, 0.0], b: [0.0053, 1e-5] };
const BLUE_YELLOW: Response = Response { a: [34.1, 13.5], b: [0.04, 0.025] };

/// One channel's filter as a sum of separable parts with their weights.
struct Channel {
    parts: Vec<(f64, Vec<f64>)>,
}

impl Channel {
    fn new(response: &Response, radius: i64, pixels_per_degree: f64) -> Self {
        let mut parts = Vec::new();
        for (&a, &b) in response.a.iter().zip(&response.b) {
            if a == 0.0 {
                continue;
            }
            let value = |i: i64| {
                let degrees = i as f64 / pixels_per_degree;
                (-PI * PI * degrees * degrees / b).exp()
            };
            let line: Vec<f64> = (-radius..=radius).map(value).collect();
            parts.push((a * (PI / b).sqrt(), line));
        }
        let volume: f64 = parts.iter().map(|(weight, line)| weight * line.iter().sum::<f64>().powi(2)).sum();
        parts.iter_mut().for_each(|(weight, _)| *weight /= volume);
        Self { parts }
    }

    fn apply(&self, plane: &Plane<f64>) -> Vec<f64> {
        let mut sum = vec![0.0; plane.values.len()];
        for (weight, line) in &self.parts {
            for (sum, value) in sum.iter_mut().zip(plane.convolve(line, line).values) {
                *sum += weight * value;
            }
        }
        sum
    }
}

/// What the eye sees of an image.
pub(super) struct Spatial {
    channels: [Channel; 3],
}

impl Spatial {
    pub(super) fn new(pixels_per_degree: f64) -> Self {
        let widest = [ACHROMATIC, RED_GREEN, BLUE_YELLOW].iter().flat_map(|r| r.b).fold(0.0, f64::max);
        let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i64;
        let channels = [ACHROMATIC, RED_GREEN, BLUE_YELLOW].map(|r| Channel::new(&r, radius, pixels_per_degree));
        Self { channels }
    }

    /// Linear RGB from 0 to 1 of the filtered image.
    pub(super) fn apply(&self, opponent: &Plane<[f64; 3]>) -> Vec<[f64; 3]> {
        let [luma, cx, cz] = [0, 1, 2].map(|i| self.channels[i].apply(&opponent.map(|v| v[i])));
        let pixel = |i: usize| from_ycxcz([luma[i], cx[i], cz[i]]).map(|v| v.clamp(0.0, 1.0));
        (0..luma.len()).map(pixel).collect()
    }
}

/// Width of the features that are looked for, in degrees.
const FEATURE_WIDTH: f64 = 0.082;

/// Scales positive weights to a sum of 1 and negative ones to -1.
fn balance(mut weights: Vec<f64>) -> Vec<f64> {
    let positive: f64 = weights.iter().filter(|w| **w > 0.0).sum();
    let negative: f64 = -weights.iter().filter(|w| **w < 0.0).sum::<f64>();
    weights.iter_mut().for_each(|w| *w /= if *w > 0.0 { positive } else { negative });
    weights
}

/// The greater of the differences in edges and in points at each pixel.
pub(super) fn feature_difference(
    test: &Plane<[f64; 3]>,
    reference: &Plane<[f64; 3]>,
    pixels_per_degree: f64,
) -> Vec<f64> {
    let deviation = 0.5 * FEATURE_WIDTH * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as i64;
    let gauss = |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
    let line = |f: &dyn Fn(f64) -> f64| (-radius..=radius).map(|i| f(i as f64)).collect::<Vec<f64>>();
    let smooth = balance(line(&gauss));
    let edge = balance(line(&|x| -x * gauss(x)));
    let point = balance(line(&|x| (x * x / (deviation * deviation) - 1.0) * gauss(x)));
    let strengths = |opponent: &Plane<[f64; 3]>, filter: &[f64]| -> Vec<f64> {
        let luma = opponent.map(|v| (v[0] + 16.0) / 116.0);
        let (x, y) = (luma.convolve(filter, &smooth), luma.convolve(&smooth, filter));
        x.values.iter().zip(&y.values).map(|(x, y)| x.hypot(*y)).collect()
    };
    let difference = |filter: &[f64]| -> Vec<f64> {
        let pairs = strengths(test, filter).into_iter().zip(strengths(reference, filter));
        pairs.map(|(a, b)| (a - b).abs()).collect()
    };
    difference(&edge).into_iter().zip(difference(&point)).map(|(a, b)| a.max(b)).collect()
}
