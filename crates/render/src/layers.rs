//! What the chains did, pixel by pixel: acceptance, longest stay, and the standard error of the picture.

use ergodic_metropolis::diagnostics::Moments;
use ergodic_scattering::luminance;
use glam::DVec2;

use crate::Film;

/// Counts for each pixel that paths were at.
#[derive(Clone, Debug)]
pub struct PixelCounts {
    width: u32,
    height: u32,
    pixels: Vec<Count>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Count {
    proposed: u64,
    acceptance: f64,
    longest_stay: u64,
}

impl PixelCounts {
    pub(crate) fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![Count::default(); width as usize * height as usize] }
    }

    #[inline]
    fn at(&mut self, raster: DVec2) -> Option<&mut Count> {
        let (x, y) = (raster.x.floor(), raster.y.floor());
        let inside = x >= 0.0 && y >= 0.0 && x < f64::from(self.width) && y < f64::from(self.height);
        inside.then(|| &mut self.pixels[y as usize * self.width as usize + x as usize])
    }

    /// A proposal from a path at this image point.
    #[inline]
    pub(crate) fn proposed(&mut self, raster: DVec2, acceptance: f64) {
        if let Some(count) = self.at(raster) {
            count.proposed += 1;
            count.acceptance += acceptance;
        }
    }

    /// A stay at a path at this image point.
    #[inline]
    pub(crate) fn stayed(&mut self, raster: DVec2, steps: u64) {
        if let Some(count) = self.at(raster) {
            count.longest_stay = count.longest_stay.max(steps);
        }
    }

    fn add(&mut self, other: &Self) {
        for (sum, more) in self.pixels.iter_mut().zip(&other.pixels) {
            sum.proposed += more.proposed;
            sum.acceptance += more.acceptance;
            sum.longest_stay = sum.longest_stay.max(more.longest_stay);
        }
    }
}

/// Numbers for each pixel, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Mean acceptance probability of proposals from paths at the pixel; 0 where there were none.
    pub acceptance: Vec<f64>,
    /// Standard error of the pixel's luminance, from the spread between independent parts of the chains. It leaves out the
    /// error of b, which is the same for all pixels.
    pub standard_error: Vec<f64>,
    /// Longest stay in steps at a path at the pixel.
    pub longest_stay: Vec<f64>,
}

/// Puts the layers together from parts of the chains: their counts, their films, and the factor that makes each film an
/// estimate of the picture.
pub(crate) fn put_together(parts: &[(&PixelCounts, &Film, f64)]) -> Option<Layers> {
    let (first, ..) = parts.first()?;
    let mut counts = PixelCounts::new(first.width, first.height);
    for (part, ..) in parts {
        counts.add(part);
    }
    let pictures: Vec<_> = parts.iter().map(|(_, film, scale)| film.develop(*scale)).collect();
    let error = |i: usize| {
        let values: Moments = pictures.iter().map(|picture| luminance(picture.pixels[i])).collect();
        (values.variance() / values.count() as f64).sqrt()
    };
    let acceptance = |c: &Count| if c.proposed > 0 { c.acceptance / c.proposed as f64 } else { 0.0 };
    Some(Layers {
        acceptance: counts.pixels.iter().map(acceptance).collect(),
        standard_error: (0..counts.pixels.len()).map(error).collect(),
        longest_stay: counts.pixels.iter().map(|c| c.longest_stay as f64).collect(),
    })
}
