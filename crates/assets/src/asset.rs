//! A scene that was loaded, and the choice of a camera in it.

use std::f64::consts::PI;

use ergodic_pathspace::{CameraDescription, SceneDescription};
use ergodic_scattering::PunctualLight;
use glam::{DAffine3, DMat3, DVec3};
use thiserror::Error;

/// What a file holds.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Asset {
    /// The file, for messages.
    pub file: String,
    /// The scene.
    pub description: SceneDescription,
    /// What the file has that the picture will lack, one sentence each.
    pub warnings: Vec<String>,
    /// How the file is shown where that is a choice, and hints, one sentence each.
    pub notes: Vec<String>,
    /// Facts about the file itself.
    pub summary: Summary,
}

/// Facts about a file that the scene does not show.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// The glTF version it states.
    pub version: String,
    /// The program that wrote it.
    pub generator: Option<String>,
    /// Whose it is.
    pub copyright: Option<String>,
    /// Extensions it uses.
    pub extensions_used: Vec<String>,
    /// Extensions it cannot do without.
    pub extensions_required: Vec<String>,
    /// Names of its variants (KHR_materials_variants).
    pub variants: Vec<String>,
    /// For each camera of the description its number in the file and the camera's own name, which may differ from the
    /// node's name that the description has.
    pub cameras: Vec<(usize, String)>,
}

/// Why no camera could be chosen.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum CameraError {
    /// There are cameras, but not this one.
    #[error("{file} has no camera {wanted:?}. Its cameras are {known}")]
    Unknown {
        /// The file.
        file: String,
        /// What was asked for.
        wanted: String,
        /// The cameras there are.
        known: String,
    },
    /// There is no camera to ask for.
    #[error("{file} has no camera, so there is none {wanted:?}. Leave the camera out to see the whole scene")]
    None {
        /// The file.
        file: String,
        /// What was asked for.
        wanted: String,
    },
    /// Several cameras have this name.
    #[error("{file} has several cameras named {wanted:?}. Give one of the numbers {numbers}")]
    Ambiguous {
        /// The file.
        file: String,
        /// What was asked for.
        wanted: String,
        /// Their numbers.
        numbers: String,
    },
    /// There is nothing to look at.
    #[error("{file} has no camera, and no triangles to place one before. Add a mesh to the scene")]
    Nothing {
        /// The file.
        file: String,
    },
}

/// Vertical field of view of the camera that is made for a file that has none.
const FRAMING_FOV: f64 = 40.0 * PI / 180.0;

/// From here on an intensity in W/sr is more likely one in candela: a lamp of 10 W shines with 0.8 W/sr, or 540 cd.
const BRIGHT_INTENSITY: f64 = 500.0;
/// From here on an irradiance in W/m2 is more likely an illuminance in lux.
const BRIGHT_IRRADIANCE: f64 = 100.0;

impl Asset {
    /// Multiplies the intensity of point and spot lights by one factor and the irradiance of directional lights by another:
    /// to radiometric units from those that the file states them in.
    pub fn scale_lights(&mut self, intensity: f64, irradiance: f64) {
        for light in &mut self.description.lights {
            match light {
                PunctualLight::Point { intensity: value, .. } | PunctualLight::Spot { intensity: value, .. } => {
                    *value *= intensity;
                }
                PunctualLight::Directional { irradiance: value, .. } => *value *= irradiance,
            }
        }
    }

    /// A sentence if the file was written by Blender and its lights are so bright that they seem to be in photometric units,
    /// which is what its exporter writes unless told otherwise. For a scene whose lights are as the file states them.
    pub fn light_units_hint(&self) -> Option<String> {
        let by_blender = self.summary.generator.as_ref().is_some_and(|generator| generator.contains("Blender"));
        let bright = |light: &PunctualLight| match light {
            PunctualLight::Point { intensity, .. } | PunctualLight::Spot { intensity, .. } => {
                intensity.max_element() > BRIGHT_INTENSITY
            }
            PunctualLight::Directional { irradiance, .. } => irradiance.max_element() > BRIGHT_IRRADIANCE,
        };
        let hint = "The lights seem to be in candela and lux, as Blender writes them in its standard mode, 683 times too \
                    bright beside emitting surfaces: set light_units to photometric if they are";
        (by_blender && self.description.lights.iter().any(bright)).then(|| hint.into())
    }

    /// The camera with a name (the node's or its own) or a number in the file. An empty `wanted` is the first camera, or
    /// one that frames the whole scene if there is none; then the second value is true. `aspect` is width by height.
    ///
    /// # Errors
    ///
    /// No such camera; the error lists those there are.
    pub fn camera(&self, wanted: &str, aspect: f64) -> Result<(CameraDescription, bool), CameraError> {
        let cameras = &self.description.cameras;
        let file = self.file.clone();
        if wanted.is_empty() {
            return match cameras.first() {
                Some(camera) => Ok((camera.clone(), false)),
                None => self.framing_camera(aspect).map(|c| (c, true)).ok_or(CameraError::Nothing { file }),
            };
        }
        let wanted = wanted.to_string();
        if cameras.is_empty() {
            return Err(CameraError::None { file, wanted });
        }
        let with = |test: &dyn Fn(usize, &CameraDescription) -> bool| {
            let found = cameras.iter().enumerate().filter(|(i, camera)| test(*i, camera));
            found.map(|(i, _)| i).collect::<Vec<_>>()
        };
        let number = |i: usize| self.summary.cameras[i].0;
        let mut found = with(&|i, camera| camera.name == wanted || self.summary.cameras[i].1 == wanted);
        if found.is_empty()
            && let Ok(asked) = wanted.parse::<usize>()
        {
            found = with(&|i, _| number(i) == asked);
            // A camera that several nodes place: its number stands for the first.
            found.truncate(1);
        }
        match found[..] {
            [one] => Ok((cameras[one].clone(), false)),
            [] => {
                let known = (0..cameras.len()).map(|i| format!("{} ({:?})", number(i), cameras[i].name));
                let known = known.collect::<Vec<_>>().join(", ");
                Err(CameraError::Unknown { file, wanted, known })
            }
            _ => {
                let numbers = found.iter().map(|&i| number(i).to_string()).collect::<Vec<_>>().join(", ");
                Err(CameraError::Ambiguous { file, wanted, numbers })
            }
        }
    }

    /// A camera that sees the bounding sphere of all geometry, from the front, a little from the right and above.
    fn framing_camera(&self, aspect: f64) -> Option<CameraDescription> {
        let (low, high) = self.description.bounds()?;
        let centre = (low + high) * 0.5;
        let radius = (high - low).length() * 0.5;
        let half = FRAMING_FOV * 0.5;
        let narrower = half.min(libm::atan(libm::tan(half) * aspect));
        let direction = DVec3::new(0.4, 0.3, 1.0).normalize();
        let eye = centre + direction * (radius / libm::sin(narrower));
        let right = DVec3::Y.cross(direction).normalize();
        let matrix3 = DMat3::from_cols(right, direction.cross(right), direction);
        let transform = DAffine3 { matrix3, translation: eye };
        let name = "framing".to_string();
        let camera = CameraDescription { name, ..CameraDescription::pinhole(transform, FRAMING_FOV) };
        transform.is_finite().then_some(camera)
    }
}
