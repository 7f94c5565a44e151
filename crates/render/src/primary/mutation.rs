//! Large and small steps through primary sample space.

use std::convert::Infallible;
use std::marker::PhantomData;
use std::sync::Arc;

use ergodic_metropolis::unit_cube::SmallStep;
use ergodic_metropolis::{Density, Mutation, RandomSource, Target};
use ergodic_pathspace::{BrightnessMap, Scene};
use ergodic_scattering::{Everything, Repertoire, luminance};
use glam::DVec2;

use super::coordinates::{Coordinates, PrimarySample};
use crate::Estimator;

/// What a chain of primary samples lives in.
#[derive(Clone, Debug)]
pub struct PrimarySpace<R: Repertoire = Everything> {
    /// The scene.
    pub scene: Scene<R>,
}

/// A mutation of a primary sample (Kelemen et al. 2002, section 5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PrimaryMutation<E> {
    /// Draws every coordinate anew: an independent sample. It makes the chain ergodic.
    Large,
    /// Moves every coordinate a little; the second is the estimator whose samples are changed.
    Small(SmallStep, PhantomData<E>),
}

impl<E> PrimaryMutation<E> {
    /// A small step.
    pub fn small(min: f64, max: f64) -> Self {
        Self::Small(SmallStep { min, max }, PhantomData)
    }

    /// Its name in tables and files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Large => "large_step",
            Self::Small(..) => "small_step",
        }
    }

    /// The density of the coordinates of `to` given those of `from`, over the coordinates that `to` uses.
    fn density_of(&self, from: &Coordinates, to: &Coordinates) -> Density {
        let Self::Small(step, _) = self else { return Density::ONE };
        let mut density = Density::ONE;
        for (index, value) in to.used() {
            // What was not in use before is drawn uniformly.
            let Some(before) = from.get(index) else { continue };
            if index.is_kept() {
                if value != before {
                    return Density::ZERO;
                }
                continue;
            }
            density.multiply(step.pdf(before, value));
        }
        density
    }
}

impl<E: Estimator> Mutation for PrimaryMutation<E> {
    type Space = PrimarySpace<E::Repertoire>;
    type State = PrimarySample<E>;
    type Plan = ();
    type Failure = Infallible;

    fn propose(
        &self,
        space: &Self::Space,
        x: &PrimarySample<E>,
        y: &mut PrimarySample<E>,
        rng: &mut impl RandomSource,
    ) -> Result<(), Infallible> {
        let scene = &space.scene;
        match *self {
            Self::Large => y.draw(scene, rng),
            Self::Small(step, _) => y.evaluate(scene, |index| match x.coordinates.get(index) {
                None => rng.uniform(),
                Some(value) if index.is_kept() => value,
                Some(value) => step.moved(value, rng),
            }),
        }
        Ok(())
    }

    fn ln_density(&self, space: &Self::Space, from: &PrimarySample<E>, to: &PrimarySample<E>, plan: ()) -> f64 {
        self.density(space, from, to, plan).ln()
    }

    fn density(&self, _: &Self::Space, from: &PrimarySample<E>, to: &PrimarySample<E>, _: ()) -> Density {
        self.density_of(&from.coordinates, &to.coordinates)
    }
}

/// The target: the luminance of what a sample brings to the image, as a density over the unit cube. With a map of the image's brightness
/// the light that arrives at each point is divided by the brightness there.
#[derive(Debug)]
pub struct PrimaryTarget<E> {
    brightness: Option<Arc<BrightnessMap>>,
    estimator: PhantomData<fn() -> E>,
}

impl<E> PrimaryTarget<E> {
    /// The luminance, over `brightness` if there is a map of it.
    pub fn new(brightness: Option<Arc<BrightnessMap>>) -> Self {
        Self { brightness, estimator: PhantomData }
    }
}

impl<E> Default for PrimaryTarget<E> {
    fn default() -> Self {
        Self::new(None)
    }
}

impl<E> Clone for PrimaryTarget<E> {
    fn clone(&self) -> Self {
        Self::new(self.brightness.clone())
    }
}

impl<E: Estimator> PrimaryTarget<E> {
    /// Its value.
    pub(crate) fn of(&self, x: &PrimarySample<E>) -> f64 {
        match &self.brightness {
            None => x.luminance(),
            Some(_) => x.splats().iter().map(|(raster, color)| self.of_light(*raster, luminance(*color))).sum(),
        }
    }

    /// What light of a luminance that arrives at one point of the image adds to it.
    pub(crate) fn of_light(&self, raster: DVec2, luminance: f64) -> f64 {
        BrightnessMap::relative(self.brightness.as_deref(), luminance, raster)
    }
}

/// What one evaluation of [`PrimaryTarget`] yields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrimaryValue {
    /// The target.
    pub target: Density,
}

impl<E: Estimator> Target for PrimaryTarget<E> {
    type State = PrimarySample<E>;
    type Value = PrimaryValue;

    fn evaluate(&self, x: &PrimarySample<E>) -> PrimaryValue {
        PrimaryValue { target: Density::new(self.of(x)) }
    }

    fn ln_density(value: &PrimaryValue) -> f64 {
        value.target.ln()
    }

    fn density(value: &PrimaryValue) -> Density {
        value.target
    }
}
