//! The scenes, one file each.

mod ajar;
mod cornell;
mod dusk;
mod glass;
mod pool;
mod ring;

use crate::glb::Document;
use crate::sky::Sky;

/// A scene that can be made.
#[derive(Clone, Copy, Debug)]
pub struct Recipe {
    /// Its folder in scenes/.
    pub name: &'static str,
    /// What it shows.
    pub about: &'static str,
    /// Makes it.
    pub make: fn() -> Document,
    /// Its environment, in a file of its own.
    pub sky: Option<fn() -> Sky>,
}

/// All of them.
pub static ALL: [Recipe; 6] = [
    Recipe { name: "cornell", about: "the diffuse box; easy for everyone", make: cornell::make, sky: None },
    Recipe { name: "ajar", about: "a room lit only through a door that stands ajar", make: ajar::make, sky: None },
    Recipe { name: "ring", about: "a metal ring and its cardioid caustic", make: ring::make, sky: None },
    Recipe {
        name: "glass",
        about: "a glass solid, its caustic, and the caustic seen through it",
        make: glass::make,
        sky: None,
    },
    Recipe {
        name: "pool",
        about: "wavy water over tiles: specular-diffuse-specular paths",
        make: pool::make,
        sky: None,
    },
    Recipe {
        name: "dusk",
        about: "glass, metal and stone under an evening sky, with a lantern",
        make: dusk::make,
        sky: Some(dusk::sky),
    },
];
