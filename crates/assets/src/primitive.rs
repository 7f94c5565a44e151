//! A glTF primitive as a triangle mesh.

use ergodic_geometry::Mesh;
use glam::{DVec2, DVec3, DVec4};
use gltf::json;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use crate::accessor::{self, Rows};
use crate::document::Document;
use crate::error::Flaw;
use crate::warnings::Warnings;
use crate::{extensions, variants};

/// Reads the geometry of a primitive; `None` if it draws no triangles.
pub(crate) fn read(
    document: &Document,
    primitive: &Primitive,
    place: &str,
    warnings: &mut Warnings,
) -> Result<Option<Mesh>, Flaw> {
    let Checked::Valid(mode) = primitive.mode else {
        return Err(Flaw::malformed(format!("{place}.mode"), "is not one of glTF's primitive modes"));
    };
    if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        warnings.note("Points and lines", place, "have no surface and are not shown");
        return Ok(None);
    }
    let attribute = |semantic: Semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let Some(positions) = attribute(Semantic::Positions) else {
        warnings.note("A primitive without POSITION", place, "is not shown");
        return Ok(None);
    };
    if let Some(name) = extensions::compression_of_primitive(primitive) {
        let stored = document.root.accessors.get(positions.value()).is_some_and(|a| a.buffer_view.is_some());
        if !stored {
            return Err(extensions::unsupported(place, name));
        }
    }
    note_what_stands_still(primitive, place, warnings);

    let at = |name: &str| format!("{place}.attributes.{name}");
    let positions = accessor::vectors(document, positions, &[3], 0.0, &at("POSITION"))?;
    let vertices = positions.rows.len();
    let optional = |semantic: Semantic, name: &str, allowed: &[usize], fill: f64| -> Result<Option<Rows>, Flaw> {
        let Some(index) = attribute(semantic) else { return Ok(None) };
        let rows = accessor::vectors(document, index, allowed, fill, &at(name))?;
        if rows.rows.len() == vertices {
            Ok(Some(rows))
        } else {
            let problem = format!("has {} entries for {vertices} vertices", rows.rows.len());
            Err(Flaw::malformed(at(name), problem))
        }
    };
    let normals = optional(Semantic::Normals, "NORMAL", &[3], 0.0)?;
    // Tangents without normals are to be ignored (section 3.7.2.1).
    let tangents = if normals.is_some() { optional(Semantic::Tangents, "TANGENT", &[4], 0.0)? } else { None };
    let first = optional(Semantic::TexCoords(0), "TEXCOORD_0", &[2], 0.0)?;
    let second = optional(Semantic::TexCoords(1), "TEXCOORD_1", &[2], 0.0)?;
    let colors = optional(Semantic::Colors(0), "COLOR_0", &[3, 4], 1.0)?;

    let order = match primitive.indices {
        Some(index) => accessor::indices(document, index, &format!("{place}.indices"))?,
        None => (0..vertices as u32).collect(),
    };
    if let Some(bad) = order.iter().find(|&&i| i as usize >= vertices) {
        let problem = format!("names vertex {bad}, but there are {vertices} vertices");
        return Err(Flaw::malformed(format!("{place}.indices"), problem));
    }
    let triangles = triangles(mode, &order, place, warnings);
    if triangles.is_empty() {
        return Ok(None);
    }
    let three = |rows: Rows| rows.rows.into_iter().map(|[x, y, z, _]| DVec3::new(x, y, z));
    let uv = |rows: Rows| rows.rows.into_iter().map(|[u, v, ..]| DVec2::new(u, v)).collect();
    Ok(Some(Mesh {
        positions: three(positions).collect(),
        triangles,
        normals: normals.map(|rows| three(rows).map(DVec3::normalize_or_zero).collect()),
        tangents: tangents.map(|rows| rows.rows.into_iter().map(unit_tangent).collect()),
        texcoords: [first.map(uv), second.map(uv)],
        colors: colors
            .map(|rows| rows.rows.into_iter().map(|c| DVec4::from_array(c).clamp(DVec4::ZERO, DVec4::ONE)).collect()),
    }))
}

fn unit_tangent([x, y, z, sign]: [f64; 4]) -> DVec4 {
    DVec3::new(x, y, z).normalize_or_zero().extend(if sign < 0.0 { -1.0 } else { 1.0 })
}

fn note_what_stands_still(primitive: &Primitive, place: &str, warnings: &mut Warnings) {
    if primitive.targets.as_ref().is_some_and(|targets| !targets.is_empty()) {
        warnings.note("Morph targets", place, "are not supported: the mesh is shown without them");
    }
    let further = |semantic: &Checked<Semantic>| {
        matches!(semantic, Checked::Valid(Semantic::TexCoords(2..) | Semantic::Colors(1..)))
    };
    if primitive.attributes.keys().any(further) {
        warnings.note("Texture coordinates beyond two sets and colours beyond one", place, "are not read");
    }
}

/// Triangles as the three modes list them (section 3.7.2.1).
fn triangles(mode: Mode, order: &[u32], place: &str, warnings: &mut Warnings) -> Vec<[u32; 3]> {
    let incomplete = match mode {
        Mode::Triangles => !order.len().is_multiple_of(3),
        _ => order.len() < 3,
    };
    if incomplete {
        warnings.note("An incomplete triangle", place, "is not shown");
    }
    match mode {
        Mode::TriangleStrip => {
            let swap = |(i, t): (usize, &[u32])| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[0], t[2], t[1]] };
            order.windows(3).enumerate().map(swap).collect()
        }
        Mode::TriangleFan => match order {
            [hub, rim @ ..] => rim.windows(2).map(|edge| [*hub, edge[0], edge[1]]).collect(),
            [] => Vec::new(),
        },
        _ => order.as_chunks::<3>().0.to_vec(),
    }
}

/// Name of a primitive's place in the file.
pub(crate) fn place(mesh: usize, primitive: usize) -> String {
    format!("meshes[{mesh}].primitives[{primitive}]")
}

/// The material index of a primitive, in the chosen variant if there is one, checked.
pub(crate) fn material(
    document: &Document,
    primitive: &Primitive,
    variant: Option<usize>,
    place: &str,
) -> Result<Option<json::Index<json::Material>>, Flaw> {
    let varied = match variant {
        Some(variant) => variants::material(primitive, variant, place)?,
        None => None,
    };
    let Some(index) = varied.or(primitive.material) else { return Ok(None) };
    let count = document.root.materials.len();
    if index.value() < count {
        Ok(Some(index))
    } else {
        Err(Flaw::dangling(format!("{place}.material"), "materials", index.value(), count))
    }
}
