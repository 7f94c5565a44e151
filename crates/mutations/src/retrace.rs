//! How a perturbation traces a vertex again: a point of a surface is what the new ray meets, a point of a medium lies at a new
//! distance on it, a little different from the old one. The density of both, in either direction of travel.
//!
//! The distance is multiplied by e^x with x drawn from Laplace's distribution. So kinds of vertices are kept, free flight is not
//! drawn anew, and a path of many points in a medium stays near where it was.

use ergodic_metropolis::RandomSource;
use ergodic_pathspace::{End, Path, Scene, Vertex};
use ergodic_scattering::Repertoire;

use crate::Rejection;

/// Mean of |x|: distances in media change by about this share.
const SPREAD: f64 = 0.1;

/// A length near `length`, with density [`pdf_length`].
#[inline]
pub(crate) fn perturb_length(length: f64, rng: &mut impl RandomSource) -> f64 {
    let u = rng.uniform();
    let x = if u < 0.5 { libm::log(1.0 - 2.0 * u) } else { -libm::log(2.0 - 2.0 * u) };
    length * libm::exp(SPREAD * x)
}

/// Density per unit of length of `to` near `from`.
#[inline]
pub(crate) fn pdf_length(from: f64, to: f64) -> f64 {
    libm::exp(-libm::log(to / from).abs() / SPREAD) / (2.0 * SPREAD * to)
}

/// The length of edge `i` of a path through the medium: from infinitely far away, from where it begins.
#[inline]
pub(crate) fn length<R: Repertoire>(scene: &Scene<R>, path: &Path<R>, i: usize) -> f64 {
    let edge = &path.edges[i];
    if path.vertices[i].is_distant() {
        scene.depth_from_afar(path.vertices[i + 1].position, edge.direction)
    } else {
        edge.length
    }
}

/// Makes vertex `to` of `y` what its neighbour `from` sees in direction `w`, of the kind of the vertex of `x` there, and derives the
/// edge between them. Only vertex 0, the light end, may be the environment.
///
/// The ray leaves from `start` in place of the neighbour, if that is given: an orthographic camera has no position.
#[inline(always)]
pub(crate) fn retrace<R: Repertoire>(
    scene: &Scene<R>,
    x: &Path<R>,
    y: &mut Path<R>,
    (from, to): (usize, usize),
    start: Option<&Vertex<R>>,
    w: glam::DVec3,
    rng: &mut impl RandomSource,
) -> Result<(), Rejection> {
    let first = from.min(to);
    let [low, high] = &mut y.vertices[first..first + 2] else { return Err(Rejection::Escaped) };
    let (neighbour, end) = if from < to { (low, high) } else { (high, low) };
    let start = start.unwrap_or(neighbour);
    if x.vertices[to].is_in_medium() {
        let length = perturb_length(length(scene, x, first), rng);
        if !scene.place_in_medium(start, w, length, end, rng) {
            return Err(Rejection::Occluded);
        }
    } else {
        // An orthographic camera does not see the environment itself.
        let may_escape = to == 0 && !start.is_on_film();
        let wavelength = y.wavelength;
        let found = if may_escape {
            scene.look_to(start, w, wavelength, end, rng)
        } else {
            scene.trace_to(start, w, wavelength, end, rng)
        };
        if !found {
            return Err(Rejection::Escaped);
        }
    }
    y.derive_edges(scene, first, first + 1);
    Ok(())
}

/// Turns the density per solid angle, or on the disk of light from infinitely far away, with which edge `i` of `to` was found into the
/// density of its vertex on the side that is not `end`, given the path that it was made from. 0 if that has another kind of vertex
/// there.
#[inline]
pub(crate) fn conversion<R: Repertoire>(scene: &Scene<R>, from: &Path<R>, to: &Path<R>, i: usize, end: End) -> f64 {
    let edge = &to.edges[i];
    let (found, by_walk) = match end {
        End::Light => (i + 1, edge.to_eye_side),
        End::Eye => (i, edge.to_light_side),
    };
    if !scene.scatters() {
        return by_walk;
    }
    let vertex = &to.vertices[found];
    if vertex.is_in_medium() != from.vertices[found].is_in_medium() {
        return 0.0;
    }
    let flight = edge.flight(scene, &to.vertices[i], &to.vertices[i + 1], vertex);
    if by_walk <= 0.0 || flight <= 0.0 {
        // So far through the medium that nothing arrives.
        return 0.0;
    }
    let without = by_walk / flight;
    if vertex.is_in_medium() { without * pdf_length(length(scene, from, i), length(scene, to, i)) } else { without }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ergodic_metropolis::Replay;

    /// The share of lengths below a bound is the integral of the density, which is known: Laplace's distribution of the logarithm.
    #[test]
    fn lengths_have_their_density() {
        let (from, n) = (0.37, 20_000);
        let draw = |i: u32| perturb_length(from, &mut Replay::new(vec![(f64::from(i) + 0.5) / f64::from(n)]));
        let mut lengths: Vec<f64> = (0..n).map(draw).collect();
        lengths.sort_by(f64::total_cmp);
        // Trapezoids between neighbours hold the probability of one interval each; a wrong factor of `to` is seen.
        let share = |pdf: &dyn Fn(f64) -> f64| -> f64 {
            let middle = &lengths[1000..19_000];
            middle.windows(2).map(|pair| (pair[1] - pair[0]) * 0.5 * (pdf(pair[0]) + pdf(pair[1]))).sum()
        };
        let expected = 17_999.0 / 20_000.0;
        assert!((share(&|to| pdf_length(from, to)) - expected).abs() < 1e-4);
        assert!((share(&|to| pdf_length(from, to) * to / from) - expected).abs() > 1e-3);
    }
}
