//! What chains of primary samples start from.

use ergodic_metropolis::RandomSource;
use ergodic_pathspace::stability::{Place, is_usable};
use ergodic_pathspace::{PathClass, Scene};
use ergodic_scattering::{Repertoire, luminance};
use glam::DVec2;

use super::coordinates::{PrimarySample, STRATEGY};
use super::multiplexed::Multiplexed;
use super::mutation::PrimaryTarget;
use crate::Estimator;
use crate::bidirectional::BidirectionalPathTracer;
use crate::path_tracer::PathTracer;
use crate::seeding::{Draw, Weighed};
use crate::starts::Strategy;

/// An estimator whose samples chains can start from.
pub trait Seedable: Estimator {
    /// Makes `sample` one that a chain can start from, out of numbers of `rng`, and tells its weight: such that a sample chosen in
    /// proportion to the weight has the density of the target, and that the mean weight is the target's integral.
    fn seed(
        sample: &mut PrimarySample<Self>,
        scene: &Scene<Self::Repertoire>,
        target: &PrimaryTarget<Self>,
        rng: &mut impl RandomSource,
    ) -> Weighed {
        sample.draw(scene, rng);
        let (luminance, weight) = (sample.luminance(), target.of(sample));
        let (class, raster) = (sample.class(), sample.brightest());
        Weighed { luminance, weight, class, raster, strategy: Strategy::default() }
    }
}

impl<R: Repertoire> Seedable for PathTracer<R> {}

impl<R: Repertoire> Seedable for BidirectionalPathTracer<R> {}

/// How far from the edges of its cell the coordinate that chooses a strategy begins, in cells: farther than rounding takes it.
const INSIDE: f64 = 1e-9;

impl<R: Repertoire> Seedable for Multiplexed<R> {
    /// A single strategy hardly ever makes a path as often as it is bright: their sum over one pair of walks is a far better sample of
    /// b, and one of them, chosen in proportion to the target, a far better start.
    fn seed(
        sample: &mut PrimarySample<Self>,
        scene: &Scene<R>,
        target: &PrimaryTarget<Self>,
        rng: &mut impl RandomSource,
    ) -> Weighed {
        let (mut draw, within) = (Draw::new(rng.uniform()), rng.uniform().clamp(INSIDE, 1.0 - INSIDE));
        let (mut luminances, mut strategy) = (0.0, 0.0);
        sample.draw_by(rng, |estimator, asked| {
            estimator.all_strategies(scene, asked, |(k, share), s, connection| {
                let color = connection.contribution();
                if !is_usable(Place::Connection, color) {
                    return;
                }
                let light = luminance(color) / share;
                luminances += light;
                if draw.offer(target.of_light(connection.raster, light)) {
                    strategy = (s as f64 + within) / (k + 1) as f64;
                }
            });
        });
        let (luminance, weight, class, raster) = (luminances, draw.sum, PathClass::MANY, DVec2::ZERO);
        let mut found = Weighed { luminance, weight, class, raster, strategy: Strategy::default() };
        if found.weight > 0.0 {
            let drawn = sample.coordinates.clone();
            sample.evaluate(scene, |index| match drawn.get(index) {
                _ if index == STRATEGY => strategy,
                Some(value) => value,
                None => rng.uniform(),
            });
            (found.class, found.raster) = (sample.class(), sample.brightest());
        }
        found
    }
}
