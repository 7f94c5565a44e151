//! Pictures as files, how far one is from another, and how one is shown on a screen.

pub mod accuracy;
mod color;
mod compare;
mod exr_file;
mod files;
mod flip;
mod image;
mod read;
mod reference;
mod replicas;
mod tone;

pub use compare::{Comparison, RELATIVE_EPSILON, TRIMMED_SHARE, compare, compare_with_map};
pub use exr_file::{Attribute, Window, write_exr};
pub use files::{FileError, check_writable, write_whole};
pub use flip::{flip_hdr, flip_ldr};
pub use image::Image;
pub use read::read_image;
pub use reference::{BLOCK, Reference};
pub use replicas::{BlockTest, ReplicaTest, Verdict, test_replicas};
pub use tone::{Exposure, to_srgb8, write_png, write_srgb8};
