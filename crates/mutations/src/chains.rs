//! Dirac chains: runs of specular vertices that a perturbation carries through with the same components.

use ergodic_metropolis::RandomSource;
use ergodic_pathspace::{Path, Scene, Vertex};
use ergodic_scattering::{Component, Repertoire, Sight};
use glam::DVec3;

use crate::Rejection;

/// The direction in which a path continues at `vertex`, which stands in for a vertex of component `component`.
///
/// A Dirac component fixes the direction; the caller chooses it otherwise.
#[inline]
pub(crate) fn follow<R: Repertoire>(
    vertex: &mut Vertex<R>,
    w_from: DVec3,
    component: Component,
) -> Result<DVec3, Rejection> {
    vertex.component = component;
    vertex.interaction.dirac_direction(w_from, component).ok_or(Rejection::WrongComponent)
}

/// Makes vertex `to` of `y` what a walk from vertex `from`, its neighbour, meets in direction `w`, and derives the edge between them. Only
/// vertex 0, the light end, may be the environment.
#[inline]
pub(crate) fn trace<R: Repertoire>(
    scene: &Scene<R>,
    y: &mut Path<R>,
    from: usize,
    to: usize,
    w: DVec3,
    rng: &mut impl RandomSource,
) -> Result<(), Rejection> {
    let first = from.min(to);
    let [low, high] = &mut y.vertices[first..first + 2] else { return Err(Rejection::Escaped) };
    let is_light_end = to == 0;
    let (from, to) = if from < to { (low, high) } else { (high, low) };
    let wavelength = y.wavelength;
    let found = if is_light_end {
        scene.fly_or_escape(from, w, wavelength, to, rng)
    } else {
        scene.fly_to(from, w, wavelength, to, rng)
    };
    if !found {
        return Err(Rejection::Escaped);
    }
    y.derive_edges(scene, first, first + 1);
    Ok(())
}

/// Makes vertex k - 1 of `y` what the camera, which is vertex k, sees on a line of sight, and derives the edge between them.
#[inline]
pub(crate) fn trace_sight<R: Repertoire>(
    scene: &Scene<R>,
    y: &mut Path<R>,
    sight: &Sight,
    rng: &mut impl RandomSource,
) -> Result<(), Rejection> {
    let k = y.length();
    let [seen, eye] = &mut y.vertices[k - 1..] else { return Err(Rejection::Escaped) };
    let wavelength = y.wavelength;
    let found = if k == 1 {
        scene.look_along(eye, sight, wavelength, seen, rng)
    } else {
        scene.trace_sight(eye, sight, wavelength, seen, rng)
    };
    if !found {
        return Err(Rejection::Escaped);
    }
    y.derive_edges(scene, k - 1, k);
    Ok(())
}

/// The density, without selection probabilities, with which a Dirac vertex passes light on: 1 for other vertices.
#[inline]
pub(crate) fn dirac_factor<R: Repertoire>(vertex: &Vertex<R>, w_to: DVec3) -> f64 {
    if vertex.component == Component::Rough { 1.0 } else { vertex.interaction.dirac_density(w_to, vertex.component) }
}

/// Finishes a candidate whose edge `i` connects two vertices given, the cheapest question first: the edge must meet the film, if it
/// is the last, both its ends must pass light on, and they must see each other.
///
/// The other edges at both vertices must be there. Derives the edge and the scattering at its ends.
#[inline]
pub(crate) fn connect<R: Repertoire>(scene: &Scene<R>, y: &mut Path<R>, i: usize) -> Result<(), Rejection> {
    y.derive_edges(scene, i, i + 1);
    y.derive_scattering(scene, i, i + 1);
    if i + 1 == y.length() && y.raster.is_none() {
        return Err(Rejection::OffFilm);
    }
    if (y.scattering[i] * y.scattering[i + 1]).max_element() <= 0.0 {
        return Err(Rejection::Dark);
    }
    if !scene.connects(&y.vertices[i], &y.vertices[i + 1], &y.edges[i]) {
        return Err(Rejection::Occluded);
    }
    Ok(())
}
