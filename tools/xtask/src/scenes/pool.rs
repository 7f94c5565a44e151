//! Wavy water over tiles under a small light: every path to the tiles and back crosses the surface twice, so what is seen is
//! specular-diffuse-specular.

use glam::{DVec2, DVec3};

use crate::glb::{Document, Material, Solid};
use crate::shapes::{Shape, quad, water_body};

/// Half the side of the basin in metres.
const HALF: f64 = 1.0;
/// Depth of the tiles below the still water.
const DEPTH: f64 = 0.7;
/// Height of the deck above it.
const DECK: f64 = 0.12;
/// Tiles along each side.
const TILES: u32 = 10;

/// Height and slopes of the surface: a few plane waves of a decimetre to half a metre, some millimetres high.
fn waves(x: f64, z: f64) -> (f64, DVec2) {
    // Wave vector in radians a metre, amplitude in metres, phase.
    let waves = [
        (DVec2::new(9.0, 4.0), 0.012, 0.3),
        (DVec2::new(-5.0, 11.0), 0.009, 1.7),
        (DVec2::new(14.0, -9.0), 0.005, 4.1),
        (DVec2::new(3.0, 19.0), 0.003, 2.2),
    ];
    let mut height = 0.0;
    let mut slope = DVec2::ZERO;
    for (k, amplitude, phase) in waves {
        let (sin, cos) = (k.dot(DVec2::new(x, z)) + phase).sin_cos();
        height += amplitude * sin;
        slope += k * (amplitude * cos);
    }
    (height, slope)
}

pub(super) fn make() -> Document {
    let mut document = Document::default();
    let deck = document.material(&Material::diffuse("deck", [0.55, 0.50, 0.44]));
    let tiles = [
        document.material(&Material::diffuse("white tile", [0.78, 0.80, 0.80])),
        document.material(&Material::diffuse("blue tile", [0.16, 0.42, 0.58])),
    ];
    let water = document.material(&Material::solid(
        "water",
        Solid { ior: 1.33, attenuation_color: [0.70, 0.92, 0.95], attenuation_distance: 2.0 },
    ));
    let lamp = document.material(&Material::lamp("lamp", [520.0, 500.0, 460.0]));

    let side = 2.0 * HALF / f64::from(TILES);
    let mut fields = [Shape::default(), Shape::default()];
    for j in 0..TILES {
        for i in 0..TILES {
            let corner = DVec3::new(-HALF + side * f64::from(i), -DEPTH, -HALF + side * f64::from(j));
            fields[((i + j) % 2) as usize].add(&quad(corner, DVec3::Z * side, DVec3::X * side));
        }
    }
    // The walls of the basin, looking inwards, are tiled in white.
    let (across, along, up) = (DVec3::X * (2.0 * HALF), DVec3::Z * (2.0 * HALF), DVec3::Y * (DEPTH + DECK));
    let corner = DVec3::new(-HALF, -DEPTH, -HALF);
    for wall in [
        quad(corner, across, up),
        quad(corner, up, along),
        quad(corner + across, along, up),
        quad(corner + along, up, across),
    ] {
        fields[0].add(&wall);
    }
    for (field, (name, material)) in fields.iter().zip([("white tiles", tiles[0]), ("blue tiles", tiles[1])]) {
        document.shape(name, field, material);
    }
    // The deck around the basin: four strips a metre wide that meet at the corners.
    let mut strips = Shape::default();
    let outer = HALF + 1.0;
    for (x, z, dx, dz) in [
        (-outer, -outer, 2.0 * outer, 1.0),
        (-outer, HALF, 2.0 * outer, 1.0),
        (-outer, -HALF, 1.0, 2.0 * HALF),
        (HALF, -HALF, 1.0, 2.0 * HALF),
    ] {
        strips.add(&quad(DVec3::new(x, DECK, z), DVec3::Z * dz, DVec3::X * dx));
    }
    document.shape("deck", &strips, deck);
    // The water reaches two centimetres behind the walls and below the tiles, so that no faces coincide; what lies there is
    // hidden by them.
    document.shape("water", &water_body(HALF + 0.02, -DEPTH - 0.02, 96, waves), water);

    // A 25 cm square, 2.2 m above the water, looking down.
    document.shape("lamp", &quad(DVec3::new(0.45, 2.2, -0.75), DVec3::X * 0.25, DVec3::Z * 0.25), lamp);
    document.camera(DVec3::new(-0.5, 1.75, 2.7), DVec3::new(0.0, -0.35, 0.0), 38.0);
    document
}
