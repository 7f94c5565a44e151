//! KHR_materials_variants: other materials for the same primitives, chosen by name.

use gltf::json::mesh::Primitive;
use gltf::json::{Index, Material, Root};
use serde::Deserialize;
use serde_json::Value;

use crate::error::{Flaw, Trouble};

pub(crate) const NAME: &str = "KHR_materials_variants";

#[derive(Deserialize)]
struct Named {
    name: String,
}

#[derive(Deserialize)]
struct Mapping {
    material: Index<Material>,
    variants: Vec<usize>,
}

/// The names of the file's variants, in its order.
pub(crate) fn names(root: &Root) -> Result<Vec<String>, Flaw> {
    let extension = root.extensions.as_ref().and_then(|e| e.others.get(NAME));
    let Some(list) = extension.and_then(|e| e.get("variants")) else { return Ok(Vec::new()) };
    let named: Vec<Named> = parsed(list, &format!("extensions.{NAME}.variants"))?;
    Ok(named.into_iter().map(|variant| variant.name).collect())
}

/// The number of the variant named `wanted`; none is wanted if it is empty.
pub(crate) fn choose(names: &[String], wanted: &str) -> Result<Option<usize>, Flaw> {
    if wanted.is_empty() {
        return Ok(None);
    }
    if let Some(index) = names.iter().position(|name| name == wanted) {
        return Ok(Some(index));
    }
    let (problem, mend) = if names.is_empty() {
        (format!("has no variants, so there is none named {wanted:?}"), "Leave the variant out".into())
    } else {
        let known = names.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ");
        (format!("has no variant named {wanted:?}"), format!("Choose one of {known}"))
    };
    Err(Flaw::new(Trouble::Unsupported, format!("extensions.{NAME}"), problem, mend))
}

/// The material that `primitive` at `place` has in a variant, if the variant gives it one.
pub(crate) fn material(primitive: &Primitive, variant: usize, place: &str) -> Result<Option<Index<Material>>, Flaw> {
    let extension = primitive.extensions.as_ref().and_then(|e| e.others.get(NAME));
    let Some(list) = extension.and_then(|e| e.get("mappings")) else { return Ok(None) };
    let mappings: Vec<Mapping> = parsed(list, &format!("{place}.extensions.{NAME}.mappings"))?;
    Ok(mappings.into_iter().find(|mapping| mapping.variants.contains(&variant)).map(|mapping| mapping.material))
}

fn parsed<T: for<'de> Deserialize<'de>>(value: &Value, place: &str) -> Result<T, Flaw> {
    T::deserialize(value).map_err(|e| Flaw::malformed(place, e.to_string()))
}
