//! How bright each part of the image is, as far as a first stage of few samples can tell.
//!
//! Chains whose target is the luminance of f visit a part of the image as often as it is bright, so that dark parts have the larger
//! relative error. Divided by the brightness of where a path arrives, the target is nearly as large everywhere, and so is the
//! relative error (two-stage MLT; Veach and Guibas 1997). What a visit adds to the image is multiplied by the same number, so that any
//! map with positive values gives the same picture on average: a wrong one costs time only.

use glam::DVec2;

/// Brighter than so many times the mean counts as that bright: cells hold lamps or caustics smaller than they are, and what else lies in
/// them must not be neglected for it.
const BRIGHTEST: f64 = 8.0;

/// Added to the brightness, in means: no part is so dark that it gets more than this lets it have.
const FLOOR: f64 = 0.5;

/// Relative brightness over the image, between the centres of its cells by bilinear interpolation.
#[derive(Clone, Debug, PartialEq)]
pub struct BrightnessMap {
    /// Cells from left to right, and from top to bottom.
    cells: (usize, usize),
    /// Cells a pixel.
    scale: DVec2,
    /// Top row first.
    values: Vec<f64>,
}

impl BrightnessMap {
    /// Of an image of `size` pixels, cut into `cells` columns and rows, in which `luminances` were measured, top row first; in any unit.
    /// `None` if there is no light in it, or what is no number.
    ///
    /// A value of the map is that of its cell and the cells around it in units of the mean, 8 at most, and a half.
    pub fn new(size: DVec2, cells: (usize, usize), luminances: &[f64]) -> Option<Self> {
        let (columns, rows) = cells;
        if luminances.len() != columns * rows {
            return None;
        }
        let mean = luminances.iter().sum::<f64>() / luminances.len() as f64;
        if !(mean > 0.0 && mean.is_finite()) || luminances.iter().any(|luminance| *luminance < 0.0) {
            return None;
        }
        let capped: Vec<f64> = luminances.iter().map(|luminance| (luminance / mean).min(BRIGHTEST)).collect();
        // The mean over three cells in a row and column, the middle one twice; over the edge lies what is at the edge.
        let near = |i: usize, count: usize| [i.saturating_sub(1), i, i, (i + 1).min(count - 1)];
        let around = |i: usize| {
            let (column, row) = (i % columns, i / columns);
            let sum: f64 = near(row, rows)
                .into_iter()
                .flat_map(|row| near(column, columns).map(|column| capped[row * columns + column]))
                .sum();
            sum / 16.0 + FLOOR
        };
        let scale = DVec2::new(columns as f64, rows as f64) / size;
        Some(Self { cells, scale, values: (0..capped.len()).map(around).collect() })
    }

    /// Luminance that arrives at a point of the image over the brightness there; luminance itself if there is no map.
    #[inline(always)]
    pub fn relative(map: Option<&Self>, luminance: f64, raster: DVec2) -> f64 {
        map.map_or(luminance, |map| luminance / map.at(raster))
    }

    /// Relative brightness at a point of the image, positive; beyond the edge that at the edge.
    #[inline(always)]
    pub fn at(&self, raster: DVec2) -> f64 {
        let (columns, rows) = self.cells;
        let last = DVec2::new((columns - 1) as f64, (rows - 1) as f64);
        let at = (raster * self.scale - 0.5).clamp(DVec2::ZERO, last);
        let (column, row) = (at.x as usize, at.y as usize);
        let share = at - at.floor();
        let next = if column + 1 < columns { 1 } else { 0 };
        let below = if row + 1 < rows { columns } else { 0 };
        let first = row * columns + column;
        let of_row = |i: usize| self.values[i] + (self.values[i + next] - self.values[i]) * share.x;
        let (above, under) = (of_row(first), of_row(first + below));
        above + (under - above) * share.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_that_of_the_cells_and_lies_between_their_centres() {
        // Four columns of two pixels, three rows of one.
        let luminances: Vec<f64> = (0..12).map(|i| f64::from(i % 4)).collect();
        let map = BrightnessMap::new(DVec2::new(8.0, 3.0), (4, 3), &luminances).unwrap();
        // The mean is 3/2. A row of 0, 1, 2, 3, smoothed: 1/4, 1, 2, 11/4.
        let of = |value: f64| value / 1.5 + 0.5;
        for (x, expected) in [(1.0, 0.25), (3.0, 1.0), (4.0, 1.5), (5.0, 2.0), (6.5, 2.5625), (7.0, 2.75)] {
            for y in [0.5, 1.3, 2.5] {
                let found = map.at(DVec2::new(x, y));
                assert!((found - of(expected)).abs() < 1e-12, "{x} {y}: {found}");
            }
        }
        assert_eq!(map.at(DVec2::new(-5.0, -1.0)), map.at(DVec2::new(1.0, 0.5)));
        assert_eq!(map.at(DVec2::new(80.0, 9.0)), map.at(DVec2::new(7.0, 2.5)));
    }

    #[test]
    fn a_lamp_does_not_drown_what_is_around_it() {
        let mut luminances = vec![1.0; 64];
        luminances[27] = 1e6;
        let map = BrightnessMap::new(DVec2::splat(8.0), (8, 8), &luminances).unwrap();
        let (most, least) = (map.at(DVec2::new(3.5, 3.5)), map.at(DVec2::new(7.5, 7.5)));
        assert!((0.5..0.6).contains(&least) && (1.0..=BRIGHTEST + FLOOR).contains(&most), "{least} {most}");
    }

    #[test]
    fn without_light_or_with_what_is_no_number_there_is_none() {
        let size = DVec2::splat(2.0);
        assert_eq!(BrightnessMap::new(size, (2, 2), &[0.0; 4]), None);
        for wrong in [f64::NAN, f64::INFINITY, -1.0] {
            assert_eq!(BrightnessMap::new(size, (2, 2), &[1.0, 3.0, wrong, 1.0]), None);
        }
        assert_eq!(BrightnessMap::new(size, (2, 2), &[1.0; 3]), None);
        assert!(BrightnessMap::new(size, (1, 1), &[3.0]).is_some_and(|map| map.at(size) == 1.5));
    }
}
