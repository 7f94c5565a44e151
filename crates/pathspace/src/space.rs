//! What a chain of paths lives in, and the scalar it samples by.

use std::marker::PhantomData;
use std::sync::Arc;

use ergodic_metropolis::{Density, Target};
use ergodic_scattering::{Everything, Repertoire, Rgb, luminance};
use glam::DVec2;

use crate::{BrightnessMap, Lengths, Path, Scene, contribution};

/// A scene and the lengths of the paths in it that a chain may visit.
#[derive(Clone, Debug)]
pub struct PathSpace<R: Repertoire = Everything> {
    /// The scene.
    pub scene: Scene<R>,
    /// The lengths.
    pub lengths: Lengths,
}

/// The target of Metropolis light transport: C(x), the luminance of f (Veach 11.2), one scalar for the whole image. With a map of the
/// image's brightness it is the luminance over the brightness of where the path arrives.
#[derive(Clone, Debug)]
pub struct LuminanceTarget<R: Repertoire = Everything> {
    brightness: Option<Arc<BrightnessMap>>,
    repertoire: PhantomData<R>,
}

impl<R: Repertoire> LuminanceTarget<R> {
    /// The luminance, over `brightness` if there is a map of it.
    pub fn new(brightness: Option<Arc<BrightnessMap>>) -> Self {
        Self { brightness, repertoire: PhantomData }
    }
}

impl<R: Repertoire> Default for LuminanceTarget<R> {
    /// The luminance.
    fn default() -> Self {
        Self::new(None)
    }
}

/// What one evaluation of [`LuminanceTarget`] yields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// C(x), the target; 0 where the path carries nothing.
    pub target: Density,
    /// f(x) / C(x) per channel: what a visit adds to the image, up to b.
    pub color: Rgb,
    /// Where the path meets the image.
    pub raster: DVec2,
}

impl<R: Repertoire> Target for LuminanceTarget<R> {
    type State = Path<R>;
    type Value = Measured;

    #[inline(always)]
    fn evaluate(&self, x: &Path<R>) -> Measured {
        let Some(raster) = x.raster else {
            return Measured { target: Density::ZERO, color: Rgb::ZERO, raster: DVec2::ZERO };
        };
        let f = contribution(x);
        // A negative channel is as wrong as one that is no number, though the luminance may hide it.
        let luminance = if f.rgb.min_element() < 0.0 { f64::NAN } else { luminance(f.rgb) };
        let target = BrightnessMap::relative(self.brightness.as_deref(), luminance, raster);
        Measured { target: Density::new(target).scaled(f.exponent), color: f.rgb / target, raster }
    }

    #[inline]
    fn ln_density(value: &Measured) -> f64 {
        value.target.ln()
    }

    #[inline]
    fn density(value: &Measured) -> Density {
        value.target
    }
}
