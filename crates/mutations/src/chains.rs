//! Dirac chains: runs of specular vertices that a perturbation carries through with the same components.

use ergodic_pathspace::{Edge, Path, Scene, Vertex};
use ergodic_scattering::Component;
use glam::DVec3;

use crate::Rejection;

/// The direction in which a path continues at `vertex`, which stands in for a vertex of component `component`.
///
/// A Dirac component fixes the direction; the caller chooses it otherwise.
#[inline]
pub(crate) fn follow(vertex: &mut Vertex, w_from: DVec3, component: Component) -> Result<DVec3, Rejection> {
    vertex.component = component;
    vertex.interaction.dirac_direction(w_from, component).ok_or(Rejection::WrongComponent)
}

/// Traces the next vertex from `from`.
#[inline]
pub(crate) fn trace(scene: &Scene, from: &Vertex, w: DVec3) -> Result<Vertex, Rejection> {
    scene.trace(from, w).ok_or(Rejection::Escaped)
}

/// The density, without selection probabilities, with which a Dirac vertex passes light on: 1 for other vertices.
#[inline]
pub(crate) fn dirac_factor(vertex: &Vertex, w_to: DVec3) -> f64 {
    if vertex.component == Component::Rough { 1.0 } else { vertex.interaction.dirac_density(w_to, vertex.component) }
}

/// Finishes a candidate whose edge `i` connects two vertices given: both must be able to, and see each other.
#[inline]
pub(crate) fn connect(scene: &Scene, y: &mut Path, i: usize) -> Result<(), Rejection> {
    let (light_side, eye_side) = (&y.vertices[i], &y.vertices[i + 1]);
    if !scene.mutually_visible(light_side, eye_side) {
        return Err(Rejection::Occluded);
    }
    y.edges[i] = Edge::new(scene, light_side, eye_side);
    Ok(())
}

/// Writes to `y` a copy of `x`.
#[inline]
pub(crate) fn copy_path(x: &Path, y: &mut Path) {
    y.vertices.clone_from(&x.vertices);
    y.edges.clone_from(&x.edges);
}
