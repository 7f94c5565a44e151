//! A scene as a file states it: what `ergodic-assets` makes and [`Scene::new`](crate::Scene::new) builds from.

use ergodic_geometry::Mesh;
use ergodic_scattering::{Environment, Lens, Material, Medium, PunctualLight, Texture};
use glam::{DAffine3, DVec3};

use crate::Effects;

/// A mesh placed in the world with a material.
#[derive(Clone, Debug)]
pub struct Placement {
    /// Index into [`SceneDescription::meshes`].
    pub mesh: usize,
    /// Index into [`SceneDescription::materials`].
    pub material: usize,
    /// From the mesh's space to the world.
    pub transform: DAffine3,
}

/// A camera. It looks along its local -z with +y up, as glTF has it.
#[derive(Clone, Debug)]
pub struct CameraDescription {
    /// Name in the file; may be empty.
    pub name: String,
    /// From camera space to the world. Scale in it is ignored.
    pub transform: DAffine3,
    /// How it sees.
    pub projection: Projection,
}

/// How a camera sees. Widths follow from the picture's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Through a point or a lens.
    Perspective {
        /// Full vertical field of view in radians, in (0, pi).
        vertical_fov: f64,
        /// The lens, in units of the world; `None` for a pinhole.
        lens: Option<Lens>,
    },
    /// Along parallel lines, from a film across the axis.
    Orthographic {
        /// Full height of what the picture shows, in units of the world.
        height: f64,
        /// Distance of the film from the camera's origin along its axis: what lies nearer is not seen.
        near: f64,
    },
}

impl CameraDescription {
    /// A pinhole camera without a name, with a full vertical field of view in radians.
    pub fn pinhole(transform: DAffine3, vertical_fov: f64) -> Self {
        Self { name: String::new(), transform, projection: Projection::Perspective { vertical_fov, lens: None } }
    }
}

/// All that a scene is.
#[derive(Clone, Debug, Default)]
pub struct SceneDescription {
    /// Meshes, one for each glTF primitive.
    pub meshes: Vec<Mesh>,
    /// Where they stand.
    pub placements: Vec<Placement>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Textures, sRGB ones decoded.
    pub textures: Vec<Texture>,
    /// Lights of KHR_lights_punctual, in world space.
    pub lights: Vec<PunctualLight>,
    /// Light from infinitely far away, from every direction of world space. No glTF file states it.
    pub environment: Option<Environment>,
    /// What fills the space outside all solids: a ball around everything, the camera and the lights included. Coefficients are per
    /// unit of world length. No glTF file states it.
    pub medium: Medium,
    /// Effects that code is to be ready for though nothing here calls for them. It costs time and changes no picture.
    pub ready_for: Effects,
    /// The cameras the file has, in world space.
    pub cameras: Vec<CameraDescription>,
}

impl SceneDescription {
    /// The bounding box of all placed triangles; `None` without triangles.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let mut bounds: Option<(DVec3, DVec3)> = None;
        for placement in &self.placements {
            let Some(mesh) = self.meshes.get(placement.mesh) else { continue };
            for index in mesh.triangles.iter().flatten() {
                let Some(&position) = mesh.positions.get(*index as usize) else { continue };
                let p = placement.transform.transform_point3(position);
                bounds = Some(bounds.map_or((p, p), |(low, high)| (low.min(p), high.max(p))));
            }
        }
        bounds
    }
}
