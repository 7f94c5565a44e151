//! The first of two stages (Veach and Guibas 1997, two-stage MLT): few bidirectional samples show how bright each part of the image is,
//! before the seeds are drawn. Its samples are used for nothing else, so that what comes after does not depend on them but by the map.

use std::sync::Arc;

use ergodic_pathspace::stability::{Place, is_usable_number};
use ergodic_pathspace::{BidirectionalSampler, BrightnessMap, Lengths, Scene};
use ergodic_scattering::{Repertoire, luminance};
use glam::DVec2;
use rayon::prelude::*;

use crate::Settings;
use crate::counts::{Counts, counted};
use crate::observer::Observer;
use crate::seeding::{CHUNKS, chunk_after};
use crate::streams::{Purpose, stream};

/// Cells along the longer side of the image at most, and pixels along a side of a cell at least.
const MOST_CELLS: u32 = 64;
const PIXELS: u32 = 2;

/// Samples for each cell that are enough, and how few are too few: then cells are joined. The map is smooth, so that it is made of those
/// of nine cells.
const SAMPLES: u64 = 16;
const FEW: u64 = 4;

/// The part of the time for seeding that the first stage may take.
pub(crate) const PART_OF_SEEDING: f64 = 0.25;

/// Light seen directly has no error, and lamps would hide what is around them.
const LEAST_EDGES: usize = 2;

/// Cells of an image, and the luminance in each.
struct Grid {
    columns: usize,
    rows: usize,
    sums: Vec<f64>,
}

impl Grid {
    /// No light yet in cells as small as they may be.
    fn new((width, height): (u32, u32)) -> Self {
        let longer = width.max(height);
        let count = (longer / PIXELS).clamp(1, MOST_CELLS);
        let along = |side: u32| (side * count).div_ceil(longer).max(1) as usize;
        let (columns, rows) = (along(width), along(height));
        Self { columns, rows, sums: vec![0.0; columns * rows] }
    }

    fn add(&mut self, raster: DVec2, size: DVec2, light: f64) {
        let at = raster / size * DVec2::new(self.columns as f64, self.rows as f64);
        let column = (at.x.max(0.0) as usize).min(self.columns - 1);
        let row = (at.y.max(0.0) as usize).min(self.rows - 1);
        self.sums[row * self.columns + column] += light;
    }

    /// Every two by two cells become one, with their mean.
    fn joined(&self) -> Self {
        let (columns, rows) = (self.columns.div_ceil(2), self.rows.div_ceil(2));
        let of = |i: usize| {
            let (left, top) = (i % columns * 2, i / columns * 2);
            let (right, bottom) = ((left + 2).min(self.columns), (top + 2).min(self.rows));
            let sum: f64 =
                (top..bottom).map(|row| self.sums[row * self.columns..][left..right].iter().sum::<f64>()).sum();
            sum / ((right - left) * (bottom - top)) as f64
        };
        Self { columns, rows, sums: (0..columns * rows).map(of).collect() }
    }
}

/// The brightness of the image as far as a few samples of all lengths show it, until there are enough or `observer` wants to stop.
/// `None` if the settings ask for none, or there is no light.
pub(crate) fn brightness<R: Repertoire>(
    scene: &Scene<R>,
    settings: &Settings,
    observer: &dyn Observer,
) -> (Option<Arc<BrightnessMap>>, Counts) {
    let mut counts = Counts::default();
    let lengths = Lengths { min_edges: settings.min_edges.max(LEAST_EDGES), max_edges: settings.max_edges };
    if !settings.mlt.two_stage || lengths.min_edges > lengths.max_edges {
        return (None, counts);
    }
    let (roulette, size) = (settings.roulette.roulette(), scene.camera().size());
    let mut grid = Grid::new(settings.film_size());
    let allowed = (settings.mlt.seeding.max_samples as f64 * PART_OF_SEEDING) as u64;
    let wanted = (SAMPLES * grid.sums.len() as u64).min(allowed);
    let mut samples = 0;
    while samples < wanted && (samples == 0 || !observer.should_stop()) {
        let length = chunk_after(samples);
        let chunks: Vec<(Vec<(DVec2, f64)>, Counts)> = (0..CHUNKS)
            .into_par_iter()
            .map(|chunk| {
                let mut sampler = BidirectionalSampler::new(lengths, roulette);
                let mut splats = Vec::new();
                counted(|| {
                    for index in (samples + chunk * length..).take(length as usize) {
                        let mut rng = stream(settings.seed, Purpose::FirstStage, index);
                        sampler.sample(scene, &mut rng, |_, connection| {
                            let light = luminance(connection.contribution());
                            if is_usable_number(Place::Seed, light) && light > 0.0 {
                                splats.push((connection.raster, light));
                            }
                        });
                    }
                    splats
                })
            })
            .collect();
        for (splats, more) in chunks {
            counts += more;
            splats.into_iter().for_each(|(raster, light)| grid.add(raster, size, light));
        }
        samples += CHUNKS * length;
    }
    while grid.sums.len() > 1 && samples < FEW * grid.sums.len() as u64 {
        grid = grid.joined();
    }
    let map = BrightnessMap::new(size, (grid.columns, grid.rows), &grid.sums);
    (map.map(Arc::new), counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_as_wide_as_tall_and_no_smaller_than_two_pixels() {
        let cells = |size| {
            let grid = Grid::new(size);
            (grid.columns, grid.rows)
        };
        assert_eq!(cells((64, 64)), (32, 32));
        assert_eq!(cells((384, 256)), (64, 43));
        assert_eq!(cells((1, 1)), (1, 1));
        assert_eq!(cells((3, 1000)), (1, 64));
    }

    #[test]
    fn joined_cells_hold_the_mean_also_at_the_edges() {
        let grid = Grid { columns: 3, rows: 3, sums: vec![1.0, 3.0, 10.0, 5.0, 7.0, 20.0, 2.0, 4.0, 9.0] };
        let joined = grid.joined();
        assert_eq!((joined.columns, joined.rows), (2, 2));
        assert_eq!(joined.sums, [4.0, 15.0, 3.0, 9.0]);
        let one = joined.joined();
        assert_eq!(one.sums, [7.75]);
    }

    #[test]
    fn light_outside_the_image_counts_at_its_edge() {
        let mut grid = Grid::new((8, 4));
        for raster in [DVec2::new(-1.0, 0.5), DVec2::new(0.5, 0.5), DVec2::new(9.0, 5.0)] {
            grid.add(raster, DVec2::new(8.0, 4.0), 1.0);
        }
        assert_eq!(grid.sums, [2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    }
}
