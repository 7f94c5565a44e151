//! Environments: latitude-longitude maps in Radiance HDR and OpenEXR files.

use std::io::Cursor;
use std::path::Path;

use ergodic_scattering::Environment;
use exr::meta::MetaData;
use exr::prelude::{ReadChannels, ReadLayers};
use image::{ImageFormat, ImageReader};

use crate::error::{AssetError, Flaw, Trouble};
use crate::warnings::Warnings;
use crate::{limits, uri};

/// The first bytes of every EXR file.
const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// What stands for an infinite texel: the largest number that a channel of 16 bits holds. Suns that were too bright for such
/// a channel are stored as infinity.
const LARGEST_HALF: f32 = 65504.0;

const MEND: &str = "Give a latitude-longitude map as .hdr or .exr";

/// Texels of a map, row by row from the top.
struct Map {
    width: u32,
    height: u32,
    /// Three numbers each.
    texels: Vec<f32>,
}

/// Loads a map in an HDR or EXR file, times `strength` and turned about +y by `rotation` degrees, with warnings of what is
/// wrong with it. See [`Environment`] for which column is which direction.
///
/// # Errors
///
/// A file that cannot be read, is neither HDR nor EXR, or asks for too much memory.
pub fn load_environment(path: &Path, strength: f64, rotation: f64) -> Result<(Environment, Vec<String>), AssetError> {
    let name = path.display().to_string();
    let bytes = uri::read_file(path)
        .map_err(|why| Flaw::new(Trouble::Unreadable, "", format!("cannot be read: {why}"), MEND).in_file(&name))?;
    let mut map = decode(bytes).map_err(|flaw| flaw.in_file(&name))?;
    let mut warnings = Warnings::default();
    if map.width != 2 * map.height {
        let consequence =
            "is not twice as wide as high, so it is no usual latitude-longitude map: it is stretched over the sphere";
        warnings.note(format!("{name}, which has {} x {} pixels,", map.width, map.height), "", consequence);
    }
    mend(&mut map, &mut warnings, &name);
    let environment = Environment::map(map.width, map.height, map.texels, strength, rotation);
    let environment = environment.ok_or_else(|| Flaw::malformed("", "has no pixels").in_file(&name))?;
    if environment.total_luminance() <= 0.0 {
        warnings.note(name, "", "is black and lights nothing");
    }
    let (sentences, _) = warnings.into_sentences();
    Ok((environment, sentences))
}

/// Replaces what is no radiance, with a warning that names the first place.
fn mend(map: &mut Map, warnings: &mut Warnings, name: &str) {
    let width = map.width as usize;
    for (i, texel) in map.texels.chunks_exact_mut(3).enumerate() {
        if texel.iter().all(|channel| (0.0..f32::INFINITY).contains(channel)) {
            continue;
        }
        let place = || format!("first in row {}, column {}", i / width, i % width);
        if texel.iter().any(|channel| channel.is_nan()) {
            warnings.note(format!("{name} has pixels that are no number"), place(), "they are taken for black");
        } else if texel.iter().any(|channel| *channel < 0.0) {
            warnings.note(format!("{name} has negative pixels"), place(), "their negative channels are taken for 0");
        }
        if texel.contains(&f32::INFINITY) {
            warnings.note(
                format!("{name} has infinite pixels"),
                place(),
                "their infinite channels are taken for 65504",
            );
        }
        let is_number = texel.iter().all(|channel| !channel.is_nan());
        for channel in texel {
            *channel = match *channel {
                f32::INFINITY => LARGEST_HALF,
                value if is_number => value.max(0.0),
                _ => 0.0,
            };
        }
    }
}

fn too_large(width: u64, height: u64) -> Flaw {
    let problem = format!("has {width} x {height} pixels; {} bytes may be needed at most", limits::IMAGE_BYTES);
    Flaw::new(Trouble::TooLarge, "", problem, "Use a smaller map")
}

/// Whether a map of so many pixels is within the limits.
fn check_size(width: u64, height: u64) -> Result<(), Flaw> {
    let fits = width.saturating_mul(height).saturating_mul(3 * size_of::<f32>() as u64) <= limits::IMAGE_BYTES;
    let side = u64::from(limits::IMAGE_SIDE);
    if fits && width <= side && height <= side { Ok(()) } else { Err(too_large(width, height)) }
}

fn decode(bytes: Vec<u8>) -> Result<Map, Flaw> {
    if bytes.starts_with(&EXR_MAGIC) { decode_exr(&bytes) } else { decode_hdr(bytes) }
}

fn decode_hdr(bytes: Vec<u8>) -> Result<Map, Flaw> {
    let broken = |e: &dyn std::fmt::Display| Flaw::new(Trouble::Malformed, "", format!("cannot be decoded: {e}"), MEND);
    let reader = || ImageReader::new(Cursor::new(&bytes)).with_guessed_format().map_err(|e| broken(&e));
    if reader()?.format() != Some(ImageFormat::Hdr) {
        return Err(Flaw::new(Trouble::Unsupported, "", "is neither a Radiance HDR nor an OpenEXR file", MEND));
    }
    let (width, height) = reader()?.into_dimensions().map_err(|e| broken(&e))?;
    check_size(width.into(), height.into())?;
    let texels = reader()?.decode().map_err(|e| broken(&e))?.into_rgb32f().into_raw();
    Ok(Map { width, height, texels })
}

fn decode_exr(bytes: &[u8]) -> Result<Map, Flaw> {
    let broken = |e: exr::error::Error| Flaw::new(Trouble::Malformed, "", format!("cannot be decoded: {e}"), MEND);
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(broken)?;
    for header in &meta.headers {
        check_size(header.layer_size.width() as u64, header.layer_size.height() as u64)?;
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![0.0f32; 3 * size.width() * size.height()]),
            |(width, texels), at, (r, g, b): (f32, f32, f32)| {
                texels[3 * (at.y() * *width + at.x())..][..3].copy_from_slice(&[r, g, b]);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(broken)?;
    let size = image.layer_data.size;
    let (_, texels) = image.layer_data.channel_data.pixels;
    Ok(Map { width: size.width() as u32, height: size.height() as u32, texels })
}
