//! Random walks from a light or from the eye (Veach 10.1), with the densities and throughputs that connections need.

use ergodic_metropolis::RandomSource;
use ergodic_scattering::{Component, Everything, Repertoire, Rgb, Wavelength};

use crate::stability::{Place, is_usable};
use crate::{Edge, Scene, Vertex};

/// When random walks are ended early.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roulette {
    /// Number of vertices of a subpath that are always allowed.
    pub start: usize,
    /// Probability with which each further vertex is sampled, in (0, 1].
    pub survival: f64,
}

impl Roulette {
    /// No roulette: walks end at their greatest length only.
    pub const OFF: Self = Self { start: usize::MAX, survival: 1.0 };

    /// The probability that vertex `index` (counted from the walk's own start) is sampled, given that the one before was.
    ///
    /// It depends on the index alone, so that the density of a path can be computed from its points.
    #[inline]
    pub fn survival(&self, index: usize) -> f64 {
        if index < self.start { 1.0 } else { self.survival }
    }
}

/// Which end a walk starts from. As a number it names the walk to a [`RandomSource`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// From the camera.
    Eye,
    /// From a light.
    Light,
}

/// A walk: vertex 0 is the endpoint. All four lists beside the vertices are caches derived from them.
#[derive(Clone, Debug)]
pub struct Subpath<R: Repertoire = Everything> {
    end: End,
    /// The numbers that choose the image point of a walk from a lens.
    image_point: Option<[f64; 2]>,
    /// The wavelength that walks are for, [`Wavelength::NONE`] where the scene does not disperse.
    pub wavelength: Wavelength,
    /// Vertices in the order in which they were sampled. The component of each says how the walk left it.
    pub vertices: Vec<Vertex<R>>,
    /// `edges[i]` between vertices i and i + 1, oriented as light flows.
    pub edges: Vec<Edge>,
    /// Area density of each vertex given those before it, without roulette.
    pub pdf_area: Vec<f64>,
    /// Area density of vertex i sampled from vertex i + 1 coming from i + 2; one entry less than two edges give.
    pub pdf_area_reverse: Vec<f64>,
    /// Throughput α (Veach 10.1): f over density of the walk up to each vertex, roulette included.
    pub throughput: Vec<Rgb>,
}

impl<R: Repertoire> Subpath<R> {
    /// An empty walk with room for `vertices` vertices.
    pub fn new(end: End, vertices: usize) -> Self {
        Self {
            end,
            image_point: None,
            wavelength: Wavelength::NONE,
            vertices: Vec::with_capacity(vertices),
            edges: Vec::with_capacity(vertices),
            pdf_area: Vec::with_capacity(vertices),
            pdf_area_reverse: Vec::with_capacity(vertices),
            throughput: Vec::with_capacity(vertices),
        }
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Whether there is no vertex.
    pub fn is_empty(&self) -> bool {
        self.vertices.is_empty()
    }

    fn edge(&self, scene: &Scene<R>, from: &Vertex<R>, to: &Vertex<R>) -> Edge {
        match self.end {
            End::Light => Edge::new(scene, from, to),
            End::Eye => Edge::new(scene, to, from),
        }
    }

    fn place(&self) -> Place {
        match self.end {
            End::Light => Place::LightWalk,
            End::Eye => Place::EyeWalk,
        }
    }

    /// The unit direction of travel along an edge of this walk.
    fn travel(&self, edge: &Edge) -> glam::DVec3 {
        match self.end {
            End::Light => edge.direction,
            End::Eye => -edge.direction,
        }
    }

    /// From a solid-angle density at the edge's start to an area density at its end, in the direction of travel.
    fn to_area(&self, edge: &Edge) -> f64 {
        match self.end {
            End::Light => edge.to_eye_side,
            End::Eye => edge.to_light_side,
        }
    }

    fn to_area_reverse(&self, edge: &Edge) -> f64 {
        match self.end {
            End::Light => edge.to_light_side,
            End::Eye => edge.to_eye_side,
        }
    }

    /// Walks anew, to at most `most` vertices.
    pub fn walk(&mut self, scene: &Scene<R>, most: usize, roulette: &Roulette, rng: &mut impl RandomSource) {
        self.vertices.clear();
        self.edges.clear();
        self.pdf_area.clear();
        self.pdf_area_reverse.clear();
        self.throughput.clear();
        rng.enter(self.end as usize, 0);
        let (start, pdf) = match self.end {
            End::Eye => {
                // The image point comes before that of the lens, for sources that choose it.
                let has_aperture = scene.camera().has_aperture();
                self.image_point = has_aperture.then(|| [rng.uniform(), rng.uniform()]);
                let vertex = scene.sample_eye(rng);
                let pdf = scene.eye_pdf_area(&vertex);
                (vertex, pdf)
            }
            End::Light => {
                let mut vertex = scene.camera_vertex();
                scene.sample_emitter(self.wavelength, &mut vertex, rng);
                let pdf = scene.emitter_pdf_area(&vertex);
                (vertex, pdf)
            }
        };
        self.vertices.push(start);
        self.pdf_area.push(pdf);
        self.throughput.push(Rgb::splat(1.0 / pdf));
        while self.len() < most && self.extend(scene, roulette, rng).is_some() {}
    }

    /// Samples one more vertex; `None` where the walk ends.
    fn extend(&mut self, scene: &Scene<R>, roulette: &Roulette, rng: &mut impl RandomSource) -> Option<()> {
        let i = self.len() - 1;
        rng.enter(self.end as usize, i + 1);
        let survival = roulette.survival(i + 1);
        if survival < 1.0 && rng.uniform() >= survival {
            return None;
        }
        let (next, edge, pdf, scattered) =
            if i == 0 { self.first_step(scene, rng)? } else { self.scatter(scene, rng)? };
        if scene.has_partial_coverage() && edge.geometry <= 0.0 {
            // The ray came through where the segment between the points, which starts elsewhere by rounding, does not.
            return None;
        }
        let pdf_area = pdf * self.to_area(&edge);
        let throughput =
            self.throughput[i] * scattered * (edge.transmittance * (edge.geometry / (pdf_area * survival)));
        if !is_usable(self.place(), throughput) || throughput.max_element() <= 0.0 {
            return None;
        }
        if i >= 1 {
            // Known only now that the direction in which the walk leaves vertex i is fixed.
            let here = &self.vertices[i];
            let back = -self.travel(&self.edges[i - 1]);
            let reverse = here.interaction.pdf(self.travel(&edge), back, here.component);
            self.pdf_area_reverse.push(reverse * self.to_area_reverse(&self.edges[i - 1]));
        }
        self.vertices.push(next);
        self.edges.push(edge);
        self.pdf_area.push(pdf_area);
        self.throughput.push(throughput);
        // From the environment nothing goes on.
        next.scatters().then_some(())
    }

    fn first_step(&self, scene: &Scene<R>, rng: &mut impl RandomSource) -> Option<(Vertex<R>, Edge, f64, Rgb)> {
        let start = &self.vertices[0];
        match self.end {
            End::Light => {
                let mut next = *start;
                if !scene.sample_emission(start, self.wavelength, &mut next, rng) {
                    return None;
                }
                let edge = self.edge(scene, start, &next);
                let pdf = scene.emission_pdf(start, edge.direction);
                Some((next, edge, pdf, scene.emitted(start, edge.direction)))
            }
            End::Eye => {
                let camera = scene.camera();
                let raster = camera.sample_raster(self.image_point.unwrap_or_else(|| [rng.uniform(), rng.uniform()]));
                let sight = camera.sight(start.position, raster);
                let mut next = *start;
                if !scene.look_along(start, &sight, self.wavelength, &mut next, rng) {
                    return None;
                }
                let edge = self.edge(scene, start, &next);
                let seen = edge.sight(&next, start);
                Some((next, edge, camera.pdf_sight(&seen), Rgb::splat(camera.responsivity(&seen))))
            }
        }
    }

    fn scatter(&mut self, scene: &Scene<R>, rng: &mut impl RandomSource) -> Option<(Vertex<R>, Edge, f64, Rgb)> {
        let i = self.len() - 1;
        let w_from = -self.travel(&self.edges[i - 1]);
        let u = [rng.uniform(), rng.uniform(), rng.uniform()];
        let here = &mut self.vertices[i];
        let (w_to, component) = here.interaction.sample(w_from, u)?;
        here.component = component;
        let here = self.vertices[i];
        let next = match self.end {
            End::Light => scene.trace(&here, w_to, self.wavelength, rng),
            End::Eye => scene.look(&here, w_to, self.wavelength, rng),
        };
        let Some(next) = next else {
            self.vertices[i].component = Component::Rough;
            return None;
        };
        let edge = self.edge(scene, &here, &next);
        let w_to = self.travel(&edge);
        let pdf = here.interaction.pdf(w_from, w_to, component);
        let scattered = match self.end {
            End::Light => here.interaction.eval(w_from, w_to, component),
            End::Eye => here.interaction.eval(w_to, w_from, component),
        };
        Some((next, edge, pdf, scattered))
    }
}
