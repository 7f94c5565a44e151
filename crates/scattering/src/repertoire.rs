//! What code that is compiled once for each of several kinds of scenes may leave out.
//!
//! A scene that has no medium never takes the branch for one; but that branch is there, is asked for at every edge, and keeps what
//! stands around it from being one straight piece of code. So the code from a BSDF to a chain has a type parameter, the repertoire,
//! whose constants say which effects there may be. There is one source; the compiler makes of it one program for each
//! repertoire, and a scene is rendered by the smallest that has all its effects. What is computed is the same to the bit.

use std::fmt::Debug;

/// Which effects there may be. `false` leaves out what an effect needs; it must not be there then.
pub trait Repertoire: Copy + Debug + Default + PartialEq + Send + Sync + 'static {
    /// What it is called in reports.
    const NAME: &'static str;
    /// What it has, in words.
    const ABOUT: &'static str;
    /// Surfaces with lobes beside Lambert's.
    const LOBES: bool;
    /// Surfaces with coats, sheen and other layers.
    const LAYERS: bool;
    /// Materials that differ from point to point.
    const TEXTURES: bool;
    /// Solids, or a space around them, that are no vacuum.
    const MEDIA: bool;
    /// Media that scatter.
    const SCATTERING: bool;
    /// Surfaces that cover a share only.
    const COVERAGE: bool;
    /// Solids that refract different wavelengths differently.
    const DISPERSION: bool;
    /// Lights other than emitting surfaces: points, directions, the environment.
    const OTHER_LIGHTS: bool;
    /// Cameras other than a pinhole.
    const OTHER_CAMERAS: bool;
}

/// All that there is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Everything;

/// Core glTF's surfaces and absorbing solids, without textures, lit by emitting surfaces and seen through a pinhole.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Core;

/// Lambertian surfaces and nothing else.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Matte;

impl Repertoire for Everything {
    const NAME: &'static str = "everything";
    const ABOUT: &'static str = "all effects";
    const LOBES: bool = true;
    const LAYERS: bool = true;
    const TEXTURES: bool = true;
    const MEDIA: bool = true;
    const SCATTERING: bool = true;
    const COVERAGE: bool = true;
    const DISPERSION: bool = true;
    const OTHER_LIGHTS: bool = true;
    const OTHER_CAMERAS: bool = true;
}

impl Repertoire for Core {
    const NAME: &'static str = "core";
    const ABOUT: &'static str =
        "core glTF's surfaces and absorbing solids, without textures, lit by emitting surfaces, seen through a pinhole";
    const LOBES: bool = true;
    const LAYERS: bool = false;
    const TEXTURES: bool = false;
    const MEDIA: bool = true;
    const SCATTERING: bool = false;
    const COVERAGE: bool = false;
    const DISPERSION: bool = false;
    const OTHER_LIGHTS: bool = false;
    const OTHER_CAMERAS: bool = false;
}

impl Repertoire for Matte {
    const NAME: &'static str = "matte";
    const ABOUT: &'static str = "Lambertian surfaces, lit by emitting surfaces, seen through a pinhole";
    const LOBES: bool = false;
    const LAYERS: bool = false;
    const TEXTURES: bool = false;
    const MEDIA: bool = false;
    const SCATTERING: bool = false;
    const COVERAGE: bool = false;
    const DISPERSION: bool = false;
    const OTHER_LIGHTS: bool = false;
    const OTHER_CAMERAS: bool = false;
}
