//! What files hold, and what is wrong with them.

mod environments;
mod errors;
mod files;
mod geometry;
mod hierarchy;
mod materials;
mod support;
