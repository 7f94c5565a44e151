//! A Cornell box in the proportions of the original (555 mm on a side), all surfaces Lambertian.

use glam::{DAffine3, DVec3};

use crate::glb::{Document, Material};
use crate::shapes::{Shape, cuboid, quad};

/// Inner side of the box in metres.
const SIDE: f64 = 0.555;

pub(super) fn make() -> Document {
    let mut document = Document::default();
    // Close to the measured reflectances of the original paints, averaged into RGB.
    let white = document.material(&Material::diffuse("white", [0.73, 0.73, 0.73]));
    let red = document.material(&Material::diffuse("red", [0.63, 0.065, 0.05]));
    let green = document.material(&Material::diffuse("green", [0.14, 0.45, 0.091]));
    // Warm, and bright enough for a mean of about 0.3.
    let lamp = document.material(&Material::lamp("lamp", [17.0, 12.0, 6.0]));

    let (x, y, z) = (DVec3::X * SIDE, DVec3::Y * SIDE, DVec3::Z * SIDE);
    let mut walls = Shape::default();
    walls.add(&quad(DVec3::ZERO, z, x)); // floor
    walls.add(&quad(y, x, z)); // ceiling
    walls.add(&quad(DVec3::ZERO, x, y)); // back
    document.shape("walls", &walls, white);
    document.shape("left wall", &quad(DVec3::ZERO, y, z), red);
    document.shape("right wall", &quad(x, z, y), green);

    // 130 mm x 105 mm, a little below the ceiling so that the two do not coincide; it looks down.
    let corner = DVec3::new(0.2125, SIDE - 0.001, 0.225);
    document.shape("lamp", &quad(corner, DVec3::X * 0.13, DVec3::Z * 0.105), lamp);

    // The blocks are 165 mm square, 165 and 330 mm high, turned by about 17 degrees either way.
    let block = |height: f64, turn: f64, x: f64, z: f64| {
        let half = 0.0825;
        cuboid(DVec3::new(-half, 0.0, -half), DVec3::new(half, height, half))
            .moved(DAffine3::from_translation(DVec3::new(x, 0.0, z)) * DAffine3::from_rotation_y(f64::to_radians(turn)))
    };
    document.shape("short block", &block(0.165, -17.0, 0.370, 0.390), white);
    document.shape("tall block", &block(0.330, 17.5, 0.186, 0.205), white);

    // The original's camera stands 800 mm in front of the opening, and its film just holds it.
    let middle = SIDE / 2.0;
    document.camera(DVec3::new(middle, middle, SIDE + 0.8), DVec3::new(middle, middle, 0.0), 39.0);
    document
}
