//! Skies of scenes: latitude-longitude maps as Radiance HDR files.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

/// A sky that a function gives.
#[derive(Clone, Copy, Debug)]
pub struct Sky {
    /// Width of the map in pixels, at least 8.
    pub width: u32,
    /// Its height.
    pub height: u32,
    /// Radiance from a unit direction, +y up.
    pub radiance: fn(DVec3) -> DVec3,
}

impl Sky {
    /// The file: pixels of 4 bytes, three mantissas and an exponent in common (Ward 1991), without run lengths. The middle column
    /// shows +x, columns further right turn towards +z.
    pub fn to_hdr(self) -> Vec<u8> {
        let Self { width, height, radiance } = self;
        let mut file = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
        for j in 0..height {
            let (radius, y) = (PI * (f64::from(j) + 0.5) / f64::from(height)).sin_cos();
            for i in 0..width {
                let phi = ((f64::from(i) + 0.5) / f64::from(width) - 0.5) * TAU;
                file.extend(rgbe(radiance(DVec3::new(radius * phi.cos(), y, radius * phi.sin()))));
            }
        }
        file
    }
}

/// A colour with the exponent of its greatest channel, whose mantissa is then from 128 to 255. Such a pixel is never taken for the
/// mark of a run length.
fn rgbe(color: DVec3) -> [u8; 4] {
    let largest = color.max_element();
    if largest < 1e-32 {
        return [0; 4];
    }
    let mut exponent = largest.log2().floor() + 1.0;
    if (largest * (8.0 - exponent).exp2()).round() > 255.0 {
        exponent += 1.0;
    }
    let mantissas = color * (8.0 - exponent).exp2();
    let byte = |v: f64| v.round() as u8;
    [byte(mantissas.x), byte(mantissas.y), byte(mantissas.z), (exponent + 128.0) as u8]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_come_back_to_eight_bits() {
        for color in [DVec3::new(1.0, 0.5, 0.1), DVec3::new(0.0, 3e-5, 700.0), DVec3::splat(0.999), DVec3::ZERO] {
            let [r, g, b, e] = rgbe(color);
            let scale = (f64::from(e) - 136.0).exp2();
            let back = DVec3::new(f64::from(r), f64::from(g), f64::from(b)) * scale;
            assert!((back - color).abs().max_element() <= color.max_element() / 128.0, "{color} {back}");
            assert!(color == DVec3::ZERO || r.max(g).max(b) >= 128, "{color}: {r} {g} {b}");
        }
    }
}
