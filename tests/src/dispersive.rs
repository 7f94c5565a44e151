//! A room with glass that disperses light, smooth and rough.

use ergodic_pathspace::SceneDescription;
use ergodic_scattering::{Material, Rgb};
use glam::DVec3;

use crate::{Eye, cuboid, description_of, diffuse, glass, quad, sphere};

/// Index of refraction of the glass in [`dispersive_room`] at the line d.
pub const DISPERSIVE_INDEX: f64 = 1.6;

/// A closed room with a lamp, a smooth and a rough lump of glass with KHR_materials_dispersion's `dispersion`, and a smooth one that
/// has none and colours the light.
pub fn dispersive_room(dispersion: f64) -> SceneDescription {
    let smooth = Material { dispersion, ..glass(DISPERSIVE_INDEX) };
    let rough = Material { roughness: 0.45, ..smooth.clone() };
    let colored = Material { base_color: Rgb::new(0.9, 0.6, 0.4), ..glass(1.4) };
    let things = vec![
        (cuboid(DVec3::ONE, true), diffuse(0.6, 0.0)),
        (quad(DVec3::new(-0.5, -0.5, 0.98), DVec3::Y, DVec3::X), diffuse(0.0, 5.0)),
        (sphere(DVec3::new(-0.4, 0.3, -0.5), 0.4, 8, false), smooth),
        (sphere(DVec3::new(0.45, 0.4, -0.55), 0.35, 8, false), rough),
        (sphere(DVec3::new(0.1, -0.2, -0.75), 0.2, 8, false), colored),
    ];
    let eye = Eye { from: DVec3::new(0.0, -0.95, 0.0), at: DVec3::new(0.0, 0.3, -0.3), up: DVec3::Z, fov: 1.2 };
    description_of(things, Vec::new(), &eye)
}
