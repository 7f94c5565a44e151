//! A glTF primitive as a triangle mesh.

use ergodic_geometry::Mesh;
use glam::{DVec2, DVec3, DVec4};
use gltf::json::accessor::Accessor;
use gltf::json::mesh::{Mode, MorphTarget, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{self, Index};

use crate::accessor::{self, Rows};
use crate::document::Document;
use crate::draco::Decoded;
use crate::error::Flaw;
use crate::morph;
use crate::skin::Influences;
use crate::variants;
use crate::warnings::Warnings;

/// The geometry of a primitive.
pub(crate) struct Geometry {
    pub mesh: Mesh,
    /// Which joints move the vertices; `None` if the primitive names none.
    pub influences: Option<Influences>,
}

/// Reads the attributes of one primitive.
struct Reader<'a> {
    document: &'a Document,
    primitive: &'a Primitive,
    place: &'a str,
    compressed: Option<Decoded<'a>>,
    vertices: usize,
}

impl Reader<'_> {
    fn accessor(&self, semantic: Semantic) -> Option<Index<Accessor>> {
        self.primitive.attributes.get(&Checked::Valid(semantic)).copied()
    }

    /// The values of an attribute, from the compressed data if they are there.
    fn attribute(&self, semantic: Semantic, allowed: &[usize], fill: f64) -> Result<Option<Rows>, Flaw> {
        let name = semantic.to_string();
        let Some(index) = self.accessor(semantic) else { return Ok(None) };
        if let Some(compressed) = &self.compressed
            && let Some(rows) = compressed.rows(self.document, &name, index, allowed, fill)?
        {
            return Ok(Some(rows));
        }
        let place = format!("{}.attributes.{name}", self.place);
        let rows = accessor::vectors(self.document, index, allowed, fill, &place)?;
        if rows.rows.len() != self.vertices {
            let problem = format!("has {} entries for {} vertices", rows.rows.len(), self.vertices);
            return Err(Flaw::malformed(place, problem));
        }
        Ok(Some(rows))
    }

    /// An attribute with its morph targets, at `weights`.
    fn morphed(
        &self,
        semantic: Semantic,
        allowed: &[usize],
        choose: fn(&MorphTarget) -> Option<Index<Accessor>>,
        weights: &[f64],
    ) -> Result<Option<Rows>, Flaw> {
        let name = semantic.to_string();
        let Some(mut rows) = self.attribute(semantic, allowed, 0.0)? else { return Ok(None) };
        let targets = self.primitive.targets.as_deref().unwrap_or_default();
        morph::displace(self.document, targets, weights, choose, &name, &mut rows, self.place)?;
        Ok(Some(rows))
    }

    fn influences(&self) -> Result<Option<Influences>, Flaw> {
        let mut sets = Vec::new();
        for set in 0.. {
            let joints = self.attribute(Semantic::Joints(set), &[4], 0.0)?;
            let weights = self.attribute(Semantic::Weights(set), &[4], 0.0)?;
            match (joints, weights) {
                (Some(joints), Some(weights)) => sets.push((joints, weights)),
                _ => break,
            }
        }
        Ok((!sets.is_empty()).then_some(Influences { sets }))
    }
}

/// Reads the geometry of a primitive with its morph targets at `weights`; `None` if it draws no triangles. What moves its
/// vertices is read only if it is `skinned`.
pub(crate) fn read(
    document: &Document,
    primitive: &Primitive,
    weights: &[f64],
    skinned: bool,
    place: &str,
    warnings: &mut Warnings,
) -> Result<Option<Geometry>, Flaw> {
    let Checked::Valid(mode) = primitive.mode else {
        return Err(Flaw::malformed(format!("{place}.mode"), "is not one of glTF's primitive modes"));
    };
    if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        warnings.note("Points and lines", place, "have no surface and are not shown");
        return Ok(None);
    }
    let mut reader = Reader { document, primitive, place, compressed: None, vertices: 0 };
    let Some(positions) = reader.accessor(Semantic::Positions) else {
        warnings.note("A primitive without POSITION", place, "is not shown");
        return Ok(None);
    };
    reader.compressed = Decoded::read(document, primitive, place)?;
    reader.vertices = match &reader.compressed {
        Some(compressed) => compressed.vertices(),
        None => accessor::layout(document, positions, &[3], &format!("{place}.attributes.POSITION"))?.0.count(),
    };
    let vertices = reader.vertices;
    note_further_sets(primitive, place, warnings);

    let Some(positions) = reader.morphed(Semantic::Positions, &[3], |t| t.positions, weights)? else {
        return Ok(None);
    };
    let normals = reader.morphed(Semantic::Normals, &[3], |t| t.normals, weights)?;
    // Tangents without normals are to be ignored (section 3.7.2.1).
    let tangents = match normals {
        Some(_) => reader.morphed(Semantic::Tangents, &[4], |t| t.tangents, weights)?,
        None => None,
    };
    let first = reader.attribute(Semantic::TexCoords(0), &[2], 0.0)?;
    let second = reader.attribute(Semantic::TexCoords(1), &[2], 0.0)?;
    let colors = reader.attribute(Semantic::Colors(0), &[3, 4], 1.0)?;
    let influences = if skinned { reader.influences()? } else { None };

    let (mode, order) = match (&reader.compressed, primitive.indices) {
        // What is decoded are triangles, whatever the primitive's mode.
        (Some(compressed), _) => (Mode::Triangles, compressed.order()),
        (None, Some(index)) => (mode, accessor::indices(document, index, &format!("{place}.indices"))?),
        (None, None) => (mode, (0..vertices as u32).collect()),
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
    let mesh = Mesh {
        positions: three(positions).collect(),
        triangles,
        normals: normals.map(|rows| three(rows).map(DVec3::normalize_or_zero).collect()),
        tangents: tangents.map(|rows| rows.rows.into_iter().map(unit_tangent).collect()),
        texcoords: [first.map(uv), second.map(uv)],
        colors: colors
            .map(|rows| rows.rows.into_iter().map(|c| DVec4::from_array(c).clamp(DVec4::ZERO, DVec4::ONE)).collect()),
    };
    Ok(Some(Geometry { mesh, influences }))
}

fn unit_tangent([x, y, z, sign]: [f64; 4]) -> DVec4 {
    DVec3::new(x, y, z).normalize_or_zero().extend(if sign < 0.0 { -1.0 } else { 1.0 })
}

fn note_further_sets(primitive: &Primitive, place: &str, warnings: &mut Warnings) {
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
) -> Result<Option<Index<json::Material>>, Flaw> {
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
