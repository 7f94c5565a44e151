//! One local interaction of light: how surfaces scatter (f_s), what they emit (L_e), what the camera responds to (W_e).
//!
//! Every lobe is a file with three free-standing functions (value, density, sample); [`Bsdf`] dispatches to them. All
//! directions point away from the surface and are unit vectors. Nothing here allocates or knows about paths.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod albedo_table;
mod alias;
mod bsdf;
mod camera;
mod coat;
mod color;
mod cube_map;
mod dirac;
mod effects;
pub mod emission;
mod environment;
mod extended;
mod filter;
mod fresnel;
mod ggx;
mod henyey_greenstein;
mod interaction;
mod lambert;
mod layered;
mod lens;
mod material;
mod material_layers;
mod medium;
mod microfacet_reflection;
mod microfacet_refraction;
mod normal_map;
mod packed;
mod punctual;
mod repertoire;
mod sheen;
mod specular_albedo;
mod texture;
mod thin_film;
mod thin_transmission;
pub mod warp;
mod wavelength;

pub use alias::AliasTable;
pub use bsdf::Bsdf;
pub use camera::{Camera, Optics, Sight};
pub use color::{Rgb, luminance};
pub use cube_map::CubeMap;
pub use effects::Plain;
pub use environment::Environment;
pub use extended::{Extended, ExtendedParameters};
pub use filter::{Filter, FilterKernel};
pub use ggx::SMOOTH_ALPHA;
pub use henyey_greenstein::HenyeyGreenstein;
pub use interaction::{Component, Interaction};
pub use lambert::Lambert;
use layered::SELECTION_FLOOR;
pub use layered::{Layered, Parameters};
pub use lens::Lens;
pub use material::{AlphaMode, Material, SpecularGlossiness};
pub use material_layers::MaterialLayers;
pub use medium::Medium;
pub use punctual::PunctualLight;
pub use repertoire::{Core, Everything, Matte, Repertoire};
pub use texture::{Interpolation, Texels, Texture, TextureUse, Wrap, srgb_to_linear};
pub use wavelength::Wavelength;
