//! Bidirectional sampling (Veach 10): two walks, every connection between them, each weighted by the power heuristic.

use ergodic_metropolis::RandomSource;
use ergodic_scattering::{Component, Everything, Repertoire, Rgb};
use glam::DVec2;

use crate::stability::{Place, is_usable, is_usable_number};
use crate::subpath::{End, Roulette, Subpath};
use crate::{Edge, Path, PathClass, Scene, Vertex};

/// Which paths are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lengths {
    /// Least number of edges.
    pub min_edges: usize,
    /// Greatest number of edges.
    pub max_edges: usize,
}

/// One way of making a path in a pair of walks.
#[derive(Clone, Copy, Debug)]
pub struct Connection {
    /// Vertices from the light.
    pub s: usize,
    /// Vertices from the eye.
    pub t: usize,
    /// f over the density of the strategy, per channel, for the mean over the image.
    pub estimate: Rgb,
    /// Multiple importance sampling weight, in [0, 1].
    pub weight: f64,
    /// Where the path meets the image.
    pub raster: DVec2,
}

impl Connection {
    /// What the path adds to the estimate of the mean over the image, per channel.
    pub fn contribution(&self) -> Rgb {
        self.estimate * self.weight
    }
}

/// A pair of walks and the connections between them.
#[derive(Clone, Debug)]
pub struct BidirectionalSampler<R: Repertoire = Everything> {
    /// The walk from the light.
    pub light: Subpath<R>,
    /// The walk from the eye.
    pub eye: Subpath<R>,
    lengths: Lengths,
    roulette: Roulette,
}

/// What a connection changes in the densities of the joint path: those of the two vertices at each of its ends.
struct Joint<'a, R: Repertoire> {
    light: &'a Subpath<R>,
    eye: &'a Subpath<R>,
    s: usize,
    t: usize,
    /// Area density, from the light, of the eye walk's last vertex and of the one before it.
    from_light: [f64; 2],
    /// Area density, from the eye, of the light walk's last vertex and of the one before it.
    from_eye: [f64; 2],
}

impl<R: Repertoire> BidirectionalSampler<R> {
    /// A sampler of paths of the given lengths.
    pub fn new(lengths: Lengths, roulette: Roulette) -> Self {
        let most = lengths.max_edges + 1;
        Self { light: Subpath::new(End::Light, most), eye: Subpath::new(End::Eye, most), lengths, roulette }
    }

    /// Draws the wavelength that both walks of a sample are for.
    pub fn draw_wavelength(&mut self, scene: &Scene<R>, rng: &mut impl RandomSource) {
        let wavelength = scene.sample_wavelength(rng);
        (self.light.wavelength, self.eye.wavelength) = (wavelength, wavelength);
    }

    /// Walks from both ends, then calls `sink` for every connection that carries light.
    pub fn sample(&mut self, scene: &Scene<R>, rng: &mut impl RandomSource, mut sink: impl FnMut(&Self, Connection)) {
        self.walk(scene, (self.lengths.max_edges, self.lengths.max_edges + 1), rng);
        for t in 1..=self.eye.len() {
            for s in 0..=self.light.len() {
                let edges = (s + t).wrapping_sub(1);
                if edges < self.lengths.min_edges.max(1) || edges > self.lengths.max_edges {
                    continue;
                }
                if let Some(connection) = self.connect(scene, s, t) {
                    sink(self, connection);
                }
            }
        }
    }

    /// Walks as [`Self::sample`] does with the same numbers, but only as far as the path of one connection needs it: then
    /// [`Self::assemble`] gives that path.
    pub fn walk_for(&mut self, scene: &Scene<R>, (s, t): (usize, usize), rng: &mut impl RandomSource) {
        // The numbers of the walk from the light come after all those of the walk from the eye.
        let from_eye = if s > 0 { self.lengths.max_edges + 1 } else { t };
        self.walk(scene, (s, from_eye), rng);
    }

    /// Walks from both ends, up to so many vertices from the light and from the eye. The walk from the light is left as it is if it is to
    /// have none.
    fn walk(&mut self, scene: &Scene<R>, (from_light, from_eye): (usize, usize), rng: &mut impl RandomSource) {
        self.draw_wavelength(scene, rng);
        self.eye.walk(scene, from_eye, &self.roulette, rng);
        if from_light > 0 {
            self.light.walk(scene, from_light, &self.roulette, rng);
        }
    }

    /// Connects the first `s` vertices of the light walk with the first `t` of the eye walk.
    pub fn connect(&self, scene: &Scene<R>, s: usize, t: usize) -> Option<Connection> {
        let (mut estimate, joint) = if s == 0 { self.hit_light(scene, t)? } else { self.join(scene, s, t)? };
        let eye = &self.eye.vertices[0];
        let seen = if t == 1 {
            let last = &self.light.vertices[s - 1];
            Edge::new(scene, last, eye).sight(last, eye)
        } else {
            self.eye.edges[0].sight(&self.eye.vertices[1], eye)
        };
        let raster = scene.camera().raster(&seen)?;
        let weight = joint.weight(&self.roulette);
        if !is_usable_number(Place::Weight, weight) {
            return None;
        }
        if R::DISPERSION && !self.eye.wavelength.is_none() && self.is_dispersive(s, t) {
            estimate *= self.eye.wavelength.response();
        }
        Some(Connection { s, t, estimate, weight, raster })
    }

    /// Whether the path of a connection meets a dispersive interface between its ends.
    fn is_dispersive(&self, s: usize, t: usize) -> bool {
        let of_light = self.light.vertices[..s].iter().skip(1);
        // Without a vertex from the light, the last from the eye is the light's end of the path.
        let of_eye = self.eye.vertices[..if s == 0 { t - 1 } else { t }].iter().skip(1);
        of_light.chain(of_eye).any(|vertex| vertex.interaction.is_dispersive())
    }

    /// s = 0: the eye walk's last vertex lies on a light.
    fn hit_light(&self, scene: &Scene<R>, t: usize) -> Option<(Rgb, Joint<'_, R>)> {
        if t < 2 {
            return None;
        }
        let eye = &self.eye;
        let vertex = &eye.vertices[t - 1];
        if !vertex.emits() {
            return None;
        }
        let towards = eye.edges[t - 2].direction;
        let estimate = eye.throughput[t - 1] * scene.emitted(vertex, towards);
        if !is_usable(Place::Connection, estimate) || estimate.max_element() <= 0.0 {
            return None;
        }
        let before = scene.emission_pdf(vertex, towards) * eye.edges[t - 2].to_eye_side;
        let from_light = [scene.emitter_pdf_area(vertex), before];
        let joint = Joint { light: &self.light, eye, s: 0, t, from_light, from_eye: [0.0; 2] };
        Some((estimate, joint))
    }

    /// s > 0: a connecting edge between the two walks.
    fn join(&self, scene: &Scene<R>, s: usize, t: usize) -> Option<(Rgb, Joint<'_, R>)> {
        let (light, eye) = (&self.light, &self.eye);
        let y = &light.vertices[s - 1];
        let z = &eye.vertices[t - 1];
        if (s > 1 && !y.interaction.has_rough()) || (t > 1 && !z.interaction.has_rough()) {
            return None;
        }
        let edge = Edge::new(scene, y, z);
        let w = edge.direction;
        let from_y = if s == 1 {
            scene.emitted(y, w)
        } else {
            y.interaction.eval(-light.edges[s - 2].direction, w, Component::Rough)
        };
        let from_z = if t == 1 {
            Rgb::splat(scene.camera().responsivity(&edge.sight(y, z)))
        } else {
            z.interaction.eval(-w, eye.edges[t - 2].direction, Component::Rough)
        };
        let estimate =
            light.throughput[s - 1] * from_y * (edge.geometry * edge.transmittance) * from_z * eye.throughput[t - 1];
        if !is_usable(Place::Connection, estimate) || estimate.max_element() <= 0.0 || !scene.connects(y, z, &edge) {
            return None;
        }
        let pdf_y_to_z = if s == 1 { scene.emission_pdf(y, w) } else { rough_pdf(y, -light.edges[s - 2].direction, w) };
        let pdf_z_to_y = if t == 1 {
            scene.camera().pdf_sight(&edge.sight(y, z))
        } else {
            rough_pdf(z, eye.edges[t - 2].direction, -w)
        };
        // The camera cannot be hit, so with t = 1 its own density from the light stays 0.
        let z_from_light = if t == 1 { 0.0 } else { pdf_y_to_z * edge.to_eye_side };
        let before_z =
            if t > 2 { rough_pdf(z, -w, eye.edges[t - 2].direction) * eye.edges[t - 2].to_eye_side } else { 0.0 };
        let before_y =
            if s > 1 { rough_pdf(y, w, -light.edges[s - 2].direction) * light.edges[s - 2].to_light_side } else { 0.0 };
        let joint = Joint {
            light,
            eye,
            s,
            t,
            from_light: [z_from_light, before_z],
            from_eye: [pdf_z_to_y * edge.to_light_side, before_y],
        };
        Some((estimate, joint))
    }

    /// The class of the path of a connection.
    pub fn class(&self, s: usize, t: usize) -> PathClass {
        let k = s + t - 1;
        let mut specular = 0;
        // The vertices next to the connecting edge are rough on this path, whatever the walk chose there to go on.
        for i in (1..k.min(65)).filter(|i| i + 1 != s && *i != s) {
            let vertex = if i < s { &self.light.vertices[i] } else { &self.eye.vertices[k - i] };
            specular |= u64::from(vertex.component != Component::Rough) << (i - 1);
        }
        PathClass { length: k as u32, specular }
    }

    /// The complete path of a connection, as points.
    pub fn assemble(&self, scene: &Scene<R>, s: usize, t: usize, path: &mut Path<R>) {
        path.clear();
        path.wavelength = self.eye.wavelength;
        path.vertices.extend_from_slice(&self.light.vertices[..s]);
        path.vertices.extend(self.eye.vertices[..t].iter().rev());
        let k = s + t - 1;
        // A walk's last vertex may have gone on by a Dirac component; on this path it is an end of the connection.
        for i in [s.wrapping_sub(1), s, 0, k] {
            if let Some(vertex) = path.vertices.get_mut(i) {
                vertex.component = Component::Rough;
            }
        }
        path.derive(scene);
    }
}

fn rough_pdf<R: Repertoire>(vertex: &Vertex<R>, w_from: glam::DVec3, w_to: glam::DVec3) -> f64 {
    vertex.interaction.pdf(w_from, w_to, Component::Rough)
}

impl<R: Repertoire> Joint<'_, R> {
    /// Area density of path vertex `i` from the light.
    fn pdf_from_light(&self, i: usize) -> f64 {
        if i < self.s {
            return self.light.pdf_area[i];
        }
        match i - self.s {
            offset @ (0 | 1) => self.from_light[offset],
            _ => self.eye.pdf_area_reverse[self.s + self.t - 1 - i],
        }
    }

    /// Area density of path vertex `i` from the eye.
    fn pdf_from_eye(&self, i: usize) -> f64 {
        if i >= self.s {
            return self.eye.pdf_area[self.s + self.t - 1 - i];
        }
        match self.s - 1 - i {
            offset @ (0 | 1) => self.from_eye[offset],
            _ => self.light.pdf_area_reverse[i],
        }
    }

    /// Whether a connection may end at path vertex `i`.
    fn connectable(&self, i: usize) -> bool {
        let k = self.s + self.t - 1;
        if i == 0 || i == k || i + 1 == self.s || i == self.s {
            return true;
        }
        if i < self.s { self.light.vertices[i].is_connectable() } else { self.eye.vertices[k - i].is_connectable() }
    }

    /// The power heuristic with exponent 2 (Veach 9.2.4), by ratios of neighbouring strategies (Veach 10.2.1).
    fn weight(&self, roulette: &Roulette) -> f64 {
        let k = self.s + self.t - 1;
        let mut sum = 1.0;
        // More vertices from the light: p_{i+1} / p_i = from_light(i) / from_eye(i). The last is the camera, not hit.
        let mut ratio = 1.0;
        for i in self.s..k {
            ratio *= self.pdf_from_light(i) * roulette.survival(i) / (self.pdf_from_eye(i) * roulette.survival(k - i));
            if ratio == 0.0 {
                break;
            }
            if self.connectable(i) && self.connectable(i + 1) {
                sum += ratio * ratio;
            }
        }
        // Fewer.
        let mut ratio = 1.0;
        for i in (0..self.s).rev() {
            ratio *= self.pdf_from_eye(i) * roulette.survival(k - i) / (self.pdf_from_light(i) * roulette.survival(i));
            if ratio == 0.0 {
                break;
            }
            // Strategy s = i connects vertices i - 1 and i; s = 0 hits the light, whose density from the eye is 0 if it
            // cannot be hit.
            if i == 0 || (self.connectable(i - 1) && self.connectable(i)) {
                sum += ratio * ratio;
            }
        }
        1.0 / sum
    }
}
