//! Hits, visibility and surfaces of worlds, against brute force and against planted faults.

mod errors;
mod instancing;
mod instructions;
mod self_intersection;
mod support;
mod surfaces;
mod visibility;
mod watertight;
