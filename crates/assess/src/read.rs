//! Reading an image of any format.

use std::fs::File;
use std::io::{BufReader, Cursor, Read};
use std::path::Path;

use ::image::ImageReader;

use crate::files::FileError;
use crate::image::{Image, MAX_PIXELS};
use crate::{color, exr_file};

/// Largest file that is read, in bytes.
const MAX_BYTES: u64 = 8 << 30;

/// Reads an EXR, HDR, PNG, JPEG or WebP image. Formats of 8 and 16 bits hold sRGB and are decoded to linear values.
///
/// # Errors
///
/// A file that cannot be read, is no image, or is larger than allowed.
pub fn read_image(path: &Path) -> Result<Image, FileError> {
    let unreadable = |e: std::io::Error| {
        FileError::new(path, format!("cannot be read: {e}"), "Give the path of an EXR, HDR, PNG, JPEG or WebP image")
    };
    let file = File::open(path).map_err(unreadable)?;
    let metadata = file.metadata().map_err(unreadable)?;
    if !metadata.is_file() || metadata.len() > MAX_BYTES {
        return Err(FileError::new(path, "is not a regular file of at most 8 GiB", "Give the path of an image"));
    }
    let mut bytes = Vec::new();
    BufReader::new(file).take(MAX_BYTES).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.starts_with(&exr_file::MAGIC) {
        return exr_file::decode(&bytes).map_err(|problem| FileError::new(path, problem, "Write the image again"));
    }
    decode(bytes).map_err(|e| {
        FileError::new(path, format!("cannot be decoded: {e}"), "Give an EXR, HDR, PNG, JPEG or WebP image")
    })
}

fn decode(bytes: Vec<u8>) -> Result<Image, ::image::ImageError> {
    let mut reader =
        ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(::image::ImageError::IoError)?;
    let format = reader.format();
    let mut limits = ::image::Limits::default();
    limits.max_alloc = Some(MAX_PIXELS * 16);
    reader.limits(limits);
    let decoded = reader.decode()?.to_rgb32f();
    let (width, height) = decoded.dimensions();
    let linear = format == Some(::image::ImageFormat::Hdr);
    let value = |v: f32| if linear { f64::from(v) } else { color::srgb_decode(f64::from(v)) };
    Ok(Image { width, height, pixels: decoded.pixels().map(|p| p.0.map(value)).collect() })
}
