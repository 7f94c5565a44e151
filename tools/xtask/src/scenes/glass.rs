//! A glass ball and a glass lens-like body on a floor under a small light: caustics, and caustics seen through glass.

use glam::{DAffine3, DVec2, DVec3};

use crate::glb::{Document, Material, Solid};
use crate::shapes::{Profile, Shape, quad, resting_sphere, revolve};

pub(super) fn make() -> Document {
    let mut document = Document::default();
    let floor = document.material(&Material::diffuse("floor", [0.62, 0.60, 0.57]));
    let wall = document.material(&Material::diffuse("wall", [0.55, 0.60, 0.66]));
    let glass = document.material(&Material::solid(
        "glass",
        Solid { ior: 1.5, attenuation_color: [0.80, 0.95, 0.88], attenuation_distance: 0.8 },
    ));
    let lamp = document.material(&Material::lamp("lamp", [230.0, 220.0, 205.0]));

    document.shape("floor", &quad(DVec3::new(-2.0, 0.0, -1.6), DVec3::Z * 4.0, DVec3::X * 4.0), floor);
    let mut walls = Shape::default();
    walls.add(&quad(DVec3::new(-2.0, 0.0, -1.6), DVec3::X * 4.0, DVec3::Y * 2.6)); // back
    walls.add(&quad(DVec3::new(-2.0, 0.0, -1.6), DVec3::Y * 2.6, DVec3::Z * 4.0)); // left
    document.shape("walls", &walls, wall);

    // One millimetre above the floor: no faces coincide.
    let at = |x: f64, z: f64| DAffine3::from_translation(DVec3::new(x, 0.001, z));
    document.shape("ball", &resting_sphere(0.38, 48).moved(at(-0.28, 0.15)), glass);
    // A cylinder with rounded rims, 0.5 m high.
    let mut profile = vec![DVec2::ZERO];
    let rim = 0.04;
    for (height, from) in [(rim, -90.0), (0.5 - rim, 0.0)] {
        for step in 0..=8 {
            let angle = f64::to_radians(from + 90.0 * f64::from(step) / 8.0);
            profile.push(DVec2::new(0.2 - rim + rim * angle.cos(), height + rim * angle.sin()));
        }
    }
    profile.push(DVec2::new(0.0, 0.5));
    document.shape("cylinder", &revolve(&profile, Profile::Smooth, 96).moved(at(0.52, -0.3)), glass);

    // 18 cm square, above and in front, turned towards the ball: the caustics fall behind the glass.
    let centre = DVec3::new(0.9, 2.1, 1.3);
    let direction = (DVec3::new(0.0, 0.3, 0.0) - centre).normalize();
    let u = direction.any_orthonormal_vector() * 0.18;
    let v = direction.cross(u);
    document.shape("lamp", &quad(centre - (u + v) * 0.5, u, v), lamp);
    document.camera(DVec3::new(0.1, 1.25, 2.9), DVec3::new(0.02, 0.3, -0.1), 34.0);
    document
}
