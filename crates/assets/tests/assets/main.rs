//! What files hold, and what is wrong with them.

mod compression;
mod errors;
mod files;
mod geometry;
mod hierarchy;
mod lights;
mod materials;
mod pose;
mod support;
mod textures;
