//! A glass ball on a floor beside a small light: its caustic, and the caustic seen through the glass.

use glam::{DAffine3, DVec3};

use crate::glb::{Document, Material, Solid};
use crate::shapes::{quad, resting_sphere};

pub(super) fn make() -> Document {
    let mut document = Document::default();
    let floor = document.material(&Material::diffuse("floor", [0.62, 0.60, 0.57]));
    let wall = document.material(&Material::diffuse("wall", [0.50, 0.56, 0.64]));
    let glass = document.material(&Material::solid(
        "glass",
        Solid { ior: 1.5, attenuation_color: [0.80, 0.95, 0.88], attenuation_distance: 0.8 },
    ));
    let lamp = document.material(&Material::lamp("lamp", [300.0, 285.0, 260.0]));

    document.shape("floor", &quad(DVec3::new(-2.0, 0.0, -1.6), DVec3::Z * 4.0, DVec3::X * 4.0), floor);
    document.shape("wall", &quad(DVec3::new(-2.0, 0.0, -1.6), DVec3::X * 4.0, DVec3::Y * 2.6), wall);
    // One millimetre above the floor: no faces coincide.
    let at = DAffine3::from_translation(DVec3::new(0.12, 0.001, 0.1));
    document.shape("ball", &resting_sphere(0.42, 64).moved(at), glass);

    // 14 cm square, to the right and a little in front, turned towards the ball: the caustic falls to the left and behind,
    // so that its near part is seen through the ball and its far part past it.
    let centre = DVec3::new(1.75, 1.5, 0.75);
    let direction = (DVec3::new(0.12, 0.42, 0.1) - centre).normalize();
    let u = direction.any_orthonormal_vector() * 0.14;
    let v = direction.cross(u);
    document.shape("lamp", &quad(centre - (u + v) * 0.5, u, v), lamp);
    document.camera(DVec3::new(-0.25, 1.15, 2.7), DVec3::new(-0.12, 0.3, 0.0), 34.0);
    document
}
