//! FLIP: how different two images look when one flips between them (Andersson et al., "FLIP: A Difference Evaluator for
//! Alternating Images", 2020; "Visualizing Errors in Rendered High Dynamic Range Images", 2021).

mod color;
mod filters;
mod hdr;

pub use hdr::flip_hdr;

use crate::image::Image;
use color::{hunt_lab, hyab, to_ycxcz};
use filters::{Plane, Spatial, feature_difference};

/// Pixels per degree of visual angle at 0.7 m from a screen 0.7 m and 3840 pixels wide, the authors' default.
const PIXELS_PER_DEGREE: f64 = 0.7 * 3840.0 / 0.7 * std::f64::consts::PI / 180.0;

/// Exponent of the colour difference (section 4.1.3).
const QC: f64 = 0.7;
/// Share of the greatest colour difference that is mapped below [`PT`].
const PC: f64 = 0.4;
/// Where that share is mapped to.
const PT: f64 = 0.95;
/// Exponent of the feature difference (section 4.2.2).
const QF: f64 = 0.5;

/// FLIP of each pixel, for linear values from 0 to 1; what lies outside is clamped. Both images have the same size.
pub fn flip_ldr(image: &Image, reference: &Image) -> Vec<f64> {
    let opponent = |image: &Image| -> Plane<[f64; 3]> {
        let pixels = image.pixels.iter().map(|p| to_ycxcz(p.map(|v| v.clamp(0.0, 1.0)))).collect();
        Plane { width: image.width as usize, height: image.height as usize, values: pixels }
    };
    let (test, reference) = (opponent(image), opponent(reference));
    let spatial = Spatial::new(PIXELS_PER_DEGREE);
    let (seen_test, seen_reference) = (spatial.apply(&test), spatial.apply(&reference));
    let greatest = hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])).powf(QC);
    let features = feature_difference(&test, &reference, PIXELS_PER_DEGREE);
    seen_test
        .iter()
        .zip(&seen_reference)
        .zip(features)
        .map(|((a, b), feature)| {
            let color = redistribute(hyab(hunt_lab(*a), hunt_lab(*b)).powf(QC), greatest);
            let feature = (feature * std::f64::consts::FRAC_1_SQRT_2).powf(QF);
            color.powf(1.0 - feature)
        })
        .collect()
}

/// Maps colour differences to `[0, 1]`, most of the range for the smaller ones.
fn redistribute(difference: f64, greatest: f64) -> f64 {
    let knee = PC * greatest;
    if difference < knee { PT / knee * difference } else { PT + (difference - knee) / (greatest - knee) * (1.0 - PT) }
}
