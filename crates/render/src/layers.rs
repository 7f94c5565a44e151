//! What the chains did, pixel by pixel: acceptance, longest stay, and the standard error of the picture.
//!
//! As with the film there is one set of sums, merged band by band from small buffers. The standard error needs the luminance of
//! every pixel by independent parts of the chains; large pictures have fewer parts, so that they stay within a gibibyte.

use ergodic_metropolis::diagnostics::Moments;
use ergodic_scattering::{Filter, luminance};
use glam::DVec2;
use rayon::prelude::*;

use crate::bins::Bins;
use crate::chain_runner::Ledger;
use crate::grid::Grid;

/// Bytes that the luminances of all parts take at most, unless there are [`MIN_PARTS`] only.
const PART_BYTES: usize = 1 << 30;
/// The greatest number of parts; the standard error is then known to 1 / sqrt(2 · 63) = 9 %.
const MAX_PARTS: usize = 64;
/// The least number of parts; the standard error is then known to 1 / sqrt(2 · 3) = 41 %.
const MIN_PARTS: usize = 4;

/// Independent parts of the chains that the standard error of a picture of `pixels` pixels comes from: 64 up to 2 million
/// pixels, 16 at 3840 x 2160, never less than 4.
pub(crate) fn parts(pixels: usize) -> usize {
    (PART_BYTES / (size_of::<f64>() * pixels)).clamp(MIN_PARTS, MAX_PARTS)
}

/// Memory that a pixel takes in the sums of `parts` parts and in the finished layers, in bytes.
pub(crate) fn bytes_per_pixel(parts: usize) -> usize {
    size_of::<Count>() + parts * size_of::<f64>() + 3 * size_of::<f64>()
}

/// A time that a chain spent at one pixel.
#[derive(Clone, Copy, Debug)]
struct Visit {
    pixel: u32,
    /// Proposals from there.
    proposed: u32,
    /// Sum of their acceptance probabilities.
    acceptance: f64,
    /// Longest stay there in steps.
    stay: u64,
}

/// Visits on their way to the sums. Of fixed size: 2048 visits, 24 bytes each, and their order.
#[derive(Clone, Debug)]
pub struct VisitBuffer {
    grid: Grid,
    visits: Bins<Visit>,
}

impl VisitBuffer {
    /// An empty buffer for a picture of the given size.
    pub(crate) fn new((width, height): (u32, u32)) -> Self {
        Self { grid: Grid::new(width, height, Filter::Box), visits: Bins::new() }
    }

    /// How many visits still fit.
    pub(crate) fn room(&self) -> usize {
        self.visits.room()
    }

    /// Bytes of a buffer that holds `visits` visits at most.
    pub(crate) fn bytes(visits: usize, grid: &Grid) -> usize {
        Bins::<Visit>::bytes(visits, grid.bands())
    }

    /// The visit under way at this image point: the last one, or a new one.
    #[inline]
    fn at(&mut self, raster: DVec2) -> Option<&mut Visit> {
        let pixel = self.grid.pixel(raster)? as u32;
        if self.visits.last_mut().is_none_or(|last| last.pixel != pixel) {
            self.visits.push(Visit { pixel, proposed: 0, acceptance: 0.0, stay: 0 });
        }
        self.visits.last_mut()
    }

    /// A proposal from a path at this image point.
    #[inline]
    pub(crate) fn proposed(&mut self, raster: DVec2, acceptance: f64) {
        if let Some(visit) = self.at(raster) {
            visit.proposed += 1;
            visit.acceptance += acceptance;
        }
    }

    /// A stay at a path at this image point.
    #[inline]
    pub(crate) fn stayed(&mut self, raster: DVec2, steps: u64) {
        if let Some(visit) = self.at(raster) {
            visit.stay = visit.stay.max(steps);
        }
    }
}

/// Sums of all visits to a pixel.
#[derive(Clone, Copy, Debug, Default)]
struct Count {
    proposed: u64,
    acceptance: f64,
    longest_stay: u64,
}

impl Count {
    #[inline]
    fn add(&mut self, visit: &Visit) {
        self.proposed += u64::from(visit.proposed);
        self.acceptance += visit.acceptance;
        self.longest_stay = self.longest_stay.max(visit.stay);
    }
}

/// The sums that layers are made of.
#[derive(Clone, Debug)]
pub(crate) struct LayerSums {
    /// With the picture's filter, for luminances.
    grid: Grid,
    counts: Vec<Count>,
    parts: usize,
    /// Luminance of the splats of every part, for all parts of a pixel together.
    luminances: Vec<f64>,
}

impl LayerSums {
    /// Sums of `parts` parts.
    pub(crate) fn new((width, height): (u32, u32), filter: Filter, parts: usize) -> Self {
        let grid = Grid::new(width, height, filter);
        let luminances = vec![0.0; parts * grid.pixels()];
        Self { grid, counts: vec![Count::default(); grid.pixels()], parts, luminances }
    }

    /// Number of parts.
    pub(crate) fn parts(&self) -> usize {
        self.parts
    }

    /// Adds the visits and splats of all ledgers and forgets the visits. Ledger i belongs to part i modulo their number.
    pub(crate) fn merge(&mut self, ledgers: &mut [&mut Ledger]) {
        let (grid, parts) = (self.grid, self.parts);
        ledgers.par_iter_mut().for_each(|ledger| {
            ledger.splats.sort(&grid);
            if let Some(visits) = &mut ledger.visits {
                visits.visits.sort(grid.bands(), |visit| {
                    let band = grid.band_of_pixel(visit.pixel);
                    band..band + 1
                });
            }
        });
        let sorted: &[&mut Ledger] = ledgers;
        let bands = self.counts.par_chunks_mut(grid.band_pixels());
        let luminances = self.luminances.par_chunks_mut(parts * grid.band_pixels());
        bands.zip(luminances).enumerate().for_each(|(band, (counts, luminances))| {
            let (first, rows) = (band * grid.band_pixels(), grid.band_rows(band));
            for (index, ledger) in sorted.iter().enumerate() {
                for visit in ledger.visits.iter().flat_map(|visits| visits.visits.of_band(band)) {
                    counts[visit.pixel as usize - first].add(visit);
                }
                for splat in ledger.splats.of_band(band) {
                    grid.spread(splat.raster, splat.color, rows.clone(), |pixel, color| {
                        luminances[(pixel - first) * parts + index % parts] += luminance(color);
                    });
                }
            }
        });
        ledgers.iter_mut().flat_map(|ledger| &mut ledger.visits).for_each(|visits| visits.visits.clear());
    }

    /// The layers; `scales` has for each part the factor that makes its sum an estimate of the picture.
    pub(crate) fn finish(&self, scales: &[f64]) -> Layers {
        let error = |luminances: &[f64]| {
            let values: Moments = luminances.iter().zip(scales).map(|(sum, scale)| sum * scale).collect();
            values.standard_error()
        };
        let acceptance = |c: &Count| if c.proposed > 0 { c.acceptance / c.proposed as f64 } else { 0.0 };
        Layers {
            acceptance: self.counts.iter().map(acceptance).collect(),
            standard_error: self.luminances.par_chunks(self.parts).map(error).collect(),
            longest_stay: self.counts.iter().map(|c| c.longest_stay as f64).collect(),
        }
    }
}

/// Numbers for each pixel, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Mean acceptance probability of proposals from paths at the pixel; 0 where there were none.
    pub acceptance: Vec<f64>,
    /// Standard error of the pixel's luminance, from the spread between independent parts of the chains. It leaves out the
    /// error of b, which is the same for all pixels. There are 64 parts in pictures of up to 2 million pixels and fewer in
    /// larger ones, 16 at 3840 x 2160, but at least 4, as far as there are chains; from n parts it is known to
    /// 1 / sqrt(2 (n - 1)) of itself.
    pub standard_error: Vec<f64>,
    /// Longest stay in steps at a path at the pixel.
    pub longest_stay: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use ergodic_metropolis::RandomSource;

    use super::*;
    use crate::{Film, Purpose, SplatBuffer, stream};

    const SIZE: (u32, u32) = (9, 120);
    const PARTS: usize = 3;

    /// The step of a chain at pixel centres: where it was, its acceptance probability, and how long it had been there.
    fn steps(ledger: u64) -> Vec<(DVec2, f64, u64)> {
        let mut rng = stream(3, Purpose::Chain, ledger);
        let mut at = DVec2::splat(0.5);
        let mut step = |_| {
            if rng.uniform() < 0.4 {
                at = (DVec2::new(rng.uniform() * 9.0, rng.uniform() * 120.0)).floor() + 0.5;
            }
            (at, rng.uniform(), (rng.uniform() * 50.0) as u64)
        };
        (0..2500).map(&mut step).collect()
    }

    #[test]
    fn merged_visits_are_those_counted_one_by_one() {
        let mut ledgers: Vec<Ledger> = (0..5)
            .map(|_| Ledger {
                splats: SplatBuffer::new(),
                mutations: Vec::new(),
                faults: Vec::new(),
                none_suitable: 0,
                visits: Some(VisitBuffer::new(SIZE)),
            })
            .collect();
        let mut sums = LayerSums::new(SIZE, Filter::Box, PARTS);
        let mut expected = vec![(0u64, 0.0, 0u64, [0.0; PARTS]); 9 * 120];
        for round in 0..3 {
            for (index, ledger) in ledgers.iter_mut().enumerate() {
                for (at, acceptance, stay) in steps(index as u64 + 100 * round) {
                    let visits = ledger.visits.as_mut().unwrap();
                    visits.stayed(at, stay);
                    visits.proposed(at, acceptance);
                    ledger.splats.splat(at, DVec2::splat(acceptance).extend(acceptance));
                    let pixel = &mut expected[at.y as usize * 9 + at.x as usize];
                    pixel.0 += 1;
                    pixel.1 += acceptance;
                    pixel.2 = pixel.2.max(stay);
                    pixel.3[index % PARTS] += acceptance;
                }
                let room = ledger.visits.as_ref().unwrap().room();
                assert!(crate::bins::CAPACITY - room < 1500, "{room}: steps at one pixel are one visit");
            }
            sums.merge(&mut ledgers.iter_mut().collect::<Vec<_>>());
            // The film takes the splats.
            Film::new(SIZE.0, SIZE.1, Filter::Box)
                .merge(&mut ledgers.iter_mut().map(|l| &mut l.splats).collect::<Vec<_>>());
        }
        let scales = [2.0, 3.0, 5.0];
        let layers = sums.finish(&scales);
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs();
        let mut swapped = 0;
        for (i, (proposed, acceptance, stay, luminances)) in expected.into_iter().enumerate() {
            assert!(proposed > 0 && close(layers.acceptance[i], acceptance / proposed as f64));
            assert_eq!(layers.longest_stay[i], stay as f64);
            let error = |scales: [f64; PARTS]| {
                let values: Moments = luminances.iter().zip(scales).map(|(l, scale)| l * scale).collect();
                values.standard_error()
            };
            assert!((layers.standard_error[i] - error(scales)).abs() < 1e-9 * error(scales).max(1.0));
            swapped += usize::from((layers.standard_error[i] - error([3.0, 2.0, 5.0])).abs() > 1e-3);
        }
        // Parts taken one for another would be seen.
        assert!(swapped > 500, "{swapped}");
    }

    #[test]
    fn large_pictures_have_fewer_parts() {
        let sizes = [256 * 256, 1920 * 1080, 3840 * 2160, 7680 * 4320, 1 << 28];
        assert_eq!(sizes.map(parts), [64, 64, 16, 4, 4]);
    }
}
