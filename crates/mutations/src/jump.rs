//! The perturbation sizes of Veach 11.4.3: radii whose logarithm is uniform, on the image plane and around a direction.

use ergodic_geometry::{Frame, asin, exp, sin_cos_turns};
use ergodic_metropolis::RandomSource;
use glam::{DVec2, DVec3};
use std::cell::Cell;
use std::f64::consts::{PI, TAU};

/// A range of jump sizes r = r₂ exp(-ln(r₂/r₁) u), in pixels or in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JumpRange {
    min: f64,
    max: f64,
    ln_ratio: f64,
    /// The range as seen from outside.
    least: f64,
    most: f64,
}

/// A size recomputed from two paths may differ from the size drawn by rounding; ranges are this much wider when looked
/// at from outside. It only has to exceed the rounding of angles between unit vectors, about 1e-16 / 1e-7.
const SLACK: f64 = 1e-6;

impl JumpRange {
    /// Sizes from `min` to `max`, 0 < min < max.
    #[inline]
    pub(crate) fn new(min: f64, max: f64) -> Self {
        Self::with_ratio(min, max, ln_ratio(min, max))
    }

    #[inline]
    fn with_ratio(min: f64, max: f64, ln_ratio: f64) -> Self {
        Self { min, max, ln_ratio, least: min * (1.0 - SLACK), most: max * (1.0 + SLACK) }
    }

    /// The range with both ends multiplied by `factor`, the largest size at most `most` and the smallest at most a tenth of it.
    #[inline]
    pub(crate) fn scaled(&self, factor: f64, most: f64) -> Self {
        let (min, max) = (self.min * factor, self.max * factor);
        if max <= most { Self::with_ratio(min, max, self.ln_ratio) } else { Self::new(min.min(most * 0.1), most) }
    }

    /// A size, from a number in [0, 1).
    #[inline]
    pub(crate) fn size(&self, u: f64) -> f64 {
        self.max * exp(-self.ln_ratio * u)
    }

    /// Density of a size: 1 / (r ln(r₂/r₁)).
    #[inline]
    pub(crate) fn pdf_size(&self, size: f64) -> f64 {
        if self.contains(size) { 1.0 / (size * self.ln_ratio) } else { 0.0 }
    }

    #[inline]
    fn contains(&self, size: f64) -> bool {
        size >= self.least && size <= self.most
    }

    /// A displacement in the plane, the angle uniform.
    #[inline]
    pub(crate) fn displace(&self, rng: &mut impl RandomSource) -> DVec2 {
        let size = self.size(rng.uniform());
        let (sin, cos) = sin_cos_turns(rng.uniform());
        DVec2::new(cos, sin) * size
    }

    /// Density of a displacement per unit area: 1 / (2π r² ln(r₂/r₁)).
    #[inline]
    pub(crate) fn pdf_area(&self, displacement: DVec2) -> f64 {
        // Squares need no root.
        let square = displacement.length_squared();
        if square >= self.least * self.least && square <= self.most * self.most {
            1.0 / (TAU * square * self.ln_ratio)
        } else {
            0.0
        }
    }

    /// A unit direction turned from `w` by an angle drawn from the range.
    #[inline(always)]
    pub(crate) fn turn(&self, w: DVec3, rng: &mut impl RandomSource) -> DVec3 {
        let theta = self.size(rng.uniform());
        let (sin_phi, cos_phi) = sin_cos_turns(rng.uniform());
        let (sin, cos) = libm::sincos(theta);
        let frame = Frame::from_normal(w);
        (frame.t * (sin * cos_phi) + frame.b * (sin * sin_phi) + w * cos).normalize()
    }

    /// Whether a direction is turned against another by an angle of the range.
    #[inline]
    pub(crate) fn allows_turn(&self, from: DVec3, to: DVec3) -> bool {
        let theta = angle_between(from, to);
        self.contains(theta) && theta < PI
    }

    /// Density of a turned direction per solid angle: 1 / (2π θ sin θ ln(θ₂/θ₁)).
    #[inline]
    pub(crate) fn pdf_solid_angle(&self, from: DVec3, to: DVec3) -> f64 {
        let half_sine = half_sine_between(from, to);
        let theta = 2.0 * asin(half_sine);
        if self.contains(theta) && theta < PI {
            // sin θ = 2 sin(θ/2) cos(θ/2)
            let sine = 2.0 * half_sine * (1.0 - half_sine * half_sine).sqrt();
            1.0 / (TAU * theta * sine * self.ln_ratio)
        } else {
            0.0
        }
    }
}

/// ln(max / min). A mixture has few ranges and asks for them again and again, so logarithms are kept.
#[inline]
fn ln_ratio(min: f64, max: f64) -> f64 {
    const KEPT: usize = 8;
    thread_local! {
        static KNOWN: [Cell<(f64, f64, f64)>; KEPT] = const { [const { Cell::new((1.0, 1.0, 0.0)) }; KEPT] };
    }
    let place = (min.to_bits() >> 50 ^ max.to_bits() >> 50) as usize % KEPT;
    KNOWN.with(|known| {
        let (known_min, known_max, ln) = known[place].get();
        if (known_min, known_max) == (min, max) {
            return ln;
        }
        let ln = libm::log(max / min);
        known[place].set((min, max, ln));
        ln
    })
}

/// The angle between two unit vectors by 2 asin(|a - b| / 2), which keeps its relative accuracy for small angles where
/// acos of the dot product has none.
#[inline]
fn angle_between(a: DVec3, b: DVec3) -> f64 {
    2.0 * asin(half_sine_between(a, b))
}

/// The sine of half the angle between two unit vectors.
#[inline]
fn half_sine_between(a: DVec3, b: DVec3) -> f64 {
    ((a - b).length() * 0.5).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ergodic_metropolis::Replay;

    #[test]
    fn the_angle_keeps_its_accuracy_when_small() {
        for exponent in 1..12 {
            let theta = 10f64.powi(-exponent);
            let (sin, cos) = theta.sin_cos();
            let measured = angle_between(DVec3::Z, DVec3::new(sin, 0.0, cos));
            assert!((measured / theta - 1.0).abs() < 1e-4 * 1e-8 / theta.min(1e-8), "{theta} {measured}");
        }
    }

    #[test]
    fn what_is_drawn_lies_in_the_range_and_has_a_density() {
        let range = JumpRange::new(1e-4, 0.3);
        let w = DVec3::new(0.3, -0.5, 0.8).normalize();
        for i in 0..1000 {
            let u = f64::from(i) / 1000.0;
            let mut numbers = Replay::new(vec![u, (u * 7.0).fract()]);
            assert!(range.pdf_solid_angle(w, range.turn(w, &mut numbers)) > 0.0);
            let mut numbers = Replay::new(vec![u, (u * 7.0).fract()]);
            assert!(range.pdf_area(range.displace(&mut numbers)) > 0.0);
        }
        assert_eq!(range.pdf_solid_angle(w, w), 0.0);
        assert_eq!(range.pdf_solid_angle(w, -w), 0.0);
    }
}
