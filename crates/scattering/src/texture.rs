//! Textures: decoded texels, wrap modes, bilinear look-up.

use std::sync::{Arc, LazyLock};

use ergodic_geometry::Surface;
use glam::{DAffine2, DVec2, DVec4};

/// How coordinates beyond `[0, 1]` are read (glTF 2.0, section 3.8.4.5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image repeats.
    #[default]
    Repeat,
    /// Every other repetition is mirrored.
    MirroredRepeat,
    /// The edge texels go on.
    ClampToEdge,
}

/// How texels are interpolated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Linear in both directions.
    #[default]
    Bilinear,
    /// The nearest texel.
    Nearest,
}

/// Texels as they are stored, RGBA in row order; they are read as linear numbers.
#[derive(Clone, Debug)]
pub enum Texels {
    /// Colour in sRGB, alpha linear.
    Srgb8(Arc<[[u8; 4]]>),
    /// Linear numbers from 0 to 1.
    Linear8(Arc<[[u8; 4]]>),
    /// Linear numbers.
    Float(Arc<[[f32; 4]]>),
}

/// Each byte of sRGB as a linear number (IEC 61966-2-1).
static SRGB: LazyLock<[f64; 256]> = LazyLock::new(|| {
    std::array::from_fn(|byte| {
        let encoded = byte as f64 / 255.0;
        if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
    })
});

/// A byte of sRGB as a linear number from 0 to 1.
pub fn srgb_to_linear(byte: u8) -> f64 {
    SRGB[usize::from(byte)]
}

impl Texels {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Srgb8(texels) | Self::Linear8(texels) => texels.len(),
            Self::Float(texels) => texels.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes they take.
    pub fn bytes(&self) -> u64 {
        let each = match self {
            Self::Srgb8(_) | Self::Linear8(_) => 4,
            Self::Float(_) => 16,
        };
        each * self.len() as u64
    }

    #[inline]
    fn read(&self, index: usize) -> DVec4 {
        match self {
            Self::Srgb8(texels) => {
                let [r, g, b, a] = texels[index];
                let table = &*SRGB;
                DVec4::new(table[r as usize], table[g as usize], table[b as usize], f64::from(a) / 255.0)
            }
            Self::Linear8(texels) => DVec4::from_array(texels[index].map(|byte| f64::from(byte) / 255.0)),
            Self::Float(texels) => DVec4::from_array(texels[index].map(f64::from)),
        }
    }
}

/// An image that is read by coordinates. Row 0 is v = 0 (the top row of the image file, as glTF has it).
#[derive(Clone, Debug)]
pub struct Texture {
    /// Width in texels, at least 1.
    pub width: u32,
    /// Height in texels, at least 1.
    pub height: u32,
    /// `width * height` of them.
    pub texels: Texels,
    /// Wrap mode along u.
    pub wrap_u: Wrap,
    /// Wrap mode along v.
    pub wrap_v: Wrap,
    /// Interpolation.
    pub interpolation: Interpolation,
}

/// A use of a texture by a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureUse {
    /// Index into the scene's textures.
    pub texture: usize,
    /// Which of the two sets of texture coordinates.
    pub texcoord: usize,
    /// KHR_texture_transform: maps the mesh's coordinates to the texture's.
    pub transform: DAffine2,
}

impl TextureUse {
    /// The texture's value at a surface point: linear RGBA.
    pub fn at(&self, textures: &[Texture], surface: &Surface) -> DVec4 {
        textures[self.texture].lookup(self.transform.transform_point2(surface.texcoords[self.texcoord]))
    }
}

impl Wrap {
    fn index(self, i: i64, n: i64) -> usize {
        let wrapped = match self {
            Self::Repeat => i.rem_euclid(n),
            Self::MirroredRepeat => {
                let j = i.rem_euclid(2 * n);
                if j < n { j } else { 2 * n - 1 - j }
            }
            Self::ClampToEdge => i.clamp(0, n - 1),
        };
        wrapped as usize
    }
}

impl Texture {
    fn texel(&self, x: i64, y: i64) -> DVec4 {
        let x = self.wrap_u.index(x, i64::from(self.width));
        let y = self.wrap_v.index(y, i64::from(self.height));
        self.texels.read(y * self.width as usize + x)
    }

    /// The least alpha of a texel, and so of any value between them.
    pub fn least_alpha(&self) -> f64 {
        (0..self.texels.len()).map(|i| self.texels.read(i).w).fold(1.0, f64::min)
    }

    /// The value at texture coordinates `uv`: linear RGBA. Coordinates that are not finite read as 0.
    pub fn lookup(&self, uv: DVec2) -> DVec4 {
        let uv = if uv.is_finite() { uv } else { DVec2::ZERO };
        let x = uv.x * f64::from(self.width);
        let y = uv.y * f64::from(self.height);
        match self.interpolation {
            Interpolation::Nearest => self.texel(x.floor() as i64, y.floor() as i64),
            Interpolation::Bilinear => {
                let (x, y) = (x - 0.5, y - 0.5);
                let (x0, y0) = (x.floor(), y.floor());
                let (fx, fy) = (x - x0, y - y0);
                let (x0, y0) = (x0 as i64, y0 as i64);
                let top = self.texel(x0, y0).lerp(self.texel(x0 + 1, y0), fx);
                let bottom = self.texel(x0, y0 + 1).lerp(self.texel(x0 + 1, y0 + 1), fx);
                top.lerp(bottom, fy)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(wrap: Wrap, interpolation: Interpolation) -> Texture {
        let texels = Texels::Float((0..4).map(|i| [i as f32, 0.0, 0.0, 1.0]).collect());
        Texture { width: 4, height: 1, texels, wrap_u: wrap, wrap_v: wrap, interpolation }
    }

    #[test]
    fn wrap_modes_read_the_texels_the_specification_names() {
        let read = |wrap, u: f64| row(wrap, Interpolation::Nearest).lookup(DVec2::new(u, 0.5)).x;
        let centres = |from: i32, to: i32| (from..to).map(|i| (f64::from(i) + 0.5) / 4.0).collect::<Vec<_>>();
        let values = |wrap| centres(-4, 8).iter().map(|&u| read(wrap, u)).collect::<Vec<_>>();
        assert_eq!(values(Wrap::Repeat), [0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3.]);
        assert_eq!(values(Wrap::MirroredRepeat), [3., 2., 1., 0., 0., 1., 2., 3., 3., 2., 1., 0.]);
        assert_eq!(values(Wrap::ClampToEdge), [0., 0., 0., 0., 0., 1., 2., 3., 3., 3., 3., 3.]);
    }

    #[test]
    fn bilinear_is_exact_at_texel_centres_and_linear_between() {
        let texture = row(Wrap::ClampToEdge, Interpolation::Bilinear);
        for i in 0..4 {
            assert_eq!(texture.lookup(DVec2::new((f64::from(i) + 0.5) / 4.0, 0.5)).x, f64::from(i));
        }
        assert_eq!(texture.lookup(DVec2::new(0.5, 0.5)).x, 1.5);
    }

    #[test]
    fn srgb_bytes_are_decoded_and_others_are_not() {
        let half = [188u8, 0, 255, 128];
        let read = |texels: Texels| texels.read(0);
        let srgb = read(Texels::Srgb8([half].into()));
        // 188 is the byte nearest to the code of one half.
        assert!((srgb.x - 0.5).abs() < 0.003 && srgb.y == 0.0 && srgb.z == 1.0 && srgb.w == 128.0 / 255.0);
        assert_eq!(read(Texels::Linear8([half].into())).x, 188.0 / 255.0);
    }
}
