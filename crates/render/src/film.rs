//! The film: sums of splats in f64, and the picture they make.

use ergodic_geometry::phase::{self, Phase};
use ergodic_pathspace::stability::{Place, is_usable};
use ergodic_scattering::{Filter, FilterKernel, Rgb};
use glam::DVec2;

/// A picture under way.
///
/// Sums are compensated (Kahan 1965), so that their relative error is that of one addition however many splats there are. A
/// plain f64 sum of a billion equal splats is off by 1e-8.
#[derive(Clone, Debug)]
pub struct Film {
    width: u32,
    height: u32,
    kernel: FilterKernel,
    /// Half the width of the filter in pixels.
    radius: f64,
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
pub(crate) const BYTES_PER_PIXEL: usize = size_of::<Sum>();

impl Film {
    /// A black film.
    pub fn new(width: u32, height: u32, filter: Filter) -> Self {
        let sums = vec![Sum::default(); width as usize * height as usize];
        Self { width, height, kernel: filter.kernel(), radius: filter.radius(), sums }
    }

    /// Adds `color` at the raster point, spread over the pixels by the reconstruction filter.
    ///
    /// A value that is not finite, or negative, is not added but counted.
    #[inline]
    pub fn splat(&mut self, raster: DVec2, color: Rgb) {
        let _phase = phase::enter(Phase::Film);
        if !is_usable(Place::Film, color) {
            return;
        }
        match self.kernel {
            FilterKernel::Box => {
                let (x, y) = (raster.x.floor(), raster.y.floor());
                if x >= 0.0 && y >= 0.0 && x < f64::from(self.width) && y < f64::from(self.height) {
                    self.sums[y as usize * self.width as usize + x as usize].add(color);
                }
            }
            FilterKernel::Gaussian { .. } => self.splat_wide(raster, color),
        }
    }

    fn splat_wide(&mut self, raster: DVec2, color: Rgb) {
        let radius = self.radius;
        // Pixel i has its centre at i + 1/2.
        let range = |at: f64, size: u32| {
            let low = (at - radius - 0.5).ceil().max(0.0) as u32;
            let high = (at + radius - 0.5).floor().min(f64::from(size) - 1.0);
            (low, if high < 0.0 { 0 } else { high as u32 + 1 })
        };
        let (x0, x1) = range(raster.x, self.width);
        let (y0, y1) = range(raster.y, self.height);
        for y in y0..y1 {
            let of_row = color * self.kernel.weight_along(raster.y - f64::from(y) - 0.5);
            for x in x0..x1 {
                let weight = self.kernel.weight_along(raster.x - f64::from(x) - 0.5);
                self.sums[y as usize * self.width as usize + x as usize].add(of_row * weight);
            }
        }
    }

    /// Adds another film of the same size.
    pub fn add(&mut self, other: &Self) {
        for (sum, more) in self.sums.iter_mut().zip(&other.sums) {
            sum.add(more.total);
            sum.add(-more.excess);
        }
    }

    /// The picture: every sum times `scale`.
    pub fn develop(&self, scale: f64) -> Picture {
        let pixels = self.sums.iter().map(|sum| (sum.total - sum.excess) * scale).collect();
        Picture { width: self.width, height: self.height, pixels }
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

impl Picture {
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
