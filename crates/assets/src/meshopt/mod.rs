//! Buffer views compressed by EXT_meshopt_compression or KHR_meshopt_compression, which are one format with two names but
//! for version 1 of the attribute codec and the colour filter, which only the latter has.
//!
//! Written from the specification of KHR_meshopt_compression, whose appendices A and B the parts are named after. Every
//! read is checked, and what is decoded takes memory only as it is decoded, so that a stream that announces more than it
//! holds is an error before it is a burden.

mod attributes;
mod cursor;
mod filters;
mod indices;

use serde::Deserialize;

use crate::error::{Flaw, Trouble};
use crate::limits;

/// What is wrong with a stream.
type Broken = &'static str;

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "UPPERCASE")]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "UPPERCASE")]
enum Filter {
    #[default]
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

/// The extension's object in a buffer view.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Compressed {
    /// Index of the buffer that holds the stream.
    pub buffer: usize,
    /// Where in it the stream starts, in bytes.
    #[serde(default)]
    pub byte_offset: u64,
    /// Length of the stream in bytes.
    pub byte_length: u64,
    byte_stride: u64,
    count: u64,
    mode: Mode,
    #[serde(default)]
    filter: Filter,
}

impl Compressed {
    /// Reads the extension's object, whose bounds must fit a view of `view_length` bytes.
    pub(crate) fn read(extension: &serde_json::Value, view_length: u64, place: &str) -> Result<Self, Flaw> {
        let read: Self =
            serde_json::from_value(extension.clone()).map_err(|e| Flaw::malformed(place, e.to_string()))?;
        let Self { byte_stride: stride, count, mode, filter, .. } = read;
        let allowed = match (mode, filter) {
            (Mode::Triangles, Filter::None) => matches!(stride, 2 | 4) && count % 3 == 0,
            (Mode::Indices, Filter::None) => matches!(stride, 2 | 4),
            (Mode::Attributes, Filter::None | Filter::Exponential) => stride % 4 == 0 && (4..=256).contains(&stride),
            (Mode::Attributes, Filter::Octahedral | Filter::Color) => matches!(stride, 4 | 8),
            (Mode::Attributes, Filter::Quaternion) => stride == 8,
            _ => false,
        };
        if !allowed {
            let problem =
                format!("has no data of {count} elements of {stride} bytes in mode {mode:?} with filter {filter:?}");
            return Err(Flaw::malformed(place, problem));
        }
        let length = count.checked_mul(stride);
        if length != Some(view_length) {
            let problem = format!("has {count} elements of {stride} bytes for a view of {view_length} bytes");
            return Err(Flaw::malformed(place, problem));
        }
        if view_length > limits::DECOMPRESSED_BYTES {
            let problem = format!("asks for {view_length} bytes");
            return Err(Flaw::new(Trouble::TooLarge, place, problem, "Split the mesh"));
        }
        Ok(read)
    }

    /// Decodes the stream `bytes`.
    pub(crate) fn decode(&self, bytes: &[u8], place: &str) -> Result<Vec<u8>, Flaw> {
        let (count, stride) = (self.count as usize, self.byte_stride as usize);
        let decoded = match self.mode {
            Mode::Attributes => attributes::decode(bytes, count, stride),
            Mode::Triangles => indices::triangles(bytes, count).map(|list| indices::store(&list, stride)),
            Mode::Indices => indices::sequence(bytes, count).map(|list| indices::store(&list, stride)),
        };
        let mut decoded = decoded.map_err(|broken| Flaw::malformed(place, format!("has a stream that {broken}")))?;
        match self.filter {
            Filter::None => {}
            Filter::Octahedral => filters::octahedral(&mut decoded, stride),
            Filter::Quaternion => filters::quaternion(&mut decoded),
            Filter::Exponential => filters::exponential(&mut decoded),
            Filter::Color => filters::color(&mut decoded, stride),
        }
        Ok(decoded)
    }
}
