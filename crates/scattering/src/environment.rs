//! Light from infinitely far away in every direction: a latitude-longitude map, or one colour.
//!
//! # Orientation
//!
//! +y is up, as glTF has it: the top row of the map is the zenith. Its middle column shows +x, and columns further right
//! turn towards +z, so that the left and the right edge meet at -x. A rotation turns the map about +y by the right-hand
//! rule, counter-clockwise as seen from above: 90 degrees bring the middle column to -z, where a glTF camera looks at rest.
//!
//! # Radiance and density
//!
//! Between the centres of texels radiance is linear in the azimuth and in y = cos θ; beyond the first and the last row it
//! is constant along a meridian. Azimuth and y measure solid angle, dω = dφ dy, so in this measure radiance is a sum of
//! tents, one a texel, whose integrals are known. Sampling chooses a texel by the luminance of its tent and then a
//! direction by the tent itself (composition; Devroye 1986, II.4). The density is then the luminance of the radiance over
//! its integral, exactly: it is read off the radiance, and it is positive wherever that is.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::DVec3;

use crate::{AliasTable, Rgb, luminance};

/// Radiance from every direction.
#[derive(Clone, Debug)]
pub struct Environment {
    width: usize,
    height: usize,
    /// Red, green and blue of the texels, row by row from the zenith.
    texels: Arc<Vec<f32>>,
    /// Factor of all texels.
    strength: f64,
    /// Sine and cosine of the rotation.
    turn: (f64, f64),
    /// y of the rows' centres, falling.
    rows: Vec<f64>,
    /// Chooses a block: some neighbouring texels of a row.
    blocks: AliasTable,
    blocks_in_row: usize,
    /// Integral of luminance over the sphere.
    total: f64,
}

/// Texels in a block. Their luminances are added up again for each sample, so that only one number for a block is stored.
const BLOCK: usize = 16;

/// Directions this near the rim of a tent, relative to its width, are drawn in to it: beyond the rim its radiance is 0, and
/// rounding could lead there.
const RIM: f64 = 1e-6;

impl Environment {
    /// From `width` times `height` texels of three numbers each, finite and not negative, times `strength`; turned by
    /// `rotation` degrees. `None` if the number of texels is another, or 0.
    pub fn map(width: u32, height: u32, texels: Vec<f32>, strength: f64, rotation: f64) -> Option<Self> {
        let (width, height) = (width as usize, height as usize);
        if texels.is_empty() || texels.len() != 3 * width * height {
            return None;
        }
        let rows = row_centres(height);
        let (sin, cos) = libm::sincos(rotation.to_radians());
        let mut environment = Self {
            width,
            height,
            texels: Arc::new(texels),
            strength,
            turn: (sin, cos),
            rows,
            blocks: AliasTable::default(),
            blocks_in_row: width.div_ceil(BLOCK),
            total: 0.0,
        };
        let column = TAU / width as f64;
        let mut weights = Vec::with_capacity(height * environment.blocks_in_row);
        for row in 0..height {
            let (above, below) = environment.halves(row);
            for block in 0..environment.blocks_in_row {
                let sum: f64 = environment.block(row, block).map(|i| environment.luminance_at(row, i)).sum();
                weights.push(sum * (above + below) * column);
            }
        }
        environment.blocks = AliasTable::new(&weights);
        environment.total = environment.blocks.total() * strength;
        Some(environment)
    }

    /// The nearest to the radiance that `radiance` tells of unit directions: each texel is its mean over the texel's tent, by
    /// `side` times `side` points that stand for equal shares of it. The tents of all texels add up to 1 everywhere, so that the mean
    /// over all directions is kept, but for the error of the points. `None` if the width or height is 0.
    pub fn resampled(width: u32, height: u32, side: u32, radiance: impl Fn(DVec3) -> Rgb) -> Option<Self> {
        let rows = row_centres(height as usize);
        let shares = || (0..side).map(|k| (f64::from(k) + 0.5) / f64::from(side));
        let mut texels = Vec::with_capacity(3 * width as usize * height as usize);
        for row in 0..rows.len() {
            for column in 0..width as usize {
                let mut sum = Rgb::ZERO;
                for y in shares().map(|u| tent_y(&rows, row, u)) {
                    sum +=
                        shares().map(|u| radiance(direction(y, tent_azimuth(width as usize, column, u)))).sum::<Rgb>();
                }
                texels.extend((sum / f64::from(side * side)).as_vec3().to_array());
            }
        }
        Self::map(width, height, texels, 1.0, 0.0)
    }

    /// Multiplies the strengths of red, green and blue.
    #[must_use]
    pub fn tinted(&self, factor: Rgb) -> Self {
        let factor = factor * self.strength;
        let texels = self
            .texels
            .chunks_exact(3)
            .flat_map(|t| (DVec3::new(t[0].into(), t[1].into(), t[2].into()) * factor).as_vec3().to_array());
        let mut tinted = Self::map(self.width as u32, self.height as u32, texels.collect(), 1.0, 0.0)
            .unwrap_or_else(|| unreachable!("the number of texels is the same"));
        tinted.turn = self.turn;
        tinted
    }

    /// The same radiance from every direction.
    pub fn constant(radiance: Rgb) -> Self {
        let texels = radiance.as_vec3().to_array().to_vec();
        Self::map(1, 1, texels, 1.0, 0.0).unwrap_or_else(|| unreachable!("one texel is given"))
    }

    /// Width and height of the map in texels.
    pub fn size(&self) -> (u32, u32) {
        (self.width as u32, self.height as u32)
    }

    /// Integral of luminance over the sphere, in W/m² of luminous weight: π times the irradiance averaged over directions.
    pub fn total_luminance(&self) -> f64 {
        self.total
    }

    /// Bytes that the texels and the tables take.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.texels[..])
            + size_of_val(&self.rows[..])
            + self.height * self.blocks_in_row * (size_of::<f64>() + size_of::<u32>())
    }

    /// The mean radiance over all directions.
    pub fn mean(&self) -> Rgb {
        let row = |row: usize| {
            let (above, below) = self.halves(row);
            (0..self.width).map(|i| self.texel(row, i)).sum::<Rgb>() * (above + below)
        };
        (0..self.height).map(row).sum::<Rgb>() * (self.strength * 0.5 / self.width as f64)
    }

    #[inline]
    fn texel(&self, row: usize, column: usize) -> Rgb {
        let i = 3 * (row * self.width + column);
        Rgb::new(f64::from(self.texels[i]), f64::from(self.texels[i + 1]), f64::from(self.texels[i + 2]))
    }

    #[inline]
    fn luminance_at(&self, row: usize, column: usize) -> f64 {
        luminance(self.texel(row, column))
    }

    fn block(&self, row: usize, block: usize) -> std::ops::Range<usize> {
        debug_assert!(row < self.height);
        block * BLOCK..(block * BLOCK + BLOCK).min(self.width)
    }

    #[inline]
    fn halves(&self, row: usize) -> (f64, f64) {
        halves(&self.rows, row)
    }

    /// Radiance that arrives from the unit direction `w`, which points away from the scene.
    pub fn radiance(&self, w: DVec3) -> Rgb {
        if self.texels.len() == 3 {
            return self.texel(0, 0) * self.strength;
        }
        let (sin, cos) = self.turn;
        let (x, z) = (cos * w.x - sin * w.z, sin * w.x + cos * w.z);
        let y = w.y.clamp(-1.0, 1.0);

        let above = (libm::acos(y) / PI * self.height as f64 - 0.5).floor();
        let row = (above.max(0.0) as usize).min(self.height - 1);
        let next = ((above + 1.0).max(0.0) as usize).min(self.height - 1);
        let down = if next == row { 0.0 } else { (self.rows[row] - y) / (self.rows[row] - self.rows[next]) };
        let down = down.clamp(0.0, 1.0);

        let across = (libm::atan2(z, x) / TAU + 0.5) * self.width as f64 - 0.5;
        let left = across.floor();
        let right = across - left;
        // From -1 for the left half of the first texel to the width less 1.
        let left = if left < 0.0 { self.width - 1 } else { (left as usize).min(self.width - 1) };
        let next_column = if left + 1 == self.width { 0 } else { left + 1 };

        let in_row = |row| self.texel(row, left).lerp(self.texel(row, next_column), right);
        in_row(row).lerp(in_row(next), down) * self.strength
    }

    /// Density in 1/sr of [`Self::sample`], at a direction from which `radiance` arrives.
    #[inline]
    pub fn pdf_solid_angle(&self, radiance: Rgb) -> f64 {
        luminance(radiance) / self.total
    }

    /// A direction from which light arrives, with the density [`Self::pdf_solid_angle`]. The environment must not be black.
    pub fn sample(&self, u: [f64; 3]) -> DVec3 {
        let (block, left) = self.blocks.choose(u[0]);
        let row = block / self.blocks_in_row;
        let columns = self.block(row, block % self.blocks_in_row);
        let sum: f64 = columns.clone().map(|i| self.luminance_at(row, i)).sum();
        let mut remaining = left * sum;
        let mut column = columns.start;
        for i in columns {
            let share = self.luminance_at(row, i);
            if share > 0.0 {
                // Rounding may leave something after the last; it is the last then.
                column = i;
                if remaining < share {
                    break;
                }
                remaining -= share;
            }
        }

        let y = tent_y(&self.rows, row, u[1]);
        let turned = direction(y, tent_azimuth(self.width, column, u[2]));
        let (sin, cos) = self.turn;
        DVec3::new(cos * turned.x + sin * turned.z, y, cos * turned.z - sin * turned.x).normalize()
    }
}

/// y of the centres of the rows of a map, falling.
fn row_centres(height: usize) -> Vec<f64> {
    (0..height).map(|j| libm::cos(PI * (j as f64 + 0.5) / height as f64)).collect()
}

/// The integral in y of a row's tent above and below its centre. At the poles it is flat, elsewhere it falls to 0.
#[inline]
fn halves(rows: &[f64], row: usize) -> (f64, f64) {
    let y = rows[row];
    let above = if row == 0 { 1.0 - y } else { 0.5 * (rows[row - 1] - y) };
    let below = if row + 1 == rows.len() { y + 1.0 } else { 0.5 * (y - rows[row + 1]) };
    (above, below)
}

/// Distance from the centre, in the density that falls from 1 to 0 over the half of a tent.
#[inline]
fn falling(u: f64) -> f64 {
    (1.0 - (1.0 - u).max(0.0).sqrt()).min(1.0 - RIM)
}

/// The y of a point of a row's tent: uniform `u` give the tent's own density. Each half is counted from the centre outwards.
#[inline]
fn tent_y(rows: &[f64], row: usize, u: f64) -> f64 {
    let (above, below) = halves(rows, row);
    let along = u * (above + below);
    let centre = rows[row];
    let y = match (along < above, row == 0, row + 1 == rows.len()) {
        (true, true, _) => centre + along,
        (true, false, _) => centre + 2.0 * above * falling(along / above),
        (false, _, true) => centre - (along - above),
        (false, _, false) => centre - 2.0 * below * falling((along - above) / below),
    };
    y.clamp(-1.0, 1.0)
}

/// The azimuth of a point of a column's tent, likewise.
#[inline]
fn tent_azimuth(width: usize, column: usize, u: f64) -> f64 {
    let side = if u < 0.5 { falling(2.0 * u) } else { -falling(2.0 * u - 1.0) };
    ((column as f64 + 0.5 + side) / width as f64 - 0.5) * TAU
}

#[inline]
fn direction(y: f64, azimuth: f64) -> DVec3 {
    let radius = ((1.0 - y) * (1.0 + y)).sqrt();
    let (sin, cos) = libm::sincos(azimuth);
    DVec3::new(radius * cos, y, radius * sin)
}
