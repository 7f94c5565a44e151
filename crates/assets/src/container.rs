//! The two containers of glTF 2.0: plain JSON, and binary GLB (section 4.4).

use crate::error::{Flaw, Trouble};

const MAGIC: u32 = 0x4654_6c67;
const JSON: u32 = 0x4e4f_534a;
const BIN: u32 = 0x004e_4942;

/// The parts of a file.
#[derive(Debug)]
pub(crate) struct Container<'a> {
    pub json: &'a [u8],
    pub binary: Option<&'a [u8]>,
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..at.checked_add(4)?).and_then(|w| w.try_into().ok()).map(u32::from_le_bytes)
}

/// Splits a file into its parts; what does not begin with GLB's magic number is taken for JSON.
pub(crate) fn split(bytes: &[u8]) -> Result<Container<'_>, Flaw> {
    if word(bytes, 0) != Some(MAGIC) {
        return Ok(Container { json: bytes, binary: None });
    }
    let truncated = |what: &str| {
        Flaw::new(
            Trouble::Malformed,
            "GLB container",
            format!("ends inside {what}"),
            "The file is cut off: copy it again",
        )
    };
    let version = word(bytes, 4).ok_or_else(|| truncated("the header"))?;
    if version != 2 {
        let problem = format!("is GLB version {version}, but only version 2 is read");
        return Err(Flaw::new(Trouble::Unsupported, "GLB header", problem, "Export the scene as glTF 2.0"));
    }
    let length = word(bytes, 8).ok_or_else(|| truncated("the header"))? as usize;
    let bytes = bytes.get(..length).ok_or_else(|| truncated("what the header announces"))?;

    let mut json = None;
    let mut binary = None;
    let mut at = 12;
    while at < bytes.len() {
        let length = word(bytes, at).ok_or_else(|| truncated("a chunk's header"))? as usize;
        let kind = word(bytes, at + 4).ok_or_else(|| truncated("a chunk's header"))?;
        let body = (at + 8).checked_add(length).and_then(|end| bytes.get(at + 8..end));
        let body = body.ok_or_else(|| truncated("a chunk"))?;
        match kind {
            JSON if json.is_none() => json = Some(body),
            BIN if binary.is_none() => binary = Some(body),
            // Chunks of other kinds are to be ignored.
            _ => {}
        }
        at += 8 + length;
    }
    let json = json.ok_or_else(|| Flaw::malformed("GLB container", "has no JSON chunk"))?;
    Ok(Container { json, binary })
}
