//! Which light, and where on it: the emitters of a scene and the density of choosing among them.

use ergodic_metropolis::RandomSource;
use ergodic_scattering::{AliasTable, PunctualLight, luminance};

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
    /// The environment.
    Environment,
}

/// Emitters chosen with probability proportional to their power, in time that does not depend on their number.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lights {
    /// Those with any power.
    emitters: Vec<Emitter>,
    choice: AliasTable,
    /// Probability of each emitter.
    probability: Vec<f64>,
    /// Emitters below this index are triangles; their areas.
    areas: Vec<f64>,
    /// The punctual lights in the scene's own space.
    pub(crate) punctual: Vec<PunctualLight>,
}

impl Lights {
    /// From triangles `(emitter, area, power)`, punctual lights, and the environment's power if there is one.
    pub(crate) fn new(
        triangles: Vec<(Emitter, f64, f64)>,
        punctual: Vec<PunctualLight>,
        environment: Option<f64>,
        radius: f64,
    ) -> Self {
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
        if let Some(power) = environment {
            lights.emitters.push(Emitter::Environment);
            powers.push(power);
        }
        // What has no power is left out, so that the same numbers choose the same lights whether or not it is there.
        let lit: Vec<usize> = (0..powers.len()).filter(|&i| powers[i] != 0.0).collect();
        lights.choice = AliasTable::new(&lit.iter().map(|&i| powers[i]).collect::<Vec<_>>());
        lights.emitters = lit.iter().map(|&i| lights.emitters[i]).collect();
        lights.probability = powers.iter().map(|power| power / lights.choice.total()).collect();
        lights
    }

    /// Whether nothing emits.
    pub(crate) fn is_empty(&self) -> bool {
        self.choice.is_empty()
    }

    /// A light with the probability of [`Self::triangle_pdf_area`] (times area), [`Self::punctual_probability`] or
    /// [`Self::environment_probability`].
    #[inline]
    pub(crate) fn choose(&self, rng: &mut impl RandomSource) -> Emitter {
        self.emitters[self.choice.choose(rng.uniform()).0]
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

    /// The probability of the environment; 0 if there is none.
    #[inline]
    pub(crate) fn environment_probability(&self) -> f64 {
        self.probability.get(self.areas.len() + self.punctual.len()).copied().unwrap_or(0.0)
    }
}
