//! After the scene of Veach and Guibas (1997): a room that is lit only through a door that stands ajar. The lamp stands in the
//! room behind and shines at its ceiling, so that light reaches the table by three bounces at least.

use glam::{DAffine3, DVec2, DVec3};

use crate::glb::{Document, Material, Solid};
use crate::shapes::{Profile, Shape, cuboid, quad, resting_sphere, resting_torus, revolve};

/// Half the width of both rooms in metres.
const HALF_WIDTH: f64 = 2.2;
/// Height of both rooms.
const CEILING: f64 = 2.5;
/// The far wall of the room behind, the wall between the rooms (two faces), and the wall behind the camera.
const BACK: f64 = -4.6;
const WALL_BACK: f64 = -1.9;
const WALL_FRONT: f64 = -1.8;
const FRONT: f64 = 2.6;
/// The doorway: left and right jamb, height.
const DOOR_LEFT: f64 = 0.55;
const DOOR_RIGHT: f64 = 1.45;
const DOOR_HEIGHT: f64 = 2.05;
/// How far the door stands open, in degrees.
const OPENING: f64 = 16.0;
/// Height of the table top.
const TABLE: f64 = 0.74;

pub(super) fn make() -> Document {
    let mut document = Document::default();
    let wall = document.material(&Material::diffuse("wall", [0.72, 0.70, 0.66]));
    let back_wall = document.material(&Material::diffuse("back room wall", [0.85, 0.84, 0.80]));
    let floor = document.material(&Material::glossy("floor", [0.36, 0.23, 0.14], 0.35));
    let door = document.material(&Material::glossy("door", [0.42, 0.30, 0.20], 0.5));
    let wood = document.material(&Material::glossy("table", [0.45, 0.28, 0.16], 0.4));
    let clay = document.material(&Material::diffuse("clay", [0.55, 0.20, 0.13]));
    // Reflectance of copper at normal incidence.
    let copper = document.material(&Material::metal("copper", [0.955, 0.638, 0.538], 0.22));
    let glass = document.material(&Material::solid(
        "glass",
        Solid { ior: 1.5, attenuation_color: [0.75, 0.92, 0.86], attenuation_distance: 0.25 },
    ));
    // Bright enough that the strip of light reads as light and the room behind the camera as dim.
    let lamp = document.material(&Material::lamp("lamp", [620.0, 540.0, 420.0]));

    rooms(&mut document, wall, back_wall, floor);

    // The door is hinged at the right jamb and opens into this room; it reaches a little into the floor, so that no light
    // passes below.
    let slab = cuboid(DVec3::new(-(DOOR_RIGHT - DOOR_LEFT), -0.01, 0.0), DVec3::new(0.0, DOOR_HEIGHT, 0.045));
    let hinge = DAffine3::from_translation(DVec3::new(DOOR_RIGHT, 0.0, WALL_FRONT))
        * DAffine3::from_rotation_y(OPENING.to_radians());
    document.shape("door", &slab.moved(hinge), door);
    let handle = resting_sphere(0.035, 24)
        .moved(hinge * DAffine3::from_translation(DVec3::new(-(DOOR_RIGHT - DOOR_LEFT) + 0.08, 0.98, 0.08)));
    document.shape("handle", &handle, copper);

    // An uplight: 1 m x 0.7 m, below the ceiling, facing it.
    document.shape("lamp", &quad(DVec3::new(-0.6, 2.1, -3.6), DVec3::Z * 0.7, DVec3::X * 1.0), lamp);

    table(&mut document, wood);
    let on_table = |x: f64, z: f64| DAffine3::from_translation(DVec3::new(x, TABLE, z));
    document.shape("vase", &vase().moved(on_table(-0.42, -0.35)), glass);
    document.shape("torus", &resting_torus(0.13, 0.05, 32).moved(on_table(0.02, -0.12)), copper);
    document.shape("ball", &resting_sphere(0.13, 32).moved(on_table(0.34, -0.52)), clay);

    document.camera(DVec3::new(-0.55, 1.42, 2.15), DVec3::new(0.12, 0.92, -0.9), 42.0);
    document
}

fn rooms(document: &mut Document, wall: usize, back_wall: usize, floor: usize) {
    let width = DVec3::X * (2.0 * HALF_WIDTH);
    let height = DVec3::Y * CEILING;
    let corner = |z: f64| DVec3::new(-HALF_WIDTH, 0.0, z);
    let shell = |from: f64, to: f64| {
        let depth = DVec3::Z * (to - from);
        let mut shape = Shape::default();
        shape.add(&quad(corner(from) + height, width, depth)); // ceiling
        shape.add(&quad(corner(from), height, depth)); // left
        shape.add(&quad(corner(from) + width, depth, height)); // right
        shape
    };
    let mut this_room = shell(WALL_FRONT, FRONT);
    this_room.add(&quad(corner(FRONT) + width, -width, height));
    // The wall with the doorway: left and right of it, and above it. It is thick, so its jambs show.
    let piece =
        |x0: f64, x1: f64, y0: f64, y1: f64| cuboid(DVec3::new(x0, y0, WALL_BACK), DVec3::new(x1, y1, WALL_FRONT));
    this_room.add(&piece(-HALF_WIDTH, DOOR_LEFT, 0.0, CEILING));
    this_room.add(&piece(DOOR_RIGHT, HALF_WIDTH, 0.0, CEILING));
    this_room.add(&piece(DOOR_LEFT, DOOR_RIGHT, DOOR_HEIGHT, CEILING));
    document.shape("room", &this_room, wall);

    let mut behind = shell(BACK, WALL_FRONT);
    behind.add(&quad(corner(BACK), width, height));
    document.shape("room behind", &behind, back_wall);
    document.shape("floor", &quad(corner(BACK), DVec3::Z * (FRONT - BACK), width), floor);
}

fn table(document: &mut Document, wood: usize) {
    let (low, high) = (DVec3::new(-0.85, TABLE - 0.04, -0.85), DVec3::new(0.65, TABLE, 0.15));
    let mut table = cuboid(low, high);
    for x in [low.x + 0.06, high.x - 0.12] {
        for z in [low.z + 0.06, high.z - 0.12] {
            // Legs end below the floor and inside the top: no faces coincide.
            table.add(&cuboid(DVec3::new(x, -0.01, z), DVec3::new(x + 0.06, TABLE - 0.02, z + 0.06)));
        }
    }
    document.shape("table", &table, wood);
}

/// A solid glass vase: foot, stem-like waist, round body, narrow neck. Height 0.34 m.
fn vase() -> Shape {
    // Control points (radius, height) of a Catmull-Rom curve, from the foot to the rim.
    let control = [
        (0.075, 0.0),
        (0.07, 0.015),
        (0.035, 0.05),
        (0.06, 0.10),
        (0.115, 0.18),
        (0.085, 0.26),
        (0.04, 0.31),
        (0.05, 0.34),
    ]
    .map(DVec2::from);
    let mut profile = vec![DVec2::ZERO];
    let at = |i: isize| control[i.clamp(0, control.len() as isize - 1) as usize];
    let steps = 8;
    for i in 0..control.len() as isize - 1 {
        for step in 0..steps {
            let t = f64::from(step) / f64::from(steps);
            let (p0, p1, p2, p3) = (at(i - 1), at(i), at(i + 1), at(i + 2));
            profile.push(
                p1 + ((p2 - p0) * 0.5) * t
                    + (p0 - p1 * 2.5 + p2 * 2.0 - p3 * 0.5) * (t * t)
                    + ((p1 - p2) * 1.5 + (p3 - p0) * 0.5) * (t * t * t),
            );
        }
    }
    profile.push(control[control.len() - 1]);
    profile.push(DVec2::new(0.0, 0.34));
    revolve(&profile, Profile::Smooth, 64)
}
