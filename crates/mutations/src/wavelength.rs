//! What mutations do with the wavelength of a path, in scenes that disperse light.
//!
//! A dispersive vertex is that of one wavelength, so a path may change its wavelength only where no such vertex is kept. Which vertices
//! are kept is part of the plan, and they are the same in both paths: the way there and the way back decide alike. With one kept the
//! wavelength stays, in both directions. Otherwise
//!
//! - the bidirectional mutation draws it anew, with density 1 in its measure;
//! - a perturbation keeps it every other time, and else moves it by a step whose logarithm is uniform, up or down, around the ends of
//!   the range: with the density of that step, which is the same both ways.

use ergodic_metropolis::RandomSource;
use ergodic_pathspace::{Path, Scene};
use ergodic_scattering::{Repertoire, Wavelength};

use crate::Splice;

/// The smallest step, as a share of the range: 0.1 nm, too little for any eye.
const SMALLEST: f64 = 1.0 / 3500.0;

/// The largest step, as a share of the range: 70 nm, about from one colour to the next.
const LARGEST: f64 = 0.2;

/// How often a perturbation keeps a wavelength that it may move.
const KEEP: f64 = 0.5;

/// A step recomputed from two wavelengths may differ from the one drawn by rounding, far less than this.
const SLACK: f64 = 1e-6;

/// Whether a path that keeps these ends of `x` may have another wavelength.
#[inline]
fn is_free<R: Repertoire>(scene: &Scene<R>, x: &Path<R>, plan: Splice) -> bool {
    let suffix = x.vertices.len() - plan.suffix;
    let mut kept = x.vertices[..plan.prefix].iter().chain(&x.vertices[suffix..]);
    scene.disperses() && !kept.any(|vertex| vertex.interaction.is_dispersive())
}

/// The wavelength of a path that keeps these ends of `x` and is sampled anew between them.
#[inline]
pub(crate) fn draw<R: Repertoire>(
    scene: &Scene<R>,
    x: &Path<R>,
    plan: Splice,
    rng: &mut impl RandomSource,
) -> Wavelength {
    if is_free(scene, x, plan) { scene.sample_wavelength(rng) } else { x.wavelength }
}

/// The density of [`draw`].
#[inline]
pub(crate) fn pdf_of_draw<R: Repertoire>(scene: &Scene<R>, from: &Path<R>, to: &Path<R>, plan: Splice) -> f64 {
    if from.wavelength == to.wavelength || is_free(scene, from, plan) { 1.0 } else { 0.0 }
}

/// The wavelength of a path that keeps these ends of `x` and is a perturbation between them.
#[inline]
pub(crate) fn perturb<R: Repertoire>(
    scene: &Scene<R>,
    x: &Path<R>,
    plan: Splice,
    rng: &mut impl RandomSource,
) -> Wavelength {
    if is_free(scene, x, plan) { stepped(x.wavelength, rng) } else { x.wavelength }
}

/// The density of [`perturb`]: of keeping the wavelength, the probability.
#[inline]
pub(crate) fn pdf_of_perturbation<R: Repertoire>(scene: &Scene<R>, from: &Path<R>, to: &Path<R>, plan: Splice) -> f64 {
    if is_free(scene, from, plan) {
        pdf_of_step(from.wavelength, to.wavelength)
    } else if from.wavelength == to.wavelength {
        1.0
    } else {
        0.0
    }
}

fn stepped(from: Wavelength, rng: &mut impl RandomSource) -> Wavelength {
    let u = rng.uniform();
    if u < KEEP {
        return from;
    }
    // What is left of the number is uniform too.
    let u = (u - KEEP) / (1.0 - KEEP);
    let (sign, u) = if u < 0.5 { (-1.0, 2.0 * u) } else { (1.0, 2.0 * u - 1.0) };
    from.moved(sign * LARGEST * libm::exp(-libm::log(LARGEST / SMALLEST) * u))
}

fn pdf_of_step(from: Wavelength, to: Wavelength) -> f64 {
    let step = from.distance(to);
    if step == 0.0 {
        KEEP
    } else if (SMALLEST * (1.0 - SLACK)..=LARGEST * (1.0 + SLACK)).contains(&step) {
        (1.0 - KEEP) / (2.0 * step * libm::log(LARGEST / SMALLEST))
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ergodic_metropolis::Replay;

    /// Cells of equal share of the range, and how often steps from `from` are to land in each, by the midpoint rule.
    const CELLS: usize = 20;

    fn counts(from: Wavelength) -> ([f64; CELLS], [f64; CELLS]) {
        let cell = |w: Wavelength| {
            let share = (w.nanometres() - Wavelength::SHORTEST) / (Wavelength::LONGEST - Wavelength::SHORTEST);
            (share * CELLS as f64) as usize
        };
        let (mut drawn, mut expected) = ([0.0; CELLS], [0.0; CELLS]);
        let n = 200_000;
        for i in 0..n {
            let u = (f64::from(i) + 0.5) / f64::from(n);
            drawn[cell(stepped(from, &mut Replay::new(vec![u])))] += 1.0 / f64::from(n);
        }
        let fine = 2_000_000;
        for i in 0..fine {
            let to = Wavelength::at((f64::from(i) + 0.5) / f64::from(fine));
            expected[cell(to)] += pdf_of_step(from, to) / f64::from(fine);
        }
        expected[cell(from)] += KEEP;
        (drawn, expected)
    }

    #[test]
    fn steps_are_drawn_by_their_density_which_is_the_same_both_ways() {
        // From the middle, and from near an end, around which steps go.
        for share in [0.512, 0.01, 0.97] {
            let from = Wavelength::at(share);
            let (drawn, expected) = counts(from);
            let worst = drawn.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < 2e-4, "{share}: {drawn:?} {expected:?}");
            for u in [0.1, 0.51, 0.7, 0.76, 0.999] {
                let to = stepped(from, &mut Replay::new(vec![u]));
                assert!(pdf_of_step(from, to) > 0.0);
                assert_eq!(pdf_of_step(from, to), pdf_of_step(to, from));
            }
        }
    }
}
