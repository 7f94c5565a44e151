//! Reference images: mean and variance of every pixel, from independent replicas, in one EXR file.
//!
//! Channels R, G, B hold the mean over the replicas, `variance.R`, `variance.G`, `variance.B` the variance of that mean, and
//! `block.Y` the variance of the mean luminance of the block of [`BLOCK`] x [`BLOCK`] pixels that the pixel lies in. The last
//! cannot be computed from the others where pixels are correlated, as those of a Markov chain are.

use std::io::Cursor;
use std::path::Path;

use ergodic_laws::Moments;
use exr::prelude::{
    Encoding, Image as ExrImage, Layer, ReadChannels, ReadLayers, ReadSpecificChannel, SpecificChannels, WritableImage,
};

use crate::color::luminance;
use crate::exr_file::{Attribute, check_size, header_attributes};
use crate::files::{FileError, write_whole};
use crate::image::Image;

/// Pixels on a side of the blocks that images are compared by.
pub const BLOCK: u32 = 8;

/// An image with what is known of its error.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Mean over the replicas.
    pub mean: Image,
    /// Variance of that mean, for each pixel and channel.
    pub variance: Image,
    /// Variance of the mean luminance of each block, in row order.
    pub block_variance: Vec<f64>,
    /// Variance of the mean luminance of the whole image.
    pub total_variance: f64,
}

/// Columns and rows of blocks; those at the right and lower edges may be smaller.
pub(crate) fn block_grid(width: u32, height: u32) -> (usize, usize) {
    (width.div_ceil(BLOCK) as usize, height.div_ceil(BLOCK) as usize)
}

/// The block of each pixel, in row order.
fn block_of(image: &Image) -> impl Iterator<Item = usize> {
    let (width, columns) = (image.width as usize, block_grid(image.width, image.height).0);
    let block = BLOCK as usize;
    (0..image.pixels.len()).map(move |i| i / width / block * columns + i % width / block)
}

/// Mean luminance of each block, and of the whole image.
pub(crate) fn block_means(image: &Image) -> (Vec<f64>, f64) {
    let (columns, rows) = block_grid(image.width, image.height);
    let mut sums = vec![(0.0, 0u32); columns * rows];
    let mut total = 0.0;
    for (pixel, block) in image.pixels.iter().zip(block_of(image)) {
        let y = luminance(*pixel);
        sums[block].0 += y;
        sums[block].1 += 1;
        total += y;
    }
    (sums.into_iter().map(|(sum, n)| sum / f64::from(n)).collect(), total / image.pixels.len() as f64)
}

impl Reference {
    /// The mean of independent replicas and its variance.
    ///
    /// `None` for fewer than two replicas, or replicas of different sizes.
    pub fn from_replicas(replicas: &[Image]) -> Option<Self> {
        let first = replicas.first()?;
        let same = |image: &Image| (image.width, image.height) == (first.width, first.height);
        if replicas.len() < 2 || !replicas.iter().all(same) {
            return None;
        }
        let n = replicas.len() as f64;
        let empty = || Image { pixels: Vec::with_capacity(first.pixels.len()), ..*first };
        let (mut mean, mut variance) = (empty(), empty());
        for i in 0..first.pixels.len() {
            let moments = [0, 1, 2].map(|c| replicas.iter().map(|r| r.pixels[i][c]).collect::<Moments>());
            mean.pixels.push([0, 1, 2].map(|c| moments[c].mean()));
            variance.pixels.push([0, 1, 2].map(|c| moments[c].variance() / n));
        }
        let blocks: Vec<(Vec<f64>, f64)> = replicas.iter().map(block_means).collect();
        let of_mean = |values: &mut dyn Iterator<Item = f64>| values.collect::<Moments>().variance() / n;
        let block_variance =
            (0..blocks[0].0.len()).map(|i| of_mean(&mut blocks.iter().map(|(means, _)| means[i]))).collect();
        let total_variance = of_mean(&mut blocks.iter().map(|(_, total)| *total));
        Some(Self { mean, variance, block_variance, total_variance })
    }

    /// Mean luminance of the whole image and its relative standard error.
    pub fn total(&self) -> (f64, f64) {
        let (_, total) = block_means(&self.mean);
        (total, self.total_variance.sqrt() / total)
    }

    /// The median over the blocks of their relative standard error.
    pub fn median_block_error(&self) -> f64 {
        let (means, _) = block_means(&self.mean);
        let mut errors: Vec<f64> =
            means.iter().zip(&self.block_variance).filter(|(m, _)| **m > 0.0).map(|(m, v)| v.sqrt() / m).collect();
        errors.sort_unstable_by(f64::total_cmp);
        errors.get(errors.len() / 2).copied().unwrap_or(0.0)
    }

    /// Writes the file.
    ///
    /// # Errors
    ///
    /// A file that cannot be written.
    pub fn write(&self, path: &Path, attributes: &[(&str, Attribute)]) -> Result<(), FileError> {
        let size = (self.mean.width as usize, self.mean.height as usize);
        let blocks: Vec<usize> = block_of(&self.mean).collect();
        let channels = SpecificChannels::build()
            .with_channel::<f32>("R")
            .with_channel::<f32>("G")
            .with_channel::<f32>("B")
            .with_channel::<f32>("variance.R")
            .with_channel::<f32>("variance.G")
            .with_channel::<f32>("variance.B")
            .with_channel::<f32>("block.Y")
            .with_pixel_fn(|at: exr::math::Vec2<usize>| {
                let i = at.y() * size.0 + at.x();
                let [r, g, b] = self.mean.pixels[i].map(|v| v as f32);
                let [vr, vg, vb] = self.variance.pixels[i].map(|v| v as f32);
                (r, g, b, vr, vg, vb, self.block_variance[blocks[i]] as f32)
            });
        let total = ("ergodic.total_variance", Attribute::Number(self.total_variance));
        let all: Vec<_> = attributes.iter().cloned().chain([total]).collect();
        let layer = Layer::new(size, header_attributes(&all), Encoding::SMALL_LOSSLESS, channels);
        let mut bytes = Vec::new();
        ExrImage::from_layer(layer).write().to_buffered(Cursor::new(&mut bytes)).map_err(|e| {
            FileError::new(path, format!("cannot be encoded: {e}"), "Report this, with the scene and the config")
        })?;
        write_whole(path, &bytes)
    }

    /// Reads a file that [`Self::write`] wrote.
    ///
    /// # Errors
    ///
    /// A file that cannot be read or lacks a channel.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let mend = "Make the reference again";
        let bytes = std::fs::read(path).map_err(|e| FileError::new(path, format!("cannot be read: {e}"), mend))?;
        let broken = |problem: String| FileError::new(path, problem, mend);
        check_size(&bytes).map_err(broken)?;
        type Pixels = (usize, Vec<[f32; 7]>);
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .specific_channels()
            .required("R")
            .required("G")
            .required("B")
            .required("variance.R")
            .required("variance.G")
            .required("variance.B")
            .required("block.Y")
            .collect_pixels(
                |size, _| -> Pixels { (size.width(), vec![[0.0; 7]; size.width() * size.height()]) },
                |(width, pixels): &mut Pixels, at, (r, g, b, vr, vg, vb, y): (f32, f32, f32, f32, f32, f32, f32)| {
                    pixels[at.y() * *width + at.x()] = [r, g, b, vr, vg, vb, y];
                },
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(&bytes))
            .map_err(|e| broken(format!("cannot be decoded: {e}")))?;
        let size = image.layer_data.size;
        let (_, pixels) = image.layer_data.channel_data.pixels;
        let image_of = |first: usize| Image {
            width: size.width() as u32,
            height: size.height() as u32,
            pixels: pixels.iter().map(|p| [0, 1, 2].map(|c| f64::from(p[first + c]))).collect(),
        };
        let (mean, variance) = (image_of(0), image_of(3));
        let (columns, rows) = block_grid(mean.width, mean.height);
        let mut block_variance = vec![0.0; columns * rows];
        for (block, pixel) in block_of(&mean).zip(&pixels) {
            block_variance[block] = f64::from(pixel[6]);
        }
        let other = &image.layer_data.attributes.other;
        let total_variance = other.iter().find_map(|(name, value)| match value {
            exr::meta::attribute::AttributeValue::F64(v) if name == "ergodic.total_variance" => Some(*v),
            _ => None,
        });
        let total_variance = total_variance.ok_or_else(|| broken("has no ergodic.total_variance".into()))?;
        Ok(Self { mean, variance, block_variance, total_variance })
    }
}
