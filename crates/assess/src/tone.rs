//! From linear radiance to a screen: exposure, a shoulder for what is brighter than white, sRGB.

use std::path::Path;

use crate::color::{luminance, srgb_encode};
use crate::files::{FileError, write_whole};
use crate::image::Image;

/// How bright a picture is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// The luminance that 95 % of the lit pixels stay below becomes `SHOULDER`.
    Automatic,
    /// Radiance times 2 to this power.
    Stops(f64),
}

/// Values up to here are shown as they are; what is brighter is compressed into the rest.
const SHOULDER: f64 = 0.8;

/// Share of the lit pixels that automatic exposure keeps below the shoulder.
const QUANTILE: f64 = 0.95;

/// Identity up to the shoulder, then a curve of the same slope that tends to 1.
fn shoulder(v: f64) -> f64 {
    if v <= SHOULDER { v.max(0.0) } else { 1.0 - (1.0 - SHOULDER) * (-(v - SHOULDER) / (1.0 - SHOULDER)).exp() }
}

impl Exposure {
    /// The factor for an image.
    pub fn factor(self, image: &Image) -> f64 {
        match self {
            Self::Stops(stops) => stops.exp2(),
            Self::Automatic => {
                let mut lit: Vec<f64> = image.pixels.iter().map(|&p| luminance(p)).filter(|&y| y > 0.0).collect();
                if lit.is_empty() {
                    return 1.0;
                }
                let rank = ((lit.len() - 1) as f64 * QUANTILE) as usize;
                let (_, level, _) = lit.select_nth_unstable_by(rank, f64::total_cmp);
                SHOULDER / *level
            }
        }
    }
}

/// The bytes of an image in 8-bit sRGB, red, green and blue of each pixel.
pub fn to_srgb8(image: &Image, exposure: Exposure) -> Vec<u8> {
    let factor = exposure.factor(image);
    let byte = |v: f64| (srgb_encode(shoulder(v * factor)) * 255.0).round() as u8;
    image.pixels.iter().flat_map(|p| p.map(byte)).collect()
}

/// Writes an 8-bit sRGB PNG.
///
/// # Errors
///
/// A file that cannot be written.
pub fn write_png(path: &Path, image: &Image, exposure: Exposure) -> Result<(), FileError> {
    write_srgb8(path, image.width, image.height, &to_srgb8(image, exposure))
}

/// Writes a PNG of bytes like those of [`to_srgb8`].
///
/// # Errors
///
/// A file that cannot be written.
pub fn write_srgb8(path: &Path, width: u32, height: u32, bytes: &[u8]) -> Result<(), FileError> {
    let mut png = Vec::new();
    let encoder = ::image::codecs::png::PngEncoder::new(&mut png);
    let encoded = ::image::ImageEncoder::write_image(encoder, bytes, width, height, ::image::ExtendedColorType::Rgb8);
    encoded.map_err(|e| FileError::new(path, format!("cannot be encoded: {e}"), "Report this, with the scene"))?;
    write_whole(path, &png)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::srgb_decode;

    #[test]
    fn srgb_goes_there_and_back_and_the_shoulder_is_smooth() {
        for i in 0..=100 {
            let v = f64::from(i) / 100.0;
            assert!((srgb_decode(srgb_encode(v)) - v).abs() < 1e-6);
        }
        let slope = (shoulder(SHOULDER + 1e-6) - shoulder(SHOULDER - 1e-6)) / 2e-6;
        assert!((slope - 1.0).abs() < 1e-5);
        assert!(shoulder(1e9) <= 1.0 && shoulder(2.0) > shoulder(1.0));
    }

    #[test]
    fn automatic_exposure_ignores_black_and_a_few_bright_pixels() {
        let mut pixels = vec![[0.0; 3]; 100];
        pixels.extend(vec![[4.0; 3]; 98]);
        pixels.extend(vec![[1e6; 3]; 2]);
        let image = Image { width: 200, height: 1, pixels };
        assert!((Exposure::Automatic.factor(&image) - SHOULDER / 4.0).abs() < 1e-12);
        assert_eq!(Exposure::Stops(-2.0).factor(&image), 0.25);
    }
}
