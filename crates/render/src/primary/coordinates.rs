//! A point of primary sample space and the sample that an estimator makes of it.

use ergodic_metropolis::RandomSource;
use ergodic_pathspace::stability::{Place, is_usable};
use ergodic_pathspace::{PathClass, Scene};
use ergodic_scattering::{Rgb, luminance};
use glam::DVec2;

use crate::Estimator;

/// Walks that are told apart.
pub(crate) const WALKS: usize = 3;

/// The walk of choices that small steps leave alone at place 0.
pub(crate) const CHOICES: usize = 2;

/// Coordinates that a place of a walk has to itself. What it asks for beyond goes to a list for all places: only a walk through
/// very many surfaces that are partly there does.
const SLOTS: usize = 8;

/// A coordinate that the sample has not asked for.
const UNUSED: f64 = f64::NAN;

/// The coordinates of a point, as far as the sample has asked for them.
///
/// The cube has no end of dimensions; a sample depends on few of them, and the others are uniform whatever the chain does. So they
/// are not kept: a coordinate that is asked for and was not in use before is drawn uniformly, which is a step of its own that leaves
/// the target as it is. Kelemen et al. (2002, section 4) perturb such coordinates later, as often as they were passed over; the
/// distribution is the same.
#[derive(Clone, Debug, Default)]
pub struct Coordinates {
    walks: [Vec<f64>; WALKS],
    beyond: Vec<f64>,
}

/// The coordinate of multiplexed sampling that chooses the strategy.
pub(crate) const STRATEGY: Index = Index { walk: CHOICES, number: SLOTS };

/// Which coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Index {
    /// The walk; [`WALKS`] for the list beyond.
    walk: usize,
    number: usize,
}

impl Index {
    /// Whether small steps keep it.
    pub(crate) fn is_kept(self) -> bool {
        self.walk == CHOICES && self.number < SLOTS
    }
}

impl Coordinates {
    /// Bytes of the coordinates of samples of at most `max_edges` edges.
    pub(crate) const fn bytes(max_edges: usize) -> usize {
        // Vectors that grow hold twice what they need at most.
        2 * size_of::<f64>() * SLOTS * WALKS * (max_edges + 1)
    }

    fn list(&self, walk: usize) -> &Vec<f64> {
        self.walks.get(walk).unwrap_or(&self.beyond)
    }

    /// The value, if the sample asked for it.
    #[inline]
    pub(crate) fn get(&self, index: Index) -> Option<f64> {
        self.list(index.walk).get(index.number).copied().filter(|value| !value.is_nan())
    }

    fn set(&mut self, index: Index, value: f64) {
        let list = self.walks.get_mut(index.walk).unwrap_or(&mut self.beyond);
        if list.len() <= index.number {
            list.resize(index.number + 1, UNUSED);
        }
        list[index.number] = value;
    }

    /// All coordinates in use.
    pub(crate) fn used(&self) -> impl Iterator<Item = (Index, f64)> {
        (0..=WALKS).flat_map(move |walk| {
            let values = self.list(walk).iter().enumerate();
            values.filter(|(_, value)| !value.is_nan()).map(move |(number, value)| (Index { walk, number }, *value))
        })
    }

    fn clear(&mut self) {
        self.walks.iter_mut().for_each(|list| list.fill(UNUSED));
        self.beyond.clear();
    }
}

/// Gives a sample its numbers, and writes them down as coordinates.
pub(crate) struct Asked<'a, F> {
    point: &'a mut Coordinates,
    /// The value of a coordinate that is asked for.
    value: F,
    walk: usize,
    first: usize,
    given: usize,
}

impl<F: FnMut(Index) -> f64> RandomSource for Asked<'_, F> {
    #[inline]
    fn uniform(&mut self) -> f64 {
        let index = if self.given < SLOTS {
            Index { walk: self.walk, number: self.first + self.given }
        } else {
            Index { walk: WALKS, number: self.point.beyond.len() }
        };
        self.given += 1;
        let value = (self.value)(index);
        self.point.set(index, value);
        value
    }

    #[inline]
    fn enter(&mut self, walk: usize, index: usize) {
        (self.walk, self.first, self.given) = (walk.min(WALKS - 1), index * SLOTS, 0);
    }
}

/// A point and what an estimator makes of it: a state of a chain.
#[derive(Clone, Debug)]
pub struct PrimarySample<E> {
    /// The point.
    pub coordinates: Coordinates,
    estimator: E,
    splats: Vec<(DVec2, Rgb)>,
    luminance: f64,
}

impl<E: Estimator> PrimarySample<E> {
    /// The sample of no point; it carries nothing.
    pub fn new(estimator: E) -> Self {
        Self { coordinates: Coordinates::default(), estimator, splats: Vec::new(), luminance: 0.0 }
    }

    /// Makes this the sample of a point drawn uniformly.
    pub fn draw(&mut self, scene: &Scene<E::Repertoire>, rng: &mut impl RandomSource) {
        self.evaluate(scene, |_| rng.uniform());
    }

    /// Lets `work` do with the estimator what it likes by numbers of `rng`, which become the coordinates of the point.
    pub(crate) fn draw_by<T>(
        &mut self,
        rng: &mut impl RandomSource,
        work: impl FnOnce(&mut E, &mut Asked<'_, &mut dyn FnMut(Index) -> f64>) -> T,
    ) -> T {
        self.coordinates.clear();
        let mut value = |_| rng.uniform();
        let (point, value) = (&mut self.coordinates, &mut value as &mut dyn FnMut(Index) -> f64);
        work(&mut self.estimator, &mut Asked { point, value, walk: 0, first: 0, given: 0 })
    }

    /// Makes this the sample of the point whose coordinates `value` gives where they are asked for.
    pub(crate) fn evaluate(&mut self, scene: &Scene<E::Repertoire>, value: impl FnMut(Index) -> f64) {
        let Self { coordinates, estimator, splats, luminance: total } = self;
        coordinates.clear();
        splats.clear();
        *total = 0.0;
        let mut asked = Asked { point: coordinates, value, walk: 0, first: 0, given: 0 };
        estimator.sample(scene, &mut asked, |raster, color| {
            if is_usable(Place::Connection, color) && color.max_element() > 0.0 {
                splats.push((raster, color));
                *total += luminance(color);
            }
        });
    }

    /// The target: the luminance of all light that the sample brings to the image.
    pub fn luminance(&self) -> f64 {
        self.luminance
    }

    /// What it brings to which point of the image.
    pub fn splats(&self) -> &[(DVec2, Rgb)] {
        &self.splats
    }

    /// The class of the sample's path, [`PathClass::MANY`] if it is more than one.
    pub fn class(&self) -> PathClass {
        self.estimator.class()
    }

    /// Where most of its light arrives; the corner of the image if there is none.
    pub(crate) fn brightest(&self) -> DVec2 {
        let brightest = self.splats.iter().max_by(|a, b| luminance(a.1).total_cmp(&luminance(b.1)));
        brightest.map_or(DVec2::ZERO, |(raster, _)| *raster)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_keep_their_places_when_another_walk_gets_longer() {
        let ask = |lengths: [usize; 2]| {
            let mut point = Coordinates::default();
            let mut next = 0.0;
            let value = |_| {
                next += 1e-3;
                next
            };
            let mut asked = Asked { point: &mut point, value, walk: 0, first: 0, given: 0 };
            for (walk, length) in lengths.into_iter().enumerate() {
                for place in 0..length {
                    asked.enter(walk, place);
                    (0..3).for_each(|_| _ = asked.uniform());
                }
            }
            point
        };
        let (short, long) = (ask([2, 3]), ask([5, 3]));
        let of_walk = |point: &Coordinates, walk| point.used().filter(|(index, _)| index.walk == walk).count();
        assert_eq!((of_walk(&short, 0), of_walk(&short, 1)), (6, 9));
        assert_eq!((of_walk(&long, 0), of_walk(&long, 1)), (15, 9));
        for (index, _) in short.used() {
            assert!(long.get(index).is_some());
        }
    }

    #[test]
    fn what_a_place_asks_for_beyond_its_slots_is_kept_too() {
        let mut point = Coordinates::default();
        let mut asked = Asked { point: &mut point, value: |_| 0.5, walk: 0, first: 0, given: 0 };
        asked.enter(1, 4);
        (0..SLOTS + 5).for_each(|_| _ = asked.uniform());
        assert_eq!(point.used().count(), SLOTS + 5);
        assert_eq!(point.beyond.len(), 5);
    }
}
