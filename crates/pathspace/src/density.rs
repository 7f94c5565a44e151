//! Densities of vertices and strategies (Veach 10.2): pure functions of a path as if it were given from outside.
//!
//! A vertex is sampled from its neighbour, either from the light side or from the eye side. A strategy (s, t) samples the
//! first s vertices from the light and the other t from the eye, and connects. Russian roulette is not part of these.
//!
//! What is called area density here is one per volume for points of media.

use ergodic_scattering::Repertoire;

use crate::{Path, Scene, Vertex};

/// Area density of vertex `i` sampled from the light side, given vertices i-1 and i-2. The emitter density for i = 0, which for
/// the environment is one of its direction per solid angle.
///
/// 0 for the camera, which nothing can hit.
#[inline]
pub fn pdf_area_from_light<R: Repertoire>(scene: &Scene<R>, path: &Path<R>, i: usize) -> f64 {
    let (vertices, edges) = (&path.vertices[..], &path.edges[..]);
    let vertex = &vertices[i];
    if i == 0 {
        return scene.emitter_pdf_area(vertex);
    }
    if !vertex.scatters() {
        return 0.0;
    }
    let edge = &edges[i - 1];
    let before = &vertices[i - 1];
    let directional = if i == 1 {
        scene.emission_pdf(before, edge.direction)
    } else {
        before.interaction.pdf(-edges[i - 2].direction, edge.direction, before.component)
    };
    directional * edge.to_eye_side
}

/// Area density of vertex `i` sampled from the eye side, given vertices i+1 and i+2; per solid angle for the environment. For the
/// camera's own vertex that on its lens, or 1 (a Dirac) without one; 0 for lights that cannot be hit.
#[inline]
pub fn pdf_area_from_eye<R: Repertoire>(scene: &Scene<R>, path: &Path<R>, i: usize) -> f64 {
    let (vertices, edges) = (&path.vertices[..], &path.edges[..]);
    let k = path.length();
    if i == k {
        return scene.eye_pdf_area(&vertices[k]);
    }
    let edge = &edges[i];
    let after = &vertices[i + 1];
    let directional = if i + 1 == k {
        // What the camera turns light into is its responsivity, from which that density follows.
        scene.camera().pdf_sight_at(path.scattering[k].x, -edge.direction)
    } else {
        after.interaction.pdf(edges[i + 1].direction, -edge.direction, after.component)
    };
    directional * edge.to_light_side
}

/// Whether strategy s (s vertices from the light, the rest from the eye) can make the path at all: its connection edge
/// touches no Dirac vertex, and with s = 0 the light is one that can be hit.
#[inline]
pub fn strategy_exists<R: Repertoire>(vertices: &[Vertex<R>], s: usize) -> bool {
    let k = vertices.len() - 1;
    if s > k {
        return false;
    }
    if s == 0 {
        return vertices[0].can_be_met();
    }
    let inner_connectable = |i: usize| i == 0 || i == k || vertices[i].is_connectable();
    inner_connectable(s - 1) && inner_connectable(s)
}

/// ln p_{s,t} of the path, for each s = 0 ..= k: the density with which each strategy makes it; -inf where it cannot.
pub fn ln_strategy_densities<R: Repertoire>(scene: &Scene<R>, path: &Path<R>) -> Vec<f64> {
    let k = path.length();
    (0..=k)
        .map(|s| {
            if !strategy_exists(&path.vertices, s) {
                return f64::NEG_INFINITY;
            }
            let from_light: f64 = (0..s).map(|i| libm::log(pdf_area_from_light(scene, path, i))).sum();
            let from_eye: f64 = (s..=k).map(|i| libm::log(pdf_area_from_eye(scene, path, i))).sum();
            from_light + from_eye
        })
        .collect()
}
