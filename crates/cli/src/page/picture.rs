//! Pictures as a browser gets them: half floats, packed.
//!
//! Every channel is scaled by a power of two, so that the brightest value of the picture is just below the greatest half float, and
//! rounded to a half float of 11 significant bits. The planes are those of red, of green less red and of blue less green, all as
//! 16-bit patterns modulo 2^16: channels are alike, so the differences are small. The high bytes of a plane come before its low
//! bytes, and all is compressed as zlib does it. A browser has what it takes to undo that.

use std::io::Write;

use ergodic_assess::Image;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use half::f16;

/// The greatest power of two that the brightest value may reach: half floats end at 65504.
const TOP: i32 = 15;

/// A picture for the page.
pub struct Packed {
    pub bytes: Vec<u8>,
    /// What a half float is multiplied by.
    pub scale: f64,
    /// Values that are not 0 and became 0.
    pub clipped: usize,
}

/// Packs a picture.
pub fn pack(image: &Image) -> Packed {
    let finite = image.pixels.iter().flatten().map(|v| v.abs()).filter(|v| v.is_finite());
    let greatest = finite.fold(0.0, f64::max);
    let exponent = if greatest > 0.0 { greatest.log2().floor() as i32 + 1 - TOP } else { 0 };
    // Numbers whose power has no reciprocal are not radiance.
    let scale = f64::exp2(f64::from(exponent.clamp(-1000, 1000)));
    let mut clipped = 0;
    let mut bits: Vec<[u16; 3]> = Vec::with_capacity(image.pixels.len());
    for pixel in &image.pixels {
        bits.push(pixel.map(|value| {
            let half = f16::from_f64(value / scale);
            clipped += usize::from(value != 0.0 && half == f16::ZERO);
            half.to_bits()
        }));
    }
    let mut planes = Vec::with_capacity(6 * bits.len());
    for channel in 0..3 {
        let less = |pixel: &[u16; 3]| if channel == 0 { 0 } else { pixel[channel - 1] };
        let plane: Vec<[u8; 2]> = bits.iter().map(|p| p[channel].wrapping_sub(less(p)).to_be_bytes()).collect();
        planes.extend(plane.iter().map(|bytes| bytes[0]));
        planes.extend(plane.iter().map(|bytes| bytes[1]));
    }
    Packed { bytes: compress(&planes), scale, clipped }
}

/// FLIP of every pixel in steps of 1/255, packed.
pub fn pack_flip(flip: &[f64]) -> Vec<u8> {
    compress(&flip.iter().map(|v| (v * 255.0).round() as u8).collect::<Vec<u8>>())
}

fn compress(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(6));
    // Writing to memory does not fail.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;

    /// What the page's script does.
    fn unpack(packed: &Packed, pixels: usize) -> Vec<[f64; 3]> {
        let mut planes = Vec::new();
        flate2::read::ZlibDecoder::new(&packed.bytes[..]).read_to_end(&mut planes).expect("a zlib stream");
        assert_eq!(planes.len(), 6 * pixels);
        let at = |channel: usize, i: usize| {
            let plane = &planes[2 * channel * pixels..];
            u16::from_be_bytes([plane[i], plane[pixels + i]])
        };
        let pixel = |i: usize| {
            let red = at(0, i);
            let green = red.wrapping_add(at(1, i));
            let blue = green.wrapping_add(at(2, i));
            [red, green, blue].map(|bits| f16::from_bits(bits).to_f64() * packed.scale)
        };
        (0..pixels).map(pixel).collect()
    }

    #[test]
    fn pictures_come_back_to_half_precision_however_bright_they_are() {
        let pixels: Vec<[f64; 3]> = (0..600)
            .map(|i| {
                let v = f64::from(i) * 0.37;
                [v.sin().abs() + 0.001, v.cos().abs() + 0.5, (1.0 + v.sin()) * 3.0]
            })
            .collect();
        for factor in [1e-12, 1.0, 3e5, 1e20] {
            let image = Image { width: 30, height: 20, pixels: pixels.iter().map(|p| p.map(|v| v * factor)).collect() };
            let packed = pack(&image);
            let back = unpack(&packed, 600);
            let worst = |back: &[[f64; 3]]| {
                let pairs = image.pixels.iter().flatten().zip(back.iter().flatten());
                pairs.map(|(a, b)| (a - b).abs() / a.max(1e-6 * factor)).fold(0.0, f64::max)
            };
            assert!(worst(&back) <= 1.0 / 2048.0, "{}", worst(&back));
            assert_eq!(packed.clipped, 0);
            // A picture of which a plane got one place out of step is noticed.
            let mut shifted = back.clone();
            shifted.rotate_left(1);
            assert!(worst(&shifted) > 0.1);
        }
    }

    #[test]
    fn what_no_half_float_can_hold_is_known() {
        let pixels = vec![[1e9, 1e-9, 0.0], [f64::NAN, f64::INFINITY, -1.0]];
        let packed = pack(&Image { width: 2, height: 1, pixels });
        assert_eq!(packed.clipped, 1);
        let back = unpack(&packed, 2);
        assert!((back[0][0] / 1e9 - 1.0).abs() < 1e-3 && back[0][1] == 0.0);
        assert!(back[1][0].is_nan() && back[1][1].is_infinite());
        assert_eq!(unpack(&pack(&Image { width: 1, height: 1, pixels: vec![[0.0; 3]] }), 1), [[0.0; 3]]);
    }
}
