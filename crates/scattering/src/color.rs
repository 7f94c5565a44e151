//! Colours: linear RGB with the primaries of Rec. 709.

use glam::{DMat3, DVec3};

/// A linear RGB triple: a reflectance, a radiance, or a throughput.
pub type Rgb = DVec3;

/// From CIE XYZ to linear Rec. 709.
pub(crate) const XYZ_TO_RGB: DMat3 = DMat3::from_cols(
    DVec3::new(3.240_454_2, -0.969_266, 0.055_643_4),
    DVec3::new(-1.537_138_5, 1.876_010_8, -0.204_025_9),
    DVec3::new(-0.498_531_4, 0.041_556, 1.057_225_2),
);

/// Relative luminance of a linear colour (ITU-R BT.709, item 3.2).
#[inline]
pub fn luminance(rgb: Rgb) -> f64 {
    0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z
}
