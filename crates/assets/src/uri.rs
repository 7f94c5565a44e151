//! Where buffers and images are: data URIs and files beside the scene.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

use crate::error::{Flaw, Trouble};
use crate::limits;

/// Base64 as exporters write it: with padding or without.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// Reads a regular file of bounded size.
pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>, String> {
    // Opening a pipe would block, so the kind is asked first.
    let metadata = std::fs::metadata(path).map_err(|e| e.to_string())?;
    if metadata.is_dir() {
        return Err("it is a folder".into());
    }
    if !metadata.is_file() {
        return Err("it is not a regular file".into());
    }
    if metadata.len() > limits::FILE_BYTES {
        return Err(format!("it is larger than {} bytes", limits::FILE_BYTES));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|e| e.to_string())?;
    file.take(limits::FILE_BYTES).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    Ok(bytes)
}

/// The bytes a URI stands for. `folder` is that of the scene's file; `None` if the scene did not come from a file.
pub(crate) fn resolve(uri: &str, folder: Option<&Path>, place: &str) -> Result<Vec<u8>, Flaw> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (header, body) =
            data.split_once(',').ok_or_else(|| Flaw::malformed(place, "is a data URI without a comma"))?;
        if header.ends_with(";base64") {
            let decoded = BASE64.decode(body.trim_end());
            return decoded.map_err(|e| Flaw::malformed(place, format!("is a data URI with broken base64: {e}")));
        }
        return Ok(percent_decode_str(body).collect());
    }
    let path = file_path(uri, place)?;
    let Some(folder) = folder else {
        let problem = format!("refers to the file {uri:?}, but the scene did not come from a folder");
        return Err(Flaw::new(Trouble::Unreadable, place, problem, "Put the data into the GLB"));
    };
    let path = folder.join(path);
    read_file(&path).map_err(|why| {
        let problem = format!("cannot read {}: {why}", path.display());
        Flaw::new(Trouble::Unreadable, place, problem, "Put the file there, or export the scene as one .glb")
    })
}

fn file_path(uri: &str, place: &str) -> Result<PathBuf, Flaw> {
    let has_scheme = uri.split_once(':').is_some_and(|(scheme, _)| {
        scheme.len() > 1 && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
    });
    if has_scheme {
        let problem = format!("refers to {uri:?}; only data URIs and relative paths are read");
        return Err(Flaw::new(
            Trouble::Unsupported,
            place,
            problem,
            "Fetch the file and refer to it by a relative path",
        ));
    }
    let decoded = percent_decode_str(uri).decode_utf8();
    let decoded = decoded.map_err(|_| Flaw::malformed(place, format!("has the URI {uri:?}, which is not UTF-8")))?;
    if decoded.is_empty() || decoded.contains('\0') {
        return Err(Flaw::malformed(place, format!("has the URI {uri:?}, which names no file")));
    }
    let path = PathBuf::from(decoded.as_ref());
    if path.is_absolute() {
        return Err(Flaw::malformed(place, format!("refers to the absolute path {decoded:?}; paths must be relative")));
    }
    Ok(path)
}
