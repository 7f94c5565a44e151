//! The laws of one local interaction: samplers against densities, reciprocity, energy, conventions, hard numerics.

mod bsdf_chi_square;
mod camera;
mod conventions;
mod cube_maps;
mod energy;
mod environments;
mod furnace;
mod layers;
mod lights;
mod materials;
mod media;
mod numerics;
mod support;
