//! Textures: decoded texels, wrap modes, bilinear look-up.

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

/// An image that is read by coordinates. Row 0 is v = 0 (the top row of the image file, as glTF has it).
#[derive(Clone, Debug)]
pub struct Texture {
    /// Width in texels, at least 1.
    pub width: u32,
    /// Height in texels, at least 1.
    pub height: u32,
    /// Linear RGBA, `width * height` entries in row order. sRGB images are decoded before they get here.
    pub texels: Vec<[f32; 4]>,
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
        let [r, g, b, a] = self.texels[y * self.width as usize + x];
        DVec4::new(f64::from(r), f64::from(g), f64::from(b), f64::from(a))
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
        let texels = (0..4).map(|i| [i as f32, 0.0, 0.0, 1.0]).collect();
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
}
