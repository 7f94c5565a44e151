//! The pixels of a picture: which of them a splat reaches, and the bands of rows into which work on them is cut.

use std::ops::Range;

use ergodic_scattering::{Filter, FilterKernel, Rgb};
use glam::DVec2;

/// At most this many bands: enough for many threads, few enough that what many buffers hold for one is more than nothing.
const MAX_BANDS: u32 = 256;
/// Bands of small pictures have this many pixels at least.
const MIN_BAND_PIXELS: u32 = 512;

/// Width, height and filter of a picture, and the height of its bands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// A band has two to the power of this many rows; the last one has what is left.
    ln2_rows: u32,
    kernel: FilterKernel,
    /// Half the width of the filter in pixels.
    radius: f64,
}

impl Grid {
    pub(crate) fn new(width: u32, height: u32, filter: Filter) -> Self {
        let radius = filter.radius();
        // As many rows as a splat can reach, so that it reaches two bands at most.
        let reach = (2.0 * radius).ceil() as u32;
        let rows = height.div_ceil(MAX_BANDS).max(MIN_BAND_PIXELS.div_ceil(width.max(1))).max(reach);
        Self { width, height, ln2_rows: rows.next_power_of_two().ilog2(), kernel: filter.kernel(), radius }
    }

    pub(crate) fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Number of bands.
    pub(crate) fn bands(&self) -> usize {
        (self.height as usize).div_ceil(1 << self.ln2_rows)
    }

    /// Pixels of every band but the last.
    pub(crate) fn band_pixels(&self) -> usize {
        (self.width as usize) << self.ln2_rows
    }

    /// Rows of a band.
    pub(crate) fn band_rows(&self, band: usize) -> Range<u32> {
        let first = (band as u32) << self.ln2_rows;
        first..self.height.min(first + (1 << self.ln2_rows))
    }

    /// The pixel that a raster point lies in, as column and row.
    #[inline]
    fn cell(&self, raster: DVec2) -> Option<(u32, u32)> {
        let DVec2 { x, y } = raster;
        let inside = x >= 0.0 && y >= 0.0 && x < f64::from(self.width) && y < f64::from(self.height);
        // Of numbers that are not negative the conversion is the floor, without a call for it.
        inside.then_some((x as u32, y as u32))
    }

    #[inline]
    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }

    /// Index of the pixel that a raster point lies in.
    #[inline]
    pub(crate) fn pixel(&self, raster: DVec2) -> Option<usize> {
        self.cell(raster).map(|(x, y)| self.index(x, y))
    }

    /// The band of a pixel, by index.
    #[inline]
    pub(crate) fn band_of_pixel(&self, pixel: u32) -> usize {
        ((pixel / self.width) >> self.ln2_rows) as usize
    }

    /// The pixels along one axis whose filter holds `at`. Pixel i has its centre at i + 1/2.
    #[inline]
    fn range(&self, at: f64, size: u32) -> Range<u32> {
        let low = (at - self.radius - 0.5).ceil().max(0.0) as u32;
        let high = (at + self.radius - 0.5).floor().min(f64::from(size) - 1.0);
        low..if high < 0.0 { 0 } else { high as u32 + 1 }
    }

    /// The bands that a splat reaches, two at most.
    #[inline]
    pub(crate) fn bands_of(&self, raster: DVec2) -> Range<usize> {
        let rows = match self.kernel {
            FilterKernel::Box => self.cell(raster).map_or(0..0, |(_, y)| y..y + 1),
            FilterKernel::Gaussian { .. } => self.range(raster.y, self.height),
        };
        if rows.is_empty() {
            return 0..0;
        }
        (rows.start >> self.ln2_rows) as usize..((rows.end - 1) >> self.ln2_rows) as usize + 1
    }

    /// Spreads `color` over the pixels of some rows by the filter; `add` gets the index of a pixel and its part.
    #[inline]
    pub(crate) fn spread(&self, raster: DVec2, color: Rgb, rows: Range<u32>, mut add: impl FnMut(usize, Rgb)) {
        match self.kernel {
            FilterKernel::Box => {
                if let Some((x, y)) = self.cell(raster).filter(|(_, y)| rows.contains(y)) {
                    add(self.index(x, y), color);
                }
            }
            FilterKernel::Gaussian { .. } => {
                let columns = self.range(raster.x, self.width);
                let reached = self.range(raster.y, self.height);
                for y in reached.start.max(rows.start)..reached.end.min(rows.end) {
                    let of_row = color * self.kernel.weight_along(raster.y - f64::from(y) - 0.5);
                    for x in columns.clone() {
                        let weight = self.kernel.weight_along(raster.x - f64::from(x) - 0.5);
                        add(self.index(x, y), of_row * weight);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDE: Filter = Filter::Gaussian { radius: 16.0, sigma: 4.0 };

    #[test]
    fn bands_are_all_rows_once() {
        for (width, height) in [(1, 1), (7, 300), (256, 256), (3840, 2160), (65_536, 4096), (1, 65_536)] {
            for filter in [Filter::Box, WIDE] {
                let grid = Grid::new(width, height, filter);
                let rows: Vec<u32> = (0..grid.bands()).flat_map(|band| grid.band_rows(band)).collect();
                assert!(rows.iter().copied().eq(0..height), "{width}x{height}");
                assert!(grid.bands() <= MAX_BANDS as usize);
                let chunks = grid.pixels().div_ceil(grid.band_pixels());
                assert_eq!(chunks, grid.bands(), "{width}x{height}: chunks of the film are its bands");
                for row in [0, height / 2, height - 1] {
                    let band = grid.band_of_pixel(row * width);
                    assert!(grid.band_rows(band).contains(&row));
                }
            }
        }
    }

    #[test]
    fn a_splat_reaches_its_bands_and_no_other() {
        let mut crossing = 0;
        for filter in [Filter::Box, Filter::Gaussian { radius: 1.5, sigma: 0.5 }, WIDE] {
            let grid = Grid::new(64, 200, filter);
            for i in 0..4000 {
                let raster = DVec2::new(f64::from(i % 83) - 9.3, f64::from(i) * 0.06 - 20.0);
                let bands = grid.bands_of(raster);
                assert!(bands.len() <= 2, "{raster}");
                crossing += usize::from(bands.len() == 2);
                let (mut by_band, mut whole) = (Vec::new(), Vec::new());
                for band in bands {
                    grid.spread(raster, Rgb::ONE, grid.band_rows(band), |pixel, part| by_band.push((pixel, part)));
                }
                grid.spread(raster, Rgb::ONE, 0..200, |pixel, part| whole.push((pixel, part)));
                assert_eq!(by_band, whole, "{raster}");
            }
        }
        // Borders are met, so that a band left out would be seen.
        assert!(crossing > 500, "{crossing}");
    }
}
