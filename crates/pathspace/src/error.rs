//! Why no scene could be built.

use ergodic_geometry::GeometryError;
use thiserror::Error;

/// Why a description makes no scene.
#[derive(Debug, Error)]
pub enum SceneError {
    /// Nothing to look at.
    #[error(
        "the scene has no triangles, so there is nothing to render; add a mesh with triangles to a node of the scene"
    )]
    NoTriangles,
    /// All vertices in one point, or not finite.
    #[error("all triangles of the scene lie in one point or reach to infinity; check the node transforms")]
    NoExtent,
    /// Nothing emits.
    #[error(
        "the scene has no light: give a material an emissiveFactor (with KHR_materials_emissive_strength for its \
         radiance), add a light by KHR_lights_punctual to a node, or give an environment"
    )]
    NoLight,
    /// The geometry was refused.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
}
