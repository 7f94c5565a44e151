//! A path: vertices from the light to the eye, the edges between them, and its class.

use std::fmt;

use ergodic_scattering::{Component, Rgb};
use glam::DVec2;

use crate::{Edge, Scene, Vertex};

/// A path x₀ x₁ … x_k: x₀ lies on a light, x_k on the camera's aperture, and neighbours see each other.
///
/// `edges[i]` lies between vertices i and i + 1. Edges, scattering and raster are derived from the vertices and cached;
/// [`Path::derive`] gives the same bits, as do [`Path::derive_edges`] and [`Path::derive_scattering`] for parts.
#[derive(Clone, Debug, Default)]
pub struct Path {
    /// Vertices from the light to the eye.
    pub vertices: Vec<Vertex>,
    /// The k edges between them.
    pub edges: Vec<Edge>,
    /// What each vertex turns the light from its light side into towards its eye side, the factors of f beside those of the edges: L_e
    /// at vertex 0, f_s at inner ones, the responsivity W_e at the camera.
    pub scattering: Vec<Rgb>,
    /// Where the last edge meets the image, if that lies in the camera's domain.
    pub raster: Option<DVec2>,
}

impl Path {
    /// A path with room for `edges` edges, so that it need not grow.
    pub fn with_capacity(edges: usize) -> Self {
        Self {
            vertices: Vec::with_capacity(edges + 1),
            edges: Vec::with_capacity(edges),
            scattering: Vec::with_capacity(edges + 1),
            raster: None,
        }
    }

    /// k, the number of edges.
    #[inline]
    pub fn length(&self) -> usize {
        self.vertices.len() - 1
    }

    /// Empties all lists.
    pub fn clear(&mut self) {
        self.vertices.clear();
        self.edges.clear();
        self.scattering.clear();
        self.raster = None;
    }

    /// Derives everything from the vertices.
    pub fn derive(&mut self, scene: &Scene) {
        self.edges.clear();
        self.edges.extend(self.vertices.windows(2).map(|pair| Edge::new(scene, &pair[0], &pair[1])));
        self.scattering.clear();
        self.scattering.resize(self.vertices.len(), Rgb::ZERO);
        self.derive_scattering(scene, 0, self.length());
    }

    /// Derives the edges `from..to` from the vertices.
    #[inline]
    pub fn derive_edges(&mut self, scene: &Scene, from: usize, to: usize) {
        for i in from..to {
            self.edges[i] = Edge::new(scene, &self.vertices[i], &self.vertices[i + 1]);
        }
    }

    /// Derives the scattering of the vertices `first ..= last`, and the raster point if the camera is among them. The edges at both
    /// sides of each must be there.
    #[inline]
    pub fn derive_scattering(&mut self, scene: &Scene, first: usize, last: usize) {
        let k = self.length();
        for i in first..=last {
            self.scattering[i] = if i == 0 {
                scene.emitted(&self.vertices[0], self.edges[0].direction)
            } else if i < k {
                let vertex = &self.vertices[i];
                vertex.interaction.eval(-self.edges[i - 1].direction, self.edges[i].direction, vertex.component)
            } else {
                let seen = scene.camera().seen(-self.edges[k - 1].direction);
                self.raster = seen.map(|(raster, _)| raster);
                Rgb::splat(seen.map_or(0.0, |(_, responsivity)| responsivity))
            };
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
