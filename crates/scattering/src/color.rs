//! Colours: linear RGB with the primaries of Rec. 709.

/// A linear RGB triple: a reflectance, a radiance, or a throughput.
pub type Rgb = glam::DVec3;

/// Relative luminance of a linear colour (ITU-R BT.709, item 3.2).
#[inline]
pub fn luminance(rgb: Rgb) -> f64 {
    0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z
}
