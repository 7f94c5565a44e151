//! What can be wrong with the meshes and instances a world is built from.

use thiserror::Error;

/// Why a [`World`](crate::World) could not be built. Numbers are those of the caller's lists.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum GeometryError {
    /// A vertex is NaN, infinite or too far out for its squares to be finite.
    #[error("mesh {mesh}: the position of vertex {vertex} is not finite or beyond 1e100")]
    Position {
        /// Index of the mesh.
        mesh: usize,
        /// Index of the vertex.
        vertex: usize,
    },
    /// A triangle names a vertex that does not exist.
    #[error("mesh {mesh}: triangle {triangle} refers to vertex {vertex}, but there are only {vertices} vertices")]
    VertexIndex {
        /// Index of the mesh.
        mesh: usize,
        /// Index of the triangle.
        triangle: usize,
        /// The index that is out of range.
        vertex: u32,
        /// How many vertices the mesh has.
        vertices: usize,
    },
    /// A vertex attribute does not have one entry a vertex.
    #[error("mesh {mesh}: {found} {attribute} for {vertices} vertices")]
    AttributeLength {
        /// Index of the mesh.
        mesh: usize,
        /// Which attribute.
        attribute: &'static str,
        /// How many entries it has.
        found: usize,
        /// How many vertices the mesh has.
        vertices: usize,
    },
    /// An instance names a mesh that does not exist.
    #[error("instance {instance} refers to mesh {mesh}, but there are only {meshes} meshes")]
    MeshIndex {
        /// Index of the instance.
        instance: usize,
        /// The index that is out of range.
        mesh: u32,
        /// How many meshes there are.
        meshes: usize,
    },
    /// A transform is NaN or infinite, or throws its mesh too far out for squares of coordinates to be finite.
    #[error("instance {instance}: its transform is not finite or throws mesh {mesh} beyond 1e100")]
    Transform {
        /// Index of the instance.
        instance: usize,
        /// Index of its mesh.
        mesh: u32,
    },
    /// The instances or triangles are too many: a mesh or a world has fewer than 2³², and a search tree at most 2²⁸.
    #[error("{count} {what} are more than can be searched: at most 268435456 in one tree")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// How many there are.
        count: usize,
    },
    /// The environment variable `ERGODIC_ISA` names instructions that this processor does not have, or that are not known.
    #[error("ERGODIC_ISA is `{name}`, but what there is on this processor is: {available}")]
    Instructions {
        /// What the variable names.
        name: String,
        /// All names that it may be, with commas.
        available: String,
    },
}
