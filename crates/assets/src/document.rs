//! A parsed file with its buffers: every look-up checked, every error with its place.

use std::cell::{Cell, OnceCell};
use std::path::{Path, PathBuf};

use gltf::json::{self, Index, Root};

use crate::container::Container;
use crate::error::{Flaw, Trouble};
use crate::meshopt::Compressed;
use crate::{container, extensions, limits, uri};

/// The JSON of a file and the bytes its buffers hold.
#[derive(Debug)]
pub(crate) struct Document {
    pub root: Root,
    /// Whether the file has animations; they are not parsed.
    pub animated: bool,
    /// The skins, which are parsed where a node that is shown has one.
    pub skins: Vec<serde_json::Value>,
    /// What applications add to the cameras for themselves; null where there is nothing.
    pub camera_extras: Vec<serde_json::Value>,
    pub folder: Option<PathBuf>,
    /// A buffer that cannot be read is an error only once something needs it.
    buffers: Vec<Result<Vec<u8>, Flaw>>,
    /// The bytes of compressed views, decoded where something needs them.
    decompressed: Vec<OnceCell<Result<Vec<u8>, Flaw>>>,
    decompressed_bytes: Cell<u64>,
}

impl Document {
    pub(crate) fn parse(bytes: &[u8], folder: Option<&Path>) -> Result<Self, Flaw> {
        let Container { json, binary } = container::split(bytes)?;
        let Parsed { root, animated, skins, camera_extras } = parse_json(json)?;
        check_version(&root)?;
        extensions::check_required(&root)?;
        let mut buffers = Vec::new();
        for (i, buffer) in root.buffers.iter().enumerate() {
            buffers.push(read_buffer(i, buffer, binary, folder));
        }
        let decompressed = vec![OnceCell::new(); root.buffer_views.len()];
        let folder = folder.map(Path::to_path_buf);
        let decompressed_bytes = Cell::new(0);
        Ok(Self { root, animated, skins, camera_extras, folder, buffers, decompressed, decompressed_bytes })
    }

    /// The bytes of a buffer view.
    pub(crate) fn view(&self, index: Index<json::buffer::View>, place: &str) -> Result<&[u8], Flaw> {
        let view = get(&self.root.buffer_views, index, "bufferViews", place)?;
        let place = format!("bufferViews[{}]", index.value());
        if let Some((name, extension)) = extensions::meshopt(view) {
            let decoded = self.decompressed[index.value()].get_or_init(|| {
                let place = format!("{place}.extensions.{name}");
                self.decompress(view, extension, &place)
            });
            return decoded.as_deref().map_err(Clone::clone);
        }
        let start = view.byte_offset.map_or(0, |o| o.0);
        self.bytes(view.buffer.value(), start, view.byte_length.0, &place)
    }

    fn decompress(
        &self,
        view: &json::buffer::View,
        extension: &serde_json::Value,
        place: &str,
    ) -> Result<Vec<u8>, Flaw> {
        let compressed = Compressed::read(extension, view.byte_length.0, place)?;
        let bytes = self.bytes(compressed.buffer, compressed.byte_offset, compressed.byte_length, place)?;
        let decoded = compressed.decode(bytes, place)?;
        let total = self.decompressed_bytes.get() + decoded.len() as u64;
        self.decompressed_bytes.set(total);
        if total > limits::ALL_DECOMPRESSED_BYTES {
            let problem = format!("is where decompressed data exceed {} bytes", limits::ALL_DECOMPRESSED_BYTES);
            return Err(Flaw::new(Trouble::TooLarge, place, problem, "Split the scene"));
        }
        Ok(decoded)
    }

    /// So many bytes of a buffer from byte `start`.
    fn bytes(&self, buffer: usize, start: u64, length: u64, place: &str) -> Result<&[u8], Flaw> {
        let found = self.buffers.get(buffer);
        let found =
            found.ok_or_else(|| Flaw::dangling(format!("{place}.buffer"), "buffers", buffer, self.buffers.len()))?;
        let bytes = found.as_ref().map_err(Clone::clone)?;
        let range = start.checked_add(length).and_then(|end| {
            let range = usize::try_from(start).ok()?..usize::try_from(end).ok()?;
            bytes.get(range)
        });
        range.ok_or_else(|| {
            let total = bytes.len();
            Flaw::malformed(place, format!("takes {length} bytes from byte {start} of a buffer of {total} bytes"))
        })
    }
}

/// The entry of a list that an index stands for.
pub(crate) fn get<'a, T>(list: &'a [T], index: Index<T>, what: &str, place: &str) -> Result<&'a T, Flaw> {
    list.get(index.value()).ok_or_else(|| Flaw::dangling(place, what, index.value(), list.len()))
}

const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// The JSON: typed, but for what is not rendered or seldom.
struct Parsed {
    root: Root,
    animated: bool,
    skins: Vec<serde_json::Value>,
    camera_extras: Vec<serde_json::Value>,
}

fn parse_json(json: &[u8]) -> Result<Parsed, Flaw> {
    let json = json.strip_prefix(BYTE_ORDER_MARK).unwrap_or(json);
    let mut tree: serde_json::Value =
        serde_json::from_slice(json).map_err(|e| Flaw::malformed("JSON", e.to_string()))?;
    let Some(members) = tree.as_object_mut() else {
        return Err(Flaw::malformed("JSON", "is not an object"));
    };
    // What is not rendered need not be right.
    let skins = match members.remove("skins") {
        Some(serde_json::Value::Array(skins)) => skins,
        _ => Vec::new(),
    };
    let animated = members.remove("animations").is_some();
    // An empty scene need not list its nodes.
    for scene in members.get_mut("scenes").and_then(|s| s.as_array_mut()).into_iter().flatten() {
        if let Some(scene) = scene.as_object_mut() {
            scene.entry("nodes").or_insert_with(|| serde_json::Value::Array(Vec::new()));
        }
    }
    let cameras = members.get("cameras").and_then(|c| c.as_array()).into_iter().flatten();
    let camera_extras = cameras.map(|camera| camera.get("extras").cloned().unwrap_or_default()).collect();
    plain(&mut tree);
    let root = serde_path_to_error::deserialize(tree).map_err(|e| {
        let place = e.path().to_string();
        let place = if place == "." { "JSON".into() } else { place };
        Flaw::malformed(place, e.into_inner().to_string())
    })?;
    Ok(Parsed { root, animated, skins, camera_extras })
}

/// Takes out what applications add for themselves (`extras`, of any type) and writes integers as such: 1.0 is one too.
fn plain(tree: &mut serde_json::Value) {
    use serde_json::Value;
    /// Integers up to here are exact as floating-point numbers.
    const EXACT: f64 = 9_007_199_254_740_992.0;
    match tree {
        Value::Object(members) => {
            members.remove("extras");
            members.values_mut().for_each(plain);
        }
        Value::Array(list) => list.iter_mut().for_each(plain),
        Value::Number(number) => {
            if let Some(value) = number.as_f64()
                && number.is_f64()
                && value.fract() == 0.0
                && value.abs() <= EXACT
            {
                *number = (value as i64).into();
            }
        }
        _ => {}
    }
}

fn check_version(root: &Root) -> Result<(), Flaw> {
    let wanted = root.asset.min_version.as_ref().unwrap_or(&root.asset.version);
    // A 2.x file promises to be readable by any 2.0 reader unless it states a minimal version.
    let readable = match &root.asset.min_version {
        Some(version) => version == "2.0",
        None => wanted.split_once('.').is_some_and(|(major, minor)| {
            major == "2" && !minor.is_empty() && minor.bytes().all(|b| b.is_ascii_digit())
        }),
    };
    if readable {
        return Ok(());
    }
    let problem = format!("needs glTF version {wanted:?}, but only 2.0 is read");
    Err(Flaw::new(Trouble::Unsupported, "asset.version", problem, "Export the scene as glTF 2.0"))
}

fn read_buffer(i: usize, buffer: &json::Buffer, binary: Option<&[u8]>, folder: Option<&Path>) -> Result<Vec<u8>, Flaw> {
    let place = format!("buffers[{i}]");
    let mut bytes = match &buffer.uri {
        Some(uri) => uri::resolve(uri, folder, &format!("{place}.uri"))?,
        None => match binary {
            Some(binary) if i == 0 => binary.to_vec(),
            _ => return Err(Flaw::malformed(place, "has no uri, and the file has no binary chunk for it")),
        },
    };
    let wanted = buffer.byte_length.0;
    if (bytes.len() as u64) < wanted {
        return Err(Flaw::malformed(place, format!("should have {wanted} bytes, but there are {}", bytes.len())));
    }
    // The bytes beyond are padding.
    bytes.truncate(wanted as usize);
    Ok(bytes)
}
