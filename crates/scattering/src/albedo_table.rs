//! Directional albedos of lobes as tables over cosine and roughness.
//!
//! A layer takes from what is below it the share of the light that it reflects itself, so that no energy is made; that
//! share has no closed form. Tables are integrated once, when a scene first has the lobe.

/// Entries along the cosine.
const COSINES: usize = 96;
/// Entries along the roughness.
const ROUGHNESSES: usize = 32;

/// A table of `N` albedos, or other numbers, at each place. Entries are dense near grazing directions and small
/// roughnesses: both coordinates run as square roots.
pub(crate) struct AlbedoTable<const N: usize> {
    least_roughness: f64,
    values: Vec<[f32; N]>,
}

impl<const N: usize> AlbedoTable<N> {
    /// The table of `albedos(cosine, roughness)` for all cosines and for roughnesses from the least one to 1.
    pub(crate) fn new(least_roughness: f64, albedos: impl Fn(f64, f64) -> [f64; N]) -> Self {
        let values = (0..COSINES * ROUGHNESSES).map(|i| {
            let x = (i % COSINES) as f64 / (COSINES - 1) as f64;
            let y = (i / COSINES) as f64 / (ROUGHNESSES - 1) as f64;
            albedos(x * x, least_roughness + (1.0 - least_roughness) * y * y).map(|value| value as f32)
        });
        Self { least_roughness, values: values.collect() }
    }

    /// The table of the largest albedos from each cosine on: they never rise with the cosine.
    pub(crate) fn falling(mut self) -> Self {
        for row in self.values.chunks_mut(COSINES) {
            for i in (1..COSINES).rev() {
                row[i - 1] = std::array::from_fn(|k| row[i - 1][k].max(row[i][k]));
            }
        }
        self
    }

    /// The albedos, linear between entries. What lies outside the table reads as its edge.
    #[inline]
    pub(crate) fn at(&self, cos: f64, roughness: f64) -> [f64; N] {
        let x = cos.clamp(0.0, 1.0).sqrt();
        let y = ((roughness - self.least_roughness) / (1.0 - self.least_roughness)).clamp(0.0, 1.0).sqrt();
        let (x, y) = (x * (COSINES - 1) as f64, y * (ROUGHNESSES - 1) as f64);
        let (i, j) = ((x as usize).min(COSINES - 2), (y as usize).min(ROUGHNESSES - 2));
        let (fx, fy) = (x - i as f64, y - j as f64);
        let row = |j: usize| {
            let entries = &self.values[j * COSINES + i..j * COSINES + i + 2];
            std::array::from_fn::<f64, N, _>(|k| f64::from(entries[0][k]) * (1.0 - fx) + f64::from(entries[1][k]) * fx)
        };
        let (low, high) = (row(j), row(j + 1));
        std::array::from_fn(|k| low[k] * (1.0 - fy) + high[k] * fy)
    }
}
