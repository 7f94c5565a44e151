//! Geometry compressed by Draco (KHR_draco_mesh_compression).

use draco_core::{DecodeLimits, DecoderBuffer, FaceIndex, MeshDecoder};
use gltf::json::Index;
use gltf::json::accessor::Accessor;
use gltf::json::mesh::Primitive;
use serde_json::Value;

use crate::accessor::{self, Rows};
use crate::document::Document;
use crate::error::{Flaw, Trouble};
use crate::{extensions, limits};

/// The decoded geometry of a primitive.
pub(crate) struct Decoded<'a> {
    mesh: draco_core::Mesh,
    /// From attribute semantics to the numbers of the compressed attributes.
    attributes: &'a Value,
    place: String,
}

impl<'a> Decoded<'a> {
    /// Decodes a primitive's geometry; `None` if it is not compressed.
    pub(crate) fn read(document: &Document, primitive: &'a Primitive, place: &str) -> Result<Option<Self>, Flaw> {
        let Some(extension) = extensions::draco(primitive) else { return Ok(None) };
        let place = format!("{place}.extensions.{}", extensions::DRACO);
        let view = extension.get("bufferView").and_then(Value::as_u64).and_then(|i| u32::try_from(i).ok());
        let view = view.ok_or_else(|| Flaw::malformed(format!("{place}.bufferView"), "is no index"))?;
        let bytes = document.view(Index::new(view), &format!("{place}.bufferView"))?;
        let attributes = extension.get("attributes").unwrap_or(&Value::Null);

        let bounds = DecodeLimits::default()
            .with_max_points(limits::DRACO_ELEMENTS)
            .with_max_faces(limits::DRACO_ELEMENTS)
            .with_max_decoded_bytes(limits::DRACO_BYTES);
        let mut mesh = draco_core::Mesh::new();
        MeshDecoder::new().decode(&mut DecoderBuffer::new(bytes).with_limits(bounds), &mut mesh).map_err(|e| {
            let mend = "Export the scene without compression of its geometry, or export it again";
            let trouble = match e.kind() {
                draco_core::ErrorKind::LimitExceeded => Trouble::TooLarge,
                _ => Trouble::Malformed,
            };
            Flaw::new(trouble, &place, format!("cannot be decoded: {e}"), mend)
        })?;
        Ok(Some(Self { mesh, attributes, place }))
    }

    /// How many vertices there are.
    pub(crate) fn vertices(&self) -> usize {
        self.mesh.num_points()
    }

    /// The triangles' vertices.
    pub(crate) fn order(&self) -> Vec<u32> {
        (0..self.mesh.num_faces() as u32)
            .flat_map(|face| self.mesh.face(FaceIndex(face)).map(|point| point.0))
            .collect()
    }

    /// The values of an attribute, as its accessor interprets them; `None` if it is not among the compressed ones.
    pub(crate) fn rows(
        &self,
        document: &Document,
        name: &str,
        index: Index<Accessor>,
        allowed: &[usize],
        fill: f64,
    ) -> Result<Option<Rows>, Flaw> {
        let Some(id) = self.attributes.get(name) else { return Ok(None) };
        let place = format!("{}.attributes.{name}", self.place);
        let id = id.as_u64().and_then(|id| u32::try_from(id).ok());
        let attribute = id.and_then(|id| self.mesh.attribute_by_unique_id(id));
        let attribute =
            attribute.ok_or_else(|| Flaw::malformed(&place, "names no attribute of the compressed data"))?;
        let (layout, _) = accessor::layout(document, index, allowed, &place)?;
        let n = layout.components();
        if usize::from(attribute.num_components()) != n {
            let problem = format!("has {} components where its accessor has {n}", attribute.num_components());
            return Err(Flaw::malformed(place, problem));
        }
        let values = attribute.read_f32s(self.vertices(), n);
        let mut rows = vec![[fill; 4]; self.vertices()];
        for (row, values) in rows.iter_mut().zip(values.chunks_exact(n)) {
            for (to, &from) in row.iter_mut().zip(values) {
                *to = layout.dequantized(f64::from(from));
            }
        }
        accessor::usable(&rows, n, &place)?;
        Ok(Some(Rows { rows }))
    }
}
