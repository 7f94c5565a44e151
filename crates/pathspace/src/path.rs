//! A path: vertices from the light to the eye, the edges between them, and its class.

use std::cell::Cell;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

use ergodic_scattering::{Component, Everything, Repertoire, Rgb, Wavelength};
use glam::DVec2;

use crate::{Edge, Scene, Vertex};

/// A path x₀ x₁ … x_k: x₀ lies on a light, x_k on the camera's aperture, and neighbours see each other.
///
/// Where the scene disperses light, it has a wavelength too, whose measure is the share of [`Wavelength`]'s range. A path that meets no
/// dispersive interface is the same at all of them.
///
/// `edges[i]` lies between vertices i and i + 1. Edges, scattering and raster are derived from the vertices and cached;
/// [`Path::derive`] gives the same bits, as do [`Path::derive_edges`] and [`Path::derive_scattering`] for parts.
///
/// A path is points, not history; that it knows which other path it was made from is one more thing that is cached, so that what
/// two buffers of a chain have in common is not copied from one to the other again and again ([`Path::begin`]). Whoever changes
/// vertices other than those that `begin` leaves open calls [`Path::derive`] afterwards.
#[derive(Clone, Debug, Default)]
pub struct Path<R: Repertoire = Everything> {
    /// Vertices from the light to the eye.
    pub vertices: Vec<Vertex<R>>,
    /// The k edges between them.
    pub edges: Vec<Edge>,
    /// What each vertex turns the light from its light side into towards its eye side, the factors of f beside those of the edges: L_e
    /// at vertex 0, f_s at inner ones, the responsivity W_e at the camera.
    pub scattering: Vec<Rgb>,
    /// The wavelength that the dispersive interfaces among the vertices are those of; none in scenes without such interfaces. Whoever
    /// changes it places those vertices anew.
    pub wavelength: Wavelength,
    /// Where the last edge meets the image, if that lies in the camera's domain.
    pub raster: Option<DVec2>,
    /// Stands for the path as it is now; no two paths that differ have the same. 0 for none.
    version: u64,
    origin: Origin,
}

/// What a path has in common with the one that it was made from.
#[derive(Clone, Copy, Debug, Default)]
struct Origin {
    version: u64,
    /// Vertices at the light end.
    prefix: usize,
    /// Vertices at the eye end.
    suffix: usize,
}

/// A number that was never given before in this process.
#[inline]
fn fresh_version() -> u64 {
    thread_local! {
        static NEXT: Cell<u64> = const { Cell::new(0) };
    }
    let mut version = NEXT.get();
    if version as u32 == 0 {
        version = version_block();
    }
    NEXT.set(version + 1);
    version
}

/// The first of 2^32 - 1 numbers for one thread.
#[cold]
fn version_block() -> u64 {
    static BLOCKS: AtomicU64 = AtomicU64::new(0);
    BLOCKS.fetch_add(1, Ordering::Relaxed) << 32 | 1
}

impl<R: Repertoire> Path<R> {
    /// A path with room for `edges` edges, so that it need not grow.
    pub fn with_capacity(edges: usize) -> Self {
        Self {
            vertices: Vec::with_capacity(edges + 1),
            edges: Vec::with_capacity(edges),
            scattering: Vec::with_capacity(edges + 1),
            ..Self::default()
        }
    }

    /// k, the number of edges.
    #[inline]
    pub fn length(&self) -> usize {
        self.vertices.len() - 1
    }

    /// The path of these vertices, from the light to the eye, without a wavelength.
    pub fn of(scene: &Scene<R>, vertices: Vec<Vertex<R>>) -> Self {
        let mut path = Self { vertices, ..Self::default() };
        path.derive(scene);
        path
    }

    /// Makes this path one of `prefix + new + suffix` vertices whose ends are those of `x`, with the edges between them and their
    /// scattering. The vertices between the ends, the edges at both sides of each, and the scattering of all vertices at these
    /// edges are open: they hold anything, and the caller fills them.
    ///
    /// What this path has in common with `x` already, since one was made from the other, is not copied.
    #[inline]
    pub fn begin(&mut self, x: &Self, prefix: usize, new: usize, suffix: usize) {
        let length = prefix + new + suffix;
        let common = |origin: &Origin, version: u64| origin.version == version && version != 0;
        let (front, back) = if common(&self.origin, x.version) {
            (self.origin.prefix, self.origin.suffix)
        } else if common(&x.origin, self.version) {
            (x.origin.prefix, x.origin.suffix)
        } else {
            (0, 0)
        };
        // The lists begin at the light, so the eye end stays where it is only if the length does.
        let back = if self.vertices.len() == length { back } else { 0 };
        if self.vertices.len() != length {
            self.vertices.resize(length, x.vertices[0]);
            self.edges.resize(length - 1, x.edges[0]);
            self.scattering.resize(length, Rgb::ZERO);
        }

        copy_ends(&x.vertices, &mut self.vertices, (front, prefix), (back, suffix));
        // Of n vertices in common there are n - 1 edges, and n - 1 whose scattering is in common too.
        let (front, back) = (front.saturating_sub(1), back.saturating_sub(1));
        let edges = (prefix.saturating_sub(1), suffix.saturating_sub(1));
        copy_ends(&x.edges, &mut self.edges, (front, edges.0), (back, edges.1));
        copy_ends(&x.scattering, &mut self.scattering, (front, prefix), (back, suffix));
        self.wavelength = x.wavelength;
        self.raster = x.raster;
        self.version = fresh_version();
        self.origin = Origin { version: x.version, prefix, suffix };
    }

    /// One more open vertex before vertex `at`, which is open: for a part whose length is not known before it is made. The edge between
    /// the two is open too, as is the scattering at both.
    #[inline]
    pub fn open_before(&mut self, at: usize) {
        self.vertices.insert(at, self.vertices[at]);
        self.edges.insert(at, self.edges[at]);
        self.scattering.insert(at, Rgb::ZERO);
    }

    /// Says that the innermost vertices of the ends that were kept by [`Self::begin`] may change too.
    #[inline]
    pub fn release_ends(&mut self) {
        self.origin.prefix = self.origin.prefix.saturating_sub(1);
        self.origin.suffix = self.origin.suffix.saturating_sub(1);
    }

    /// Empties all lists.
    pub fn clear(&mut self) {
        self.vertices.clear();
        self.edges.clear();
        self.scattering.clear();
        self.wavelength = Wavelength::NONE;
        self.raster = None;
        self.version = 0;
        self.origin = Origin::default();
    }

    /// Derives everything from the vertices.
    pub fn derive(&mut self, scene: &Scene<R>) {
        self.edges.clear();
        self.edges.extend(self.vertices.windows(2).map(|pair| Edge::new(scene, &pair[0], &pair[1])));
        self.scattering.clear();
        self.scattering.resize(self.vertices.len(), Rgb::ZERO);
        self.derive_scattering(scene, 0, self.length());
        self.version = fresh_version();
        self.origin = Origin::default();
    }

    /// Derives the edges `from..to` from the vertices.
    #[inline(always)]
    pub fn derive_edges(&mut self, scene: &Scene<R>, from: usize, to: usize) {
        for i in from..to {
            self.edges[i] = Edge::new(scene, &self.vertices[i], &self.vertices[i + 1]);
        }
    }

    /// Derives the scattering of the vertices `first ..= last`, and the raster point if the camera is among them. The edges at both
    /// sides of each must be there.
    #[inline]
    pub fn derive_scattering(&mut self, scene: &Scene<R>, first: usize, last: usize) {
        let k = self.length();
        for i in first..=last {
            self.scattering[i] = if i == 0 {
                scene.emitted(&self.vertices[0], self.edges[0].direction)
            } else if i < k {
                let vertex = &self.vertices[i];
                vertex.interaction.eval(-self.edges[i - 1].direction, self.edges[i].direction, vertex.component)
            } else {
                let sight = self.edges[k - 1].sight(&self.vertices[k - 1], &self.vertices[k]);
                let seen = scene.camera().seen(&sight);
                self.raster = seen.map(|(raster, _)| raster);
                Rgb::splat(seen.map_or(0.0, |(_, responsivity)| responsivity))
            };
        }
    }

    /// What f is multiplied by for its wavelength, if the path meets a dispersive interface on its way.
    #[inline]
    pub fn response(&self) -> Option<Rgb> {
        if !R::DISPERSION || self.wavelength.is_none() {
            return None;
        }
        let inner = &self.vertices[1..self.length()];
        inner.iter().any(|vertex| vertex.interaction.is_dispersive()).then(|| self.wavelength.response())
    }

    /// Whether neighbours see each other, by tracing every edge again.
    pub fn is_unoccluded(&self, scene: &Scene<R>) -> bool {
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

/// Copies the first and the last items of a list that another does not have already: `(common, wanted)` at each end.
#[inline]
fn copy_ends<T: Copy>(from: &[T], to: &mut [T], (front, prefix): (usize, usize), (back, suffix): (usize, usize)) {
    if front < prefix {
        to[front..prefix].copy_from_slice(&from[front..prefix]);
    }
    if back < suffix {
        let (from_end, to_end) = (from.len(), to.len());
        to[to_end - suffix..to_end - back].copy_from_slice(&from[from_end - suffix..from_end - back]);
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

impl PathClass {
    /// Stands for what is several paths at once, as a sample of bidirectional path tracing is.
    pub const MANY: Self = Self { length: 0, specular: 0 };
}

impl fmt::Display for PathClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if *self == Self::MANY {
            return write!(f, "of many classes");
        }
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
