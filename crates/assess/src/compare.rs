//! How far an image is from a reference.

use crate::flip::{flip_hdr, flip_ldr};
use crate::image::Image;

/// Added to the squared reference value in relMSE, so that black pixels do not divide by zero.
pub const RELATIVE_EPSILON: f64 = 0.01;

/// The share of values with the largest error that trimmed relMSE leaves out: fireflies.
pub const TRIMMED_SHARE: f64 = 0.001;

/// Distances between an image and a reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Mean squared error over pixels and channels.
    pub mse: f64,
    /// Mean of squared error over squared reference plus [`RELATIVE_EPSILON`].
    pub rel_mse: f64,
    /// relMSE without the [`TRIMMED_SHARE`] of pixels at which it is largest.
    pub trimmed_rel_mse: f64,
    /// Mean over mean of the reference, for each channel; NaN where the reference's is 0.
    pub mean_ratio: [f64; 3],
    /// Mean of all channels over that of the reference.
    pub total_mean_ratio: f64,
    /// Mean FLIP (Andersson et al. 2020; 2021 for values beyond 1), from 0 to 1.
    pub flip: f64,
    /// Whether FLIP is that for high dynamic range.
    pub flip_is_hdr: bool,
}

/// Compares an image with a reference of the same size.
///
/// # Errors
///
/// A sentence that names both sizes if they differ, or the first value that is not finite.
pub fn compare(image: &Image, reference: &Image) -> Result<Comparison, String> {
    compare_with_map(image, reference).map(|(comparison, _)| comparison)
}

/// The same, with FLIP of each pixel.
///
/// # Errors
///
/// Like [`compare`].
pub fn compare_with_map(image: &Image, reference: &Image) -> Result<(Comparison, Vec<f64>), String> {
    let size = |image: &Image| (image.width, image.height);
    if size(image) != size(reference) {
        return Err(format!(
            "the image has {} x {} pixels, but the reference {} x {}; render it at the reference's size",
            image.width, image.height, reference.width, reference.height
        ));
    }
    for (what, image) in [("image", image), ("reference", reference)] {
        if let Some(at) = image.pixels.iter().position(|p| p.iter().any(|v| !v.is_finite())) {
            let (x, y) = (at % image.width as usize, at / image.width as usize);
            return Err(format!("pixel ({x}, {y}) of the {what} is not finite"));
        }
    }
    let values = (image.pixels.len() * 3) as f64;
    let mut mse = 0.0;
    let mut relative = Vec::with_capacity(image.pixels.len());
    for (a, b) in image.pixels.iter().zip(&reference.pixels) {
        let mut of_pixel = 0.0;
        for (a, b) in a.iter().zip(b) {
            let squared = (a - b) * (a - b);
            mse += squared;
            of_pixel += squared / (b * b + RELATIVE_EPSILON);
        }
        relative.push(of_pixel / 3.0);
    }
    relative.sort_unstable_by(f64::total_cmp);
    let kept = relative.len() - (relative.len() as f64 * TRIMMED_SHARE).ceil() as usize;
    let mean = |list: &[f64]| if list.is_empty() { 0.0 } else { list.iter().sum::<f64>() / list.len() as f64 };
    let (mean_image, mean_reference) = (image.mean(), reference.mean());
    let sum = |m: [f64; 3]| m.iter().sum::<f64>();
    let beyond_white = |image: &Image| image.pixels.iter().flatten().any(|&v| v > 1.0);
    let flip_is_hdr = beyond_white(image) || beyond_white(reference);
    let flip = if flip_is_hdr { flip_hdr(image, reference) } else { flip_ldr(image, reference) };
    let comparison = Comparison {
        mse: mse / values,
        rel_mse: mean(&relative),
        trimmed_rel_mse: mean(&relative[..kept]),
        mean_ratio: [0, 1, 2].map(|i| mean_image[i] / mean_reference[i]),
        total_mean_ratio: sum(mean_image) / sum(mean_reference),
        flip: mean(&flip),
        flip_is_hdr,
    };
    Ok((comparison, flip))
}
