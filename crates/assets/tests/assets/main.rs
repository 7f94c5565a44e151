//! What files hold, and what is wrong with them.

mod compression;
mod environments;
mod errors;
mod files;
mod geometry;
mod hierarchy;
mod image_based_lights;
mod layers;
mod lights;
mod materials;
mod pose;
mod support;
mod textured;
mod textures;
