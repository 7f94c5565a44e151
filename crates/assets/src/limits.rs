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
