//! An image in memory.

/// Linear RGB, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` pixels.
    pub pixels: Vec<[f64; 3]>,
}

/// Most pixels of an image that is read.
pub(crate) const MAX_PIXELS: u64 = 1 << 28;

impl Image {
    /// The mean of each channel.
    pub fn mean(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for pixel in &self.pixels {
            for (sum, value) in sum.iter_mut().zip(pixel) {
                *sum += value;
            }
        }
        sum.map(|s| s / self.pixels.len() as f64)
    }
}
