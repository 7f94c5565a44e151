//! OpenEXR files: 32-bit RGB with attributes that say where the picture comes from.

use std::io::Cursor;
use std::path::Path;

use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image as ExrImage, IntegerBounds, Layer, LayerAttributes,
    ReadChannels, ReadLayers, SmallVec, Vec2, WritableImage,
};

use crate::files::{FileError, write_whole};
use crate::image::{Image, MAX_PIXELS};

/// The first bytes of every EXR file.
pub(crate) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// The value of an attribute in the file's header.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// A text.
    Text(String),
    /// A number.
    Number(f64),
}

/// Where a picture lies in a larger one of which it is a part: the file's data window in its display window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Column and row of the part's upper left pixel.
    pub corner: (u32, u32),
    /// Width and height of the whole.
    pub whole: (u32, u32),
}

/// Writes a picture with attributes: channels R, G, B of 32 bits, and `extra` ones of a number a pixel, compressed without
/// loss.
///
/// # Errors
///
/// A file that cannot be written.
pub fn write_exr(
    path: &Path,
    image: &Image,
    window: Option<Window>,
    extra: &[(&str, &[f64])],
    attributes: &[(&str, Attribute)],
) -> Result<(), FileError> {
    let channel = |name: &str, values: &mut dyn Iterator<Item = f64>| {
        AnyChannel::new(Text::from(name), FlatSamples::F32(values.map(|v| v as f32).collect()))
    };
    let mut channels = SmallVec::new();
    for (i, name) in ["R", "G", "B"].into_iter().enumerate() {
        channels.push(channel(name, &mut image.pixels.iter().map(|p| p[i])));
    }
    for (name, values) in extra {
        channels.push(channel(name, &mut values.iter().copied()));
    }
    let size = (image.width as usize, image.height as usize);
    let channels = AnyChannels::sort(channels);
    let mut header = header_attributes(attributes);
    let whole = window.map_or(size, |Window { corner: (x, y), whole: (width, height) }| {
        header.layer_position = Vec2(x as i32, y as i32);
        (width as usize, height as usize)
    });
    let layer = Layer::new(size, header, Encoding::SMALL_LOSSLESS, channels);
    let mut exr = ExrImage::from_layer(layer);
    exr.attributes.display_window = IntegerBounds::from_dimensions(whole);
    let mut bytes = Vec::new();
    exr.write().to_buffered(Cursor::new(&mut bytes)).map_err(|e| {
        FileError::new(path, format!("cannot be encoded: {e}"), "Report this, with the scene and the config")
    })?;
    write_whole(path, &bytes)
}

/// Attributes as the header has them.
pub(crate) fn header_attributes(attributes: &[(&str, Attribute)]) -> LayerAttributes {
    let mut header = LayerAttributes::default();
    for (name, value) in attributes {
        let value = match value {
            Attribute::Text(text) => AttributeValue::Text(latin(text)),
            Attribute::Number(number) => AttributeValue::F64(*number),
        };
        header.other.insert(latin(name), value);
    }
    header
}

/// The format's texts hold bytes; other characters are written as escapes.
fn latin(text: &str) -> Text {
    let escape = |c: char| if c.is_ascii() { c.to_string() } else { c.escape_unicode().to_string() };
    Text::from(text.chars().map(escape).collect::<String>().as_str())
}

fn broken(error: exr::error::Error) -> String {
    format!("cannot be decoded: {error}")
}

/// Looks at the header, so that nothing of its size is allocated if that is more than is allowed.
pub(crate) fn check_size(bytes: &[u8]) -> Result<(), String> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(broken)?;
    for header in &meta.headers {
        let (width, height) = (header.layer_size.width() as u64, header.layer_size.height() as u64);
        if width.saturating_mul(height) > MAX_PIXELS || width > u64::from(u32::MAX) || height > u64::from(u32::MAX) {
            return Err(format!("has {width} x {height} pixels; at most {MAX_PIXELS} are read"));
        }
    }
    Ok(())
}

/// Reads the first layer that has R, G and B.
pub(crate) fn decode(bytes: &[u8]) -> Result<Image, String> {
    check_size(bytes)?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![[0.0; 3]; size.width() * size.height()]),
            |(width, pixels), at, (r, g, b): (f32, f32, f32)| {
                pixels[at.y() * *width + at.x()] = [r, g, b].map(f64::from);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(broken)?;
    let size = image.layer_data.size;
    let (_, pixels) = image.layer_data.channel_data.pixels;
    Ok(Image { width: size.width() as u32, height: size.height() as u32, pixels })
}
