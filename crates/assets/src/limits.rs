//! Bounds on what a file may ask for, so that a broken one cannot exhaust memory.

/// Largest file that is read, in bytes: what a GLB header can state.
pub(crate) const FILE_BYTES: u64 = u32::MAX as u64;

/// Most elements of an accessor that has no buffer view, whose size nothing else bounds.
pub(crate) const VIEWLESS_ELEMENTS: u64 = 1 << 22;

/// Most texels on a side of an image.
pub(crate) const IMAGE_SIDE: u32 = 16_384;

/// Most bytes that decoding one image may take.
pub(crate) const IMAGE_BYTES: u64 = 512 << 20;

/// Most bytes that all decoded images together may take.
pub(crate) const ALL_IMAGE_BYTES: u64 = 8 << 30;

/// Coordinates beyond this are taken for damage: their squares and products must stay finite.
pub(crate) const COORDINATE: f64 = 1e30;

/// Most vertices and most triangles of a primitive compressed by Draco, whose size does not bound them.
pub(crate) const DRACO_ELEMENTS: u64 = 1 << 26;

/// Most bytes of the attributes of a primitive compressed by Draco.
pub(crate) const DRACO_BYTES: u64 = 2 << 30;

/// Most bytes of one decompressed buffer view.
pub(crate) const DECOMPRESSED_BYTES: u64 = 2 << 30;

/// Most bytes of all decompressed buffer views together.
pub(crate) const ALL_DECOMPRESSED_BYTES: u64 = 8 << 30;

/// Most vertices of all meshes together: one mesh in the file becomes many where nodes pose it differently.
pub(crate) const VERTICES: usize = 1 << 27;

/// Most meshes that are placed in the scene.
pub(crate) const PLACEMENTS: usize = 1 << 24;
