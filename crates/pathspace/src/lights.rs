//! Which light, and where on it: the emitters of a scene and the density of choosing among them.

use ergodic_metropolis::RandomSource;
use ergodic_scattering::{PunctualLight, luminance};

/// One thing that emits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Emitter {
    /// A triangle of an emissive instance.
    Triangle {
        /// Instance in the world.
        instance: u32,
        /// Triangle of its mesh.
        triangle: u32,
    },
    /// A punctual light, by index.
    Punctual(u32),
}

/// Emitters chosen with probability proportional to their power.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lights {
    emitters: Vec<Emitter>,
    /// Upper ends of the emitters' shares of [0, 1].
    cumulative: Vec<f64>,
    /// Probability of each emitter.
    probability: Vec<f64>,
    /// Emitters below this index are triangles; their areas.
    areas: Vec<f64>,
    /// The punctual lights in the scene's own space.
    pub(crate) punctual: Vec<PunctualLight>,
}

impl Lights {
    /// From triangles `(emitter, area, power)` and punctual lights.
    pub(crate) fn new(triangles: Vec<(Emitter, f64, f64)>, punctual: Vec<PunctualLight>, radius: f64) -> Self {
        let mut lights = Self { punctual, ..Self::default() };
        let mut powers = Vec::new();
        for (emitter, area, power) in triangles {
            lights.emitters.push(emitter);
            lights.areas.push(area);
            powers.push(power);
        }
        for (index, light) in lights.punctual.iter().enumerate() {
            lights.emitters.push(Emitter::Punctual(index as u32));
            powers.push(luminance(light.power(radius)));
        }
        let total: f64 = powers.iter().sum();
        let mut sum = 0.0;
        for power in powers {
            sum += power;
            lights.cumulative.push(sum / total);
            lights.probability.push(power / total);
        }
        lights
    }

    /// Whether nothing emits.
    pub(crate) fn is_empty(&self) -> bool {
        self.cumulative.last().is_none_or(|total| !total.is_finite())
    }

    /// A light with the probability of [`Self::triangle_pdf_area`] (times area) or [`Self::punctual_probability`].
    #[inline]
    pub(crate) fn choose(&self, rng: &mut impl RandomSource) -> Emitter {
        let u = rng.uniform();
        let index = self.cumulative.partition_point(|&end| end <= u).min(self.emitters.len() - 1);
        self.emitters[index]
    }

    /// Area density of a point on emissive triangle `emitter` when a light is chosen and a point on it, uniformly.
    #[inline]
    pub(crate) fn triangle_pdf_area(&self, emitter: u32) -> f64 {
        self.probability[emitter as usize] / self.areas[emitter as usize]
    }

    /// The probability of punctual light `index`.
    #[inline]
    pub(crate) fn punctual_probability(&self, index: u32) -> f64 {
        self.probability[self.areas.len() + index as usize]
    }
}
