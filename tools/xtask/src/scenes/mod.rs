//! The scenes, one file each.

mod ajar;
mod cornell;
mod glass;
mod pool;
mod ring;

use crate::glb::Document;

/// A scene that can be made.
#[derive(Clone, Copy, Debug)]
pub struct Recipe {
    /// Its folder in scenes/.
    pub name: &'static str,
    /// What it shows.
    pub about: &'static str,
    /// Makes it.
    pub make: fn() -> Document,
}

/// All of them.
pub static ALL: [Recipe; 5] = [
    Recipe { name: "cornell", about: "the diffuse box; easy for everyone", make: cornell::make },
    Recipe { name: "ajar", about: "a room lit only through a door that stands ajar", make: ajar::make },
    Recipe { name: "ring", about: "a metal ring and its cardioid caustic", make: ring::make },
    Recipe { name: "glass", about: "a glass solid, its caustic, and the caustic seen through it", make: glass::make },
    Recipe { name: "pool", about: "wavy water over tiles: specular-diffuse-specular paths", make: pool::make },
];
