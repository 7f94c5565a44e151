//! glTF 2.0 files and images to a [`ergodic_pathspace::SceneDescription`]: all checks of input.
//!
//! Nothing in a file is trusted: every index, length, offset and enumeration is checked before it is used, sizes are
//! bounded, and what is wrong comes back as an [`AssetError`] that names the file, the place and the mend.
//!
//! ```no_run
//! let asset = ergodic_assets::load("scenes/ring/scene.glb".as_ref())?;
//! for warning in &asset.warnings {
//!     eprintln!("{warning}");
//! }
//! println!("{} placed meshes", asset.description.placements.len());
//! # Ok::<(), ergodic_assets::AssetError>(())
//! ```

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod accessor;
mod asset;
mod camera;
mod container;
mod document;
mod draco;
mod environment;
mod error;
mod extensions;
mod hierarchy;
mod image_based_light;
mod library;
mod limits;
mod material;
mod material_layers;
mod meshopt;
mod morph;
mod primitive;
mod skin;
mod tangents;
mod texture;
mod uri;
mod variants;
mod volume_scatter;
mod warnings;

use std::path::Path;

use ergodic_pathspace::{Effects, SceneDescription};
use ergodic_scattering::Medium;

pub use asset::{Asset, CameraError, Summary};
use document::Document;
pub use environment::load_environment;
use error::Flaw;
pub use error::{AssetError, Trouble};
use library::Library;
use warnings::Warnings;

/// Loads a `.glb` or `.gltf` file with the buffers and images it refers to.
///
/// # Errors
///
/// A file that cannot be read, breaks the specification where it matters, requires an extension that is not understood,
/// or asks for too much memory.
pub fn load(path: &Path) -> Result<Asset, AssetError> {
    load_variant(path, "")
}

/// Like [`load`], with the materials of the variant (KHR_materials_variants) that has this name; empty for the default.
///
/// # Errors
///
/// Like [`load`], and if there is no such variant.
pub fn load_variant(path: &Path, variant: &str) -> Result<Asset, AssetError> {
    let name = path.display().to_string();
    let bytes = uri::read_file(path).map_err(|why| {
        let mend = "Give the path of a .glb or .gltf file";
        Flaw::new(Trouble::Unreadable, "", format!("cannot be read: {why}"), mend).in_file(&name)
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    build(&bytes, Some(folder), &name, variant).map_err(|flaw| flaw.in_file(&name))
}

/// Loads a file from memory; `name` stands for it in messages. URIs of other files are errors.
///
/// # Errors
///
/// Like [`load`].
pub fn from_bytes(bytes: &[u8], name: &str) -> Result<Asset, AssetError> {
    from_bytes_variant(bytes, name, "")
}

/// Like [`from_bytes`], with a variant as [`load_variant`] takes it.
///
/// # Errors
///
/// Like [`load_variant`].
pub fn from_bytes_variant(bytes: &[u8], name: &str, variant: &str) -> Result<Asset, AssetError> {
    build(bytes, None, name, variant).map_err(|flaw| flaw.in_file(name))
}

fn build(bytes: &[u8], folder: Option<&Path>, name: &str, variant: &str) -> Result<Asset, Flaw> {
    let document = Document::parse(bytes, folder)?;
    let root = &document.root;
    let mut warnings = Warnings::default();
    extensions::note_ignored(root, &mut warnings);
    if document.animated {
        warnings.note("Animations", "", "are not supported: the scene is shown at rest");
    }
    let variants = variants::names(root)?;
    let chosen = variants::choose(&variants, variant)?;
    let mut library = Library::new(&document, chosen);
    let world = hierarchy::place(&document, &mut library, &mut warnings)?;
    let environment = image_based_light::read(&document, &mut warnings)?;
    let summary = Summary {
        version: root.asset.version.clone(),
        generator: root.asset.generator.clone(),
        copyright: root.asset.copyright.clone(),
        extensions_used: root.extensions_used.clone(),
        extensions_required: root.extensions_required.clone(),
        variants,
        cameras: world.cameras.iter().map(|c| (c.number, c.camera_name.clone())).collect(),
    };
    let description = SceneDescription {
        ready_for: Effects::default(),
        meshes: library.meshes,
        placements: world.placements,
        materials: library.materials,
        textures: library.textures.textures,
        lights: world.lights,
        environment,
        medium: Medium::VACUUM,
        cameras: world.cameras.into_iter().map(|c| c.description).collect(),
    };
    volume_scatter::warn_of_open_meshes(&description, &mut warnings);
    let (warnings, notes) = warnings.into_sentences();
    Ok(Asset { file: name.into(), description, warnings, notes, summary })
}
