//! What the cross-crate tests share: the scenes of the repository, scenes built in code, exact weighted samples of paths,
//! means over replicas.

mod dispersive;
mod estimate;
mod eye;
mod layered;
mod shapes;
mod source;

pub use dispersive::{DISPERSIVE_INDEX, dispersive_room};
pub use estimate::{Estimate, estimate, image, nightly, settings};
pub use eye::Eye;
pub use layered::layered_room;
pub use shapes::{Thing, cuboid, description_of, diffuse, glass, mirror, quad, scene_of, sphere};
pub use source::PathSource;

use std::path::PathBuf;

use ergodic_assets::{load, load_environment};
use ergodic_pathspace::{Lengths, PathSpace, Scene, SceneDescription, View};

/// The folder of the repository.
pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The description of a scene of the repository, with the sky beside it if there is one.
pub fn description(name: &str) -> SceneDescription {
    let folder = root().join("scenes").join(name);
    let mut description = load(&folder.join("scene.glb")).unwrap_or_else(|e| panic!("{e}")).description;
    let sky = folder.join("sky.hdr");
    if sky.exists() {
        let (environment, _) = load_environment(&sky, 1.0, 0.0).unwrap_or_else(|e| panic!("{e}"));
        description.environment = Some(environment);
    }
    description
}

/// A scene seen by its first camera at `size`, with the box filter.
pub fn view_of(description: SceneDescription, size: (u32, u32)) -> Scene {
    let camera = description.cameras.first().expect("the scenes have cameras").clone();
    let view = View { camera, width: size.0, height: size.1, margin: 0.0, crop: None };
    Scene::new(description, &view).unwrap_or_else(|e| panic!("{e}"))
}

/// A scene of the repository as a space of paths.
pub fn space(name: &str, size: (u32, u32), lengths: Lengths) -> PathSpace {
    PathSpace { scene: view_of(description(name), size), lengths }
}

/// The examples of the README, compiled.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
