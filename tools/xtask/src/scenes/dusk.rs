//! Glass, metal and stone under an evening sky, with a lantern: light from the environment, seen directly, by reflection and by
//! refraction, beside a lamp.

use glam::{DAffine3, DVec2, DVec3};

use crate::glb::{Document, Material, Solid};
use crate::shapes::{Profile, cuboid, quad, resting_sphere, revolve};
use crate::sky::Sky;

pub(super) fn make() -> Document {
    let mut document = Document::default();
    let stone = document.material(&Material::diffuse("stone", [0.52, 0.48, 0.44]));
    let block = document.material(&Material::diffuse("block", [0.70, 0.34, 0.24]));
    // Reflectance of silver and of gold at normal incidence.
    let mirror = document.material(&Material::metal("silver", [0.972, 0.960, 0.915], 0.0));
    let gold = document.material(&Material::metal("gold", [1.0, 0.766, 0.336], 0.45));
    let glass = document.material(&Material::solid(
        "glass",
        Solid { ior: 1.5, attenuation_color: [0.85, 0.93, 0.97], attenuation_distance: 0.6 },
    ));
    let lamp = document.material(&Material::lamp("lantern", [22.0, 14.0, 7.0]));

    document.shape("terrace", &quad(DVec3::new(-2.5, 0.0, -2.0), DVec3::Z * 4.0, DVec3::X * 5.0), stone);
    // All things stand a millimetre above it, so that no faces coincide.
    let on_floor = |x: f64, z: f64| DAffine3::from_translation(DVec3::new(x, 0.001, z));
    document.shape("mirror ball", &resting_sphere(0.45, 48).moved(on_floor(-1.05, -0.35)), mirror);
    document.shape("glass ball", &resting_sphere(0.36, 48).moved(on_floor(0.05, 0.45)), glass);
    let bowl = [(0.0, 0.0), (0.28, 0.0), (0.52, 0.34), (0.48, 0.34), (0.26, 0.04), (0.0, 0.04)].map(DVec2::from);
    document.shape("bowl", &revolve(&bowl, Profile::Edged, 96).moved(on_floor(0.95, -0.3)), gold);
    document.shape("block", &cuboid(DVec3::new(-0.55, 0.001, -1.25), DVec3::new(0.15, 0.75, -0.75)), block);
    // 24 cm square, above the block, turned down and to the front.
    let (u, v) = (DVec3::X * 0.24, DVec3::new(0.0, 0.12, 0.2078));
    document.shape("lantern", &quad(DVec3::new(-0.32, 1.05, -0.9), u, v), lamp);
    document.camera(DVec3::new(0.3, 1.05, 3.5), DVec3::new(0.0, 0.42, 0.0), 38.0);
    document
}

/// Radiance of the evening sky from the unit direction `w`: warm at the horizon, blue above, a low sun behind thin cloud on the
/// left, dark ground.
fn radiance(w: DVec3) -> DVec3 {
    let (zenith, horizon, ground) =
        (DVec3::new(0.10, 0.19, 0.42), DVec3::new(0.85, 0.52, 0.36), DVec3::new(0.06, 0.055, 0.05));
    if w.y < 0.0 {
        return ground;
    }
    // 24 degrees high. The exponent makes the sun's lobe 5 degrees wide, that of the glow around it 17.
    let sun = DVec3::new(-0.8, 0.445, -0.4).normalize();
    let lobe = |sharpness: f64| (sharpness * (w.dot(sun) - 1.0)).exp();
    horizon.lerp(zenith, w.y.powf(0.6))
        + DVec3::new(60.0, 42.0, 26.0) * lobe(130.0)
        + DVec3::new(0.9, 0.5, 0.3) * lobe(11.0)
}

pub(super) fn sky() -> Sky {
    Sky { width: 96, height: 48, radiance }
}
