//! Surfaces that cover a share only of what lies behind them (glTF's alphaMode).
//!
//! Such a surface is a limit of ever smaller flakes: of light that meets it the share a, its coverage, is scattered or absorbed
//! there, and 1 - a goes straight on as if nothing were there. In path space (Veach 8) that makes visibility V a number in [0, 1],
//! the product of 1 - a over the surfaces between two points, and gives every vertex on such a surface the factor a. Both belong to
//! the edges:
//!
//! - f has V in the geometry term of each edge, and the coverage of each vertex in the edge that leaves it towards the eye;
//! - a ray passes a surface with probability 1 - a and stops with probability a, so V and the coverage of the vertex found are part
//!   of what turns a density of directions into one of area, from either side.
//!
//! All are functions of the points alone, the same to the bit from both ends. Scenes without such surfaces know nothing of this.

/// The share that a surface covers at a point, in steps of 1/65535, of which those of 8-bit textures are multiples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coverage(u16);

impl Coverage {
    /// All of it.
    pub const WHOLE: Self = Self(u16::MAX);

    /// The nearest step to a share in [0, 1].
    #[inline]
    pub fn new(share: f64) -> Self {
        Self((share * f64::from(u16::MAX)).round() as u16)
    }

    /// The share.
    #[inline]
    pub fn share(self) -> f64 {
        f64::from(self.0) / f64::from(u16::MAX)
    }
}
