//! Which extensions are understood, and what becomes of the others.

use gltf::json::{Root, buffer};

use crate::error::{Flaw, Trouble};
use crate::warnings::Warnings;
use crate::{image_based_light, material, material_layers, variants, volume_scatter};

/// Extensions whose meaning reaches the picture.
const UNDERSTOOD: [&str; 27] = [
    DRACO,
    MESHOPT[0],
    MESHOPT[1],
    "KHR_lights_punctual",
    material_layers::ANISOTROPY,
    material_layers::CLEARCOAT,
    material_layers::DIFFUSE_TRANSMISSION,
    material::DISPERSION,
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    material_layers::IRIDESCENCE,
    "KHR_materials_pbrSpecularGlossiness",
    material_layers::SHEEN,
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    variants::NAME,
    "KHR_materials_volume",
    volume_scatter::NAME,
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
    image_based_light::NAME,
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    // These do not change how a still picture looks.
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

pub(crate) const DRACO: &str = "KHR_draco_mesh_compression";
const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// How to get rid of an extension.
fn mend(name: &str) -> String {
    match name {
        "KHR_texture_basisu" | "MSFT_texture_dds" | "EXT_texture_avif" => {
            "Export the scene with PNG, JPEG or WebP textures".into()
        }
        _ => format!("Export the scene without {name}"),
    }
}

/// The error of needing `name`.
pub(crate) fn unsupported(place: &str, name: &str) -> Flaw {
    Flaw::new(Trouble::Unsupported, place, format!("needs {name}, which is not supported"), mend(name))
}

/// An extension that a file requires and that is not understood is an error, which names a texture that needs it if one does.
pub(crate) fn check_required(root: &Root) -> Result<(), Flaw> {
    let unknown = root.extensions_required.iter().find(|name| !UNDERSTOOD.contains(&name.as_str()));
    let Some(name) = unknown else { return Ok(()) };
    let needs = |texture: &gltf::json::Texture| {
        texture.extensions.as_ref().is_some_and(|extensions| extensions.others.contains_key(name))
    };
    let place = match root.textures.iter().position(needs) {
        Some(texture) => format!("textures[{texture}]"),
        None => "extensionsRequired".into(),
    };
    Err(unsupported(&place, name))
}

/// Names the extensions that a file uses and that are ignored.
pub(crate) fn note_ignored(root: &Root, warnings: &mut Warnings) {
    for name in &root.extensions_used {
        let consequence = match name.as_str() {
            known if UNDERSTOOD.contains(&known) => continue,
            "KHR_environment_map" => "is not supported: give a latitude-longitude map by --environment",
            "EXT_lights_ies" => "is not supported: its lights shine as if the extension were not there",
            "KHR_animation_pointer" => "is not supported: the scene is shown at rest",
            _ => "is not supported and has no effect",
        };
        warnings.note(name, "extensionsUsed", consequence);
    }
}

/// The extension that says how a buffer view is compressed, if it is, with its name.
pub(crate) fn meshopt(view: &buffer::View) -> Option<(&'static str, &serde_json::Value)> {
    let others = &view.extensions.as_ref()?.others;
    MESHOPT.into_iter().find_map(|name| Some((name, others.get(name)?)))
}

/// The extension that says where a primitive's compressed geometry is, if it is compressed.
pub(crate) fn draco(primitive: &gltf::json::mesh::Primitive) -> Option<&serde_json::Value> {
    primitive.extensions.as_ref()?.others.get(DRACO)
}
