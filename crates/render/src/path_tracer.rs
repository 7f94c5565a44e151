//! Path tracing from the eye with next-event estimation, both weighted by the power heuristic (Veach 9, 10.3).

use std::marker::PhantomData;

use ergodic_metropolis::RandomSource;
use ergodic_pathspace::stability::{Place, is_usable};
use ergodic_pathspace::{Edge, End, Lengths, Roulette, Scene, Vertex};
use ergodic_scattering::{Component, Everything, Repertoire, Rgb, Wavelength};
use glam::DVec2;

use crate::sampling::Estimator;

/// The path tracer.
#[derive(Clone, Debug)]
pub struct PathTracer<R: Repertoire = Everything> {
    lengths: Lengths,
    roulette: Roulette,
    repertoire: PhantomData<R>,
}

impl<R: Repertoire> PathTracer<R> {
    /// A path tracer of paths of the given lengths.
    pub fn new(lengths: Lengths, roulette: Roulette) -> Self {
        Self { lengths, roulette, repertoire: PhantomData }
    }
}

/// The power heuristic with exponent 2 for one of two strategies.
fn power_heuristic(this: f64, other: f64) -> f64 {
    let ratio = other / this;
    1.0 / (1.0 + ratio * ratio)
}

/// The transmittance of an edge over the density of the walk's flight along it, to the light side.
fn arriving<R: Repertoire>(scene: &Scene<R>, edge: &Edge, light_side: &Vertex<R>, eye_side: &Vertex<R>) -> Rgb {
    if scene.scatters() {
        edge.transmittance / edge.flight(scene, light_side, eye_side, light_side)
    } else {
        edge.transmittance
    }
}

/// Light that reaches `vertex` straight from a sampled light, seen along `w_eye`; f over density, weighted.
///
/// `continues` is the probability that the walk would have sampled the next vertex.
fn next_event<R: Repertoire>(
    scene: &Scene<R>,
    vertex: &Vertex<R>,
    (w_eye, wavelength): (glam::DVec3, Wavelength),
    continues: f64,
    rng: &mut impl RandomSource,
) -> Rgb {
    let mut light = scene.camera_vertex();
    scene.sample_emitter(wavelength, &mut light, rng);
    let edge = Edge::new(scene, &light, vertex);
    let w_light = -edge.direction;
    let scattering = vertex.interaction.eval(w_light, w_eye, Component::Rough);
    let emitted = scene.emitted(&light, edge.direction);
    let carried = scattering * emitted * edge.transmittance * edge.geometry;
    if !is_usable(Place::NextEvent, carried) || carried.max_element() <= 0.0 || !scene.connects(&light, vertex, &edge) {
        return Rgb::ZERO;
    }
    let density = scene.emitter_pdf_area(&light);
    // 0 for a light without extent, which no walk can hit.
    let by_walk = vertex.interaction.pdf(w_eye, w_light, Component::Rough) * edge.to_light_side * continues;
    carried * (power_heuristic(density, by_walk) / density)
}

/// The names of the walk, which is one from the eye, and of the sampled lights to a [`RandomSource`].
const WALK: usize = End::Eye as usize;
const LIGHTS: usize = 1;

impl<R: Repertoire> Estimator for PathTracer<R> {
    type Repertoire = R;

    fn sample(&mut self, scene: &Scene<R>, rng: &mut impl RandomSource, mut splat: impl FnMut(DVec2, Rgb)) {
        let camera = scene.camera();
        let wavelength = scene.sample_wavelength(rng);
        let mut meets_dispersion = false;
        rng.enter(WALK, 0);
        // The image point comes first, for sources that choose it.
        let raster = camera.sample_raster([rng.uniform(), rng.uniform()]);
        let mut before = scene.sample_eye(rng);
        let sight = camera.sight(before.position, raster);
        let Some(raster) = camera.raster(&sight) else { return };
        let (mut sum, mut vertex) = (Rgb::ZERO, before);
        if !scene.look_along(&before, &sight, wavelength, &mut vertex, rng) {
            return;
        }
        let mut edge = Edge::new(scene, &vertex, &before);
        let mut throughput = arriving(scene, &edge, &vertex, &before) * camera.weight(&sight);
        // Area density with which the walk sampled the vertex it is at; `None` if no light sample could have.
        let mut pdf_walk: Option<f64> = None;
        for edges in 1..=self.lengths.max_edges {
            let w_eye = edge.direction;
            if edges >= self.lengths.min_edges && vertex.emits() {
                let weight = pdf_walk.map_or(1.0, |pdf| power_heuristic(pdf, scene.emitter_pdf_area(&vertex)));
                sum += throughput * scene.emitted(&vertex, w_eye) * weight;
            }
            if edges == self.lengths.max_edges || !vertex.scatters() {
                break;
            }
            if !meets_dispersion && !wavelength.is_none() && vertex.interaction.is_dispersive() {
                // From here on the light is of one wavelength.
                throughput *= wavelength.response();
                meets_dispersion = true;
            }
            let survival = self.roulette.survival(edges + 1);
            if edges + 1 >= self.lengths.min_edges && vertex.interaction.has_rough() {
                rng.enter(LIGHTS, edges);
                sum += throughput * next_event(scene, &vertex, (w_eye, wavelength), survival, rng);
            }
            rng.enter(WALK, edges);
            if survival < 1.0 && rng.uniform() >= survival {
                break;
            }
            let u = [rng.uniform(), rng.uniform(), rng.uniform()];
            let Some((w, component)) = vertex.interaction.sample(w_eye, u) else { break };
            let Some(next) = scene.look(&vertex, w, wavelength, rng) else { break };
            before = vertex;
            vertex = next;
            edge = Edge::new(scene, &vertex, &before);
            let w_light = -edge.direction;
            let pdf = before.interaction.pdf(w_eye, w_light, component);
            let cosine = if before.is_in_medium() { 1.0 } else { before.interaction.ng.dot(w_light).abs() };
            let scattering = before.interaction.eval(w_light, w_eye, component);
            throughput *= scattering * arriving(scene, &edge, &vertex, &before) * (cosine / (pdf * survival));
            if !is_usable(Place::EyeWalk, throughput) || throughput.max_element() <= 0.0 {
                break;
            }
            pdf_walk = (component == Component::Rough).then_some(pdf * edge.to_light_side * survival);
        }
        splat(raster, sum);
    }
}
