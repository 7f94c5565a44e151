//! What files hold, and what is wrong with them.

mod errors;
mod files;
mod geometry;
mod hierarchy;
mod layers;
mod materials;
mod support;
mod textured;
