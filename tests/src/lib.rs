//! What the cross-crate tests share: the scenes of the repository, and exact weighted samples of paths in them.

use std::path::PathBuf;
use std::sync::Arc;

use ergodic_assets::load;
use ergodic_geometry::Mesh;
use ergodic_metropolis::RandomSource;
use ergodic_pathspace::{BidirectionalSampler, Lengths, Path, PathSpace, Roulette, Scene, SceneDescription, View};
use ergodic_scattering::luminance;
use glam::DVec3;

/// The folder of the repository.
pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The description of a scene of the repository.
pub fn description(name: &str) -> SceneDescription {
    let path = root().join("scenes").join(name).join("scene.glb");
    load(&path).unwrap_or_else(|e| panic!("{e}")).description
}

/// A scene seen by its first camera at `size`, with the box filter.
pub fn view_of(description: SceneDescription, size: (u32, u32)) -> Arc<Scene> {
    let camera = description.cameras.first().expect("the scenes have cameras").clone();
    let view = View { camera, width: size.0, height: size.1, margin: 0.0 };
    Arc::new(Scene::new(description, &view).unwrap_or_else(|e| panic!("{e}")))
}

/// A scene of the repository as a space of paths.
pub fn space(name: &str, size: (u32, u32), lengths: Lengths) -> PathSpace {
    PathSpace { scene: view_of(description(name), size), lengths }
}

/// A parallelogram; its front is where `u`, `v` run counter-clockwise.
pub fn quad(origin: DVec3, u: DVec3, v: DVec3) -> Mesh {
    Mesh {
        positions: vec![origin, origin + u, origin + u + v, origin + v],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// Paths with weights: the expectation of weight times h(path) is the integral of C h.
#[derive(Debug)]
pub struct PathSource<'a> {
    space: &'a PathSpace,
    sampler: BidirectionalSampler,
}

impl<'a> PathSource<'a> {
    /// Samples the space's paths bidirectionally.
    pub fn new(space: &'a PathSpace) -> Self {
        let roulette = Roulette { start: 5, survival: 0.8 };
        Self { space, sampler: BidirectionalSampler::new(space.lengths, roulette) }
    }

    /// Writes one path and returns its weight; `None` for a sample that found no light.
    ///
    /// Of all connections of one pair of walks one is taken with probability proportional to its contribution, and
    /// weighted by the sum.
    pub fn draw(&mut self, path: &mut Path, rng: &mut impl RandomSource) -> Option<f64> {
        let mut found: Vec<(usize, usize, f64)> = Vec::new();
        self.sampler.sample(&self.space.scene, rng, |_, c| {
            let weight = luminance(c.contribution());
            if weight > 0.0 {
                found.push((c.s, c.t, weight));
            }
        });
        let total: f64 = found.iter().map(|(_, _, w)| w).sum();
        let mut remaining = rng.uniform() * total;
        let &(mut s, mut t, _) = found.last()?;
        for &(a, b, weight) in &found {
            if remaining < weight {
                (s, t) = (a, b);
                break;
            }
            remaining -= weight;
        }
        self.sampler.assemble(&self.space.scene, s, t, path);
        Some(total)
    }
}

/// The examples of the README, compiled.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
