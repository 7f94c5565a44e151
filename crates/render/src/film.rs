//! The film: sums of splats in f64, and the picture they make.
//!
//! There is one film, however many parts the work is cut into. Each part puts its splats into a [`SplatBuffer`] of its own and
//! of fixed size; when buffers are full they are merged into the film, band of rows by band, each band by one thread that
//! visits the buffers in their order. So a pixel gets its splats in an order that does not depend on the number of threads.

use ergodic_geometry::phase::{self, Phase};
use ergodic_pathspace::stability::{Place, is_usable};
use ergodic_scattering::{Filter, Rgb};
use glam::DVec2;
use rayon::prelude::*;

use crate::bins::Bins;
use crate::grid::Grid;

/// A picture under way.
///
/// Sums are compensated (Kahan 1965), so that their relative error is that of one addition however many splats there are. A
/// plain f64 sum of a billion equal splats is off by 1e-8.
#[derive(Clone, Debug)]
pub struct Film {
    grid: Grid,
    sums: Vec<Sum>,
}

/// A sum, and by how much it is too large.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    total: Rgb,
    excess: Rgb,
}

impl Sum {
    #[inline]
    fn add(&mut self, color: Rgb) {
        let color = color - self.excess;
        let total = self.total + color;
        self.excess = (total - self.total) - color;
        self.total = total;
    }
}

/// Memory that a pixel of a film takes, in bytes.
pub(crate) const FILM_BYTES_PER_PIXEL: usize = size_of::<Sum>();

/// Light that arrives at a raster point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Splat {
    pub(crate) raster: DVec2,
    pub(crate) color: Rgb,
}

/// Splats on their way to a film.
///
/// Of fixed size: 2048 splats, 40 bytes each, and two indices of 4 bytes for each. More are taken, but then it has to grow.
#[derive(Clone, Debug)]
pub struct SplatBuffer(Bins<Splat>);

impl Default for SplatBuffer {
    fn default() -> Self {
        Self::new()
    }
}

impl SplatBuffer {
    /// An empty buffer.
    pub fn new() -> Self {
        Self(Bins::new())
    }

    /// How many splats still fit.
    #[inline]
    pub fn room(&self) -> usize {
        self.0.room()
    }

    /// Takes `color` at a raster point, in pixels from the upper left corner.
    ///
    /// A value that is not finite, or negative, is not taken but counted.
    #[inline]
    pub fn splat(&mut self, raster: DVec2, color: Rgb) {
        let _phase = phase::enter(Phase::Film);
        if is_usable(Place::Film, color) {
            self.0.push(Splat { raster, color });
        }
    }

    /// Sorts the splats by the bands of `grid`.
    pub(crate) fn sort(&mut self, grid: &Grid) {
        self.0.sort(grid.bands(), |splat| grid.bands_of(splat.raster));
    }

    /// The splats that reach a band, as last sorted.
    #[inline]
    pub(crate) fn of_band(&self, band: usize) -> impl Iterator<Item = &Splat> {
        self.0.of_band(band)
    }

    /// Bytes of a buffer that holds `splats` splats at most.
    pub(crate) fn bytes(splats: usize, grid: &Grid) -> usize {
        Bins::<Splat>::bytes(splats, grid.bands())
    }
}

impl Film {
    /// A black film.
    pub fn new(width: u32, height: u32, filter: Filter) -> Self {
        let grid = Grid::new(width, height, filter);
        Self { grid, sums: vec![Sum::default(); grid.pixels()] }
    }

    /// Adds `color` at the raster point, spread over the pixels by the reconstruction filter.
    ///
    /// A value that is not finite, or negative, is not added but counted.
    #[inline]
    pub fn splat(&mut self, raster: DVec2, color: Rgb) {
        let _phase = phase::enter(Phase::Film);
        if is_usable(Place::Film, color) {
            self.grid.spread(raster, color, 0..self.grid.height, |pixel, part| self.sums[pixel].add(part));
        }
    }

    /// Adds all splats of the buffers and empties them, in parallel.
    ///
    /// Every pixel gets what it would get from [`Self::splat`], buffer by buffer: the same sums to the bit.
    pub fn merge(&mut self, buffers: &mut [&mut SplatBuffer]) {
        let grid = self.grid;
        buffers.par_iter_mut().for_each(|buffer| buffer.sort(&grid));
        let sorted: &[&mut SplatBuffer] = buffers;
        self.sums.par_chunks_mut(grid.band_pixels()).enumerate().for_each(|(band, sums)| {
            let (first, rows) = (band * grid.band_pixels(), grid.band_rows(band));
            for buffer in sorted {
                for splat in buffer.of_band(band) {
                    grid.spread(splat.raster, splat.color, rows.clone(), |pixel, part| sums[pixel - first].add(part));
                }
            }
        });
        buffers.iter_mut().for_each(|buffer| buffer.0.clear());
    }

    /// Adds all splats of one buffer and empties it, on this thread: what [`Self::merge`] does in parallel.
    pub fn take(&mut self, buffer: &mut SplatBuffer) {
        for Splat { raster, color } in buffer.0.entries() {
            self.grid.spread(*raster, *color, 0..self.grid.height, |pixel, part| self.sums[pixel].add(part));
        }
        buffer.0.clear();
    }

    /// The picture: every sum times `scale`.
    pub fn develop(&self, scale: f64) -> Picture {
        let pixels = self.sums.iter().map(|sum| (sum.total - sum.excess) * scale).collect();
        Picture { width: self.grid.width, height: self.grid.height, pixels }
    }
}

/// A finished picture: linear RGB radiance, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` pixels.
    pub pixels: Vec<Rgb>,
}

/// Memory that a pixel of a picture takes, in bytes.
pub(crate) const PICTURE_BYTES_PER_PIXEL: usize = size_of::<Rgb>();

impl Picture {
    /// A black picture.
    pub(crate) fn black((width, height): (u32, u32)) -> Self {
        Self { width, height, pixels: vec![Rgb::ZERO; width as usize * height as usize] }
    }

    /// Adds another picture of the same size.
    pub fn add(&mut self, other: &Self) {
        for (pixel, more) in self.pixels.iter_mut().zip(&other.pixels) {
            *pixel += *more;
        }
    }

    /// The mean over all pixels.
    pub fn mean(&self) -> Rgb {
        self.pixels.iter().sum::<Rgb>() / self.pixels.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use ergodic_metropolis::RandomSource;

    use super::*;
    use crate::{Purpose, stream};

    /// Splats of one part, all over the picture and beyond its borders, of very different sizes.
    fn splats(part: u64, count: usize, (width, height): (u32, u32)) -> Vec<(DVec2, Rgb)> {
        let mut rng = stream(5, Purpose::Chain, part);
        let mut at = |size: u32| rng.uniform() * (f64::from(size) + 4.0) - 2.0;
        let points: Vec<DVec2> = (0..count).map(|_| DVec2::new(at(width), at(height))).collect();
        points.into_iter().enumerate().map(|(i, p)| (p, Rgb::new(0.1, 1.0, 1e-9) * (1 + i % 13) as f64)).collect()
    }

    /// What merging the parts in the given order, three times over, leaves on a film.
    fn merged(filter: Filter, size: (u32, u32), order: &[u64]) -> Picture {
        let mut film = Film::new(size.0, size.1, filter);
        let mut buffers = vec![SplatBuffer::new(); order.len()];
        for round in 0..3 {
            for (buffer, part) in buffers.iter_mut().zip(order) {
                splats(part + 10 * round, 3000, size).into_iter().for_each(|(at, color)| buffer.splat(at, color));
            }
            film.merge(&mut buffers.iter_mut().collect::<Vec<_>>());
        }
        film.develop(1.0)
    }

    #[test]
    fn merged_buffers_are_splats_one_by_one_to_the_bit() {
        let mut seen = 0;
        for filter in [Filter::Box, Filter::Gaussian { radius: 2.0, sigma: 0.5 }] {
            for size in [(1, 1), (40, 90), (700, 3)] {
                let mut film = Film::new(size.0, size.1, filter);
                for part in [0, 1, 2, 10, 11, 12, 20, 21, 22] {
                    splats(part, 3000, size).into_iter().for_each(|(at, color)| film.splat(at, color));
                }
                let one_by_one = film.develop(1.0);
                let lit = one_by_one.pixels.iter().filter(|pixel| pixel.x > 0.0).count();
                assert!(lit * 10 > one_by_one.pixels.len() * 9, "{lit}");
                assert_eq!(merged(filter, size, &[0, 1, 2]), one_by_one, "{filter:?} {size:?}");
                let (mut film, mut buffer) = (Film::new(size.0, size.1, filter), SplatBuffer::new());
                for part in [0, 1, 2, 10, 11, 12, 20, 21, 22] {
                    splats(part, 3000, size).into_iter().for_each(|(at, color)| buffer.splat(at, color));
                    film.take(&mut buffer);
                }
                assert_eq!(film.develop(1.0), one_by_one, "{filter:?} {size:?}");
                seen += u32::from(merged(filter, size, &[1, 0, 2]) != one_by_one);
            }
        }
        // Another order of the parts is seen, though not in one pixel only: compensated sums hardly depend on it.
        assert!(seen >= 4, "{seen}");
    }

    #[test]
    fn what_is_no_splat_is_counted_where_it_is_taken() {
        let before = ergodic_pathspace::stability::left_out();
        let mut buffer = SplatBuffer::new();
        let room = buffer.room();
        buffer.splat(DVec2::splat(0.5), Rgb::new(0.0, f64::NAN, 0.0));
        buffer.splat(DVec2::splat(0.5), Rgb::splat(-1.0));
        assert_eq!(buffer.room(), room);
        buffer.splat(DVec2::splat(0.5), Rgb::ONE);
        assert_eq!(buffer.room(), room - 1);
        let found = ergodic_pathspace::stability::left_out() - before;
        assert_eq!((found.at(Place::Film).non_finite, found.at(Place::Film).negative), (1, 1));
    }
}
