//! What a chain of primary samples leaves on the film, and what is watched of it.

use std::sync::Arc;

use ergodic_pathspace::{BrightnessMap, Measured, PathClass};
use ergodic_scattering::Rgb;

use super::coordinates::PrimarySample;
use super::mutation::{PrimaryTarget, PrimaryValue};
use crate::chain_runner::Pictured;
use crate::{Estimator, SplatBuffer};

impl<E: Estimator> Pictured for PrimarySample<E> {
    type Target = PrimaryTarget<E>;

    fn target(brightness: Option<Arc<BrightnessMap>>) -> PrimaryTarget<E> {
        PrimaryTarget::new(brightness)
    }

    fn class(&self) -> PathClass {
        self.class()
    }

    /// A sample may light many points of the image, so that it has no one colour.
    fn measured(&self, value: &PrimaryValue) -> Measured {
        Measured { target: value.target, color: Rgb::ZERO, raster: self.brightest() }
    }

    fn leave(&self, value: &PrimaryValue, visits: f64, splats: &mut SplatBuffer) {
        if visits > 0.0 {
            let scale = visits / value.target.value();
            self.splats().iter().for_each(|(raster, color)| splats.splat(*raster, *color * scale));
        }
    }
}
