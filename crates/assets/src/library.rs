//! The meshes, materials and textures that the scene has come to need, each read once.

use std::collections::HashMap;

use ergodic_geometry::Mesh;
use ergodic_scattering::Material;
use gltf::json::{self, Index};

use crate::document::{Document, get};
use crate::error::Flaw;
use crate::texture::Textures;
use crate::warnings::Warnings;
use crate::{material, primitive, tangents};

/// A primitive that is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    /// Index into the description's meshes.
    pub mesh: usize,
    /// Index into the description's materials.
    pub material: usize,
}

/// Reads what nodes refer to.
pub(crate) struct Library<'a> {
    document: &'a Document,
    pub meshes: Vec<Mesh>,
    pub materials: Vec<Material>,
    pub textures: Textures,
    parts: HashMap<usize, Vec<Part>>,
    /// From the file's materials to ours; `None` is the default material.
    known: HashMap<Option<usize>, usize>,
    /// The chosen one of KHR_materials_variants.
    variant: Option<usize>,
}

impl<'a> Library<'a> {
    pub(crate) fn new(document: &'a Document, variant: Option<usize>) -> Self {
        let textures = Textures::default();
        let (parts, known) = (HashMap::new(), HashMap::new());
        Self { document, meshes: Vec::new(), materials: Vec::new(), textures, parts, known, variant }
    }

    /// The parts of a mesh that a node refers to.
    pub(crate) fn parts(
        &mut self,
        index: Index<json::Mesh>,
        place: &str,
        warnings: &mut Warnings,
    ) -> Result<Vec<Part>, Flaw> {
        if let Some(parts) = self.parts.get(&index.value()) {
            return Ok(parts.clone());
        }
        let document = self.document;
        let mesh = get(&document.root.meshes, index, "meshes", &format!("{place}.mesh"))?;
        if mesh.weights.iter().flatten().any(|w| *w != 0.0) {
            let place = format!("meshes[{}]", index.value());
            warnings.note("Morph targets with weights", place, "are not supported: the mesh is shown without them");
        }
        let mut parts = Vec::new();
        for (i, primitive) in mesh.primitives.iter().enumerate() {
            let place = primitive::place(index.value(), i);
            let Some(mut mesh) = primitive::read(document, primitive, &place, warnings)? else { continue };
            let material = primitive::material(document, primitive, self.variant, &place)?;
            let material = self.material(material.map(|m| m.value()), warnings)?;
            if let Some(texcoord) = self.materials[material].tangent_texcoord()
                && mesh.tangents.is_none()
            {
                tangents::generate(&mut mesh, texcoord);
                if mesh.tangents.is_none() {
                    let subject = "Normal maps and anisotropy on a mesh without tangents and texture coordinates";
                    warnings.note(subject, &place, "have no direction to go by and no effect");
                }
            }
            self.meshes.push(mesh);
            parts.push(Part { mesh: self.meshes.len() - 1, material });
        }
        self.parts.insert(index.value(), parts.clone());
        Ok(parts)
    }

    fn material(&mut self, index: Option<usize>, warnings: &mut Warnings) -> Result<usize, Flaw> {
        if let Some(&known) = self.known.get(&index) {
            return Ok(known);
        }
        let material = match index {
            Some(index) => material::read(self.document, index, &mut self.textures, warnings)?,
            None => Material { name: "default".into(), ..Material::default() },
        };
        self.materials.push(material);
        self.known.insert(index, self.materials.len() - 1);
        Ok(self.materials.len() - 1)
    }
}
