//! A path: vertices from the light to the eye, the edges between them, and its class.

use std::fmt;

use ergodic_scattering::Component;

use crate::{Edge, Scene, Vertex};

/// A path x₀ x₁ … x_k: x₀ lies on a light, x_k on the camera's aperture, and neighbours see each other.
///
/// `edges[i]` lies between vertices i and i + 1. Edges are derived from the vertices and cached; [`Path::recompute_edges`]
/// gives the same bits.
#[derive(Clone, Debug, Default)]
pub struct Path {
    /// Vertices from the light to the eye.
    pub vertices: Vec<Vertex>,
    /// The k edges between them.
    pub edges: Vec<Edge>,
}

impl Path {
    /// A path with room for `edges` edges, so that it need not grow.
    pub fn with_capacity(edges: usize) -> Self {
        Self { vertices: Vec::with_capacity(edges + 1), edges: Vec::with_capacity(edges) }
    }

    /// k, the number of edges.
    #[inline]
    pub fn length(&self) -> usize {
        self.vertices.len() - 1
    }

    /// Empties both lists.
    pub fn clear(&mut self) {
        self.vertices.clear();
        self.edges.clear();
    }

    /// Derives all edges from the vertices.
    pub fn recompute_edges(&mut self, scene: &Scene) {
        self.edges.clear();
        self.edges.extend(self.vertices.windows(2).map(|pair| Edge::new(scene, &pair[0], &pair[1])));
    }

    /// Derives the edges `from..to` from the vertices; the others must be up to date.
    #[inline]
    pub fn recompute_edges_between(&mut self, scene: &Scene, from: usize, to: usize) {
        for i in from..to {
            self.edges[i] = Edge::new(scene, &self.vertices[i], &self.vertices[i + 1]);
        }
    }

    /// Whether neighbours see each other, by tracing every edge again.
    pub fn is_unoccluded(&self, scene: &Scene) -> bool {
        self.vertices.windows(2).all(|pair| scene.mutually_visible(&pair[0], &pair[1]))
    }

    /// The class of the path.
    #[inline]
    pub fn class(&self) -> PathClass {
        let k = self.length();
        let mut specular = 0u64;
        for (i, vertex) in self.vertices[1..k].iter().enumerate().take(64) {
            specular |= u64::from(vertex.component != Component::Rough) << i;
        }
        PathClass { length: k as u32, specular }
    }
}

/// Heckbert's class of a path (Heckbert 1990): which of its inner vertices scatter specularly (S) and which do not (D).
///
/// Written from the light to the eye, as in `LSDE`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PathClass {
    /// Number of edges.
    pub length: u32,
    /// Bit i is set when vertex i + 1 is specular. Vertices beyond the 64th are not told apart.
    pub specular: u64,
}

impl fmt::Display for PathClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "L")?;
        for i in 0..self.length.saturating_sub(1) {
            write!(f, "{}", if i < 64 && self.specular >> i & 1 == 1 { 'S' } else { 'D' })?;
        }
        write!(f, "E")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_written_from_the_light_to_the_eye() {
        assert_eq!(PathClass { length: 1, specular: 0 }.to_string(), "LE");
        assert_eq!(PathClass { length: 3, specular: 0b01 }.to_string(), "LSDE");
        assert_eq!(PathClass { length: 4, specular: 0b110 }.to_string(), "LDSSE");
    }
}
