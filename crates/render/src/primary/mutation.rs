//! Large and small steps through primary sample space.

use std::convert::Infallible;
use std::marker::PhantomData;

use ergodic_metropolis::unit_cube::SmallStep;
use ergodic_metropolis::{Density, Mutation, RandomSource, Target};
use ergodic_pathspace::Scene;
use ergodic_scattering::{Everything, Repertoire};

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

/// The target: the luminance of what a sample brings to the image, as a density over the unit cube.
#[derive(Clone, Copy, Debug)]
pub struct PrimaryTarget<E>(PhantomData<E>);

impl<E> Default for PrimaryTarget<E> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

/// What one evaluation of [`PrimaryTarget`] yields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrimaryValue {
    /// The luminance.
    pub luminance: Density,
}

impl<E: Estimator> Target for PrimaryTarget<E> {
    type State = PrimarySample<E>;
    type Value = PrimaryValue;

    fn evaluate(&self, x: &PrimarySample<E>) -> PrimaryValue {
        PrimaryValue { luminance: Density::new(x.luminance()) }
    }

    fn ln_density(value: &PrimaryValue) -> f64 {
        value.luminance.ln()
    }

    fn density(value: &PrimaryValue) -> Density {
        value.luminance
    }
}
