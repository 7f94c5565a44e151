//! The meshes, materials and textures that the scene has come to need, each read once.

use std::collections::HashMap;

use ergodic_geometry::Mesh;
use ergodic_scattering::Material;
use gltf::json::{self, Index};

use crate::document::{Document, get};
use crate::error::{Flaw, Trouble};
use crate::primitive::Geometry;
use crate::skin::Skin;
use crate::texture::Textures;
use crate::warnings::Warnings;
use crate::{limits, material, morph, primitive, tangents};

/// A primitive that is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    /// Whether a skin has moved it, so that it stands in the world already.
    pub bent: bool,
    /// Index into the description's meshes.
    pub mesh: usize,
    /// Index into the description's materials.
    pub material: usize,
}

/// Reads what nodes refer to.
pub(crate) struct Library<'a> {
    document: &'a Document,
    pub meshes: Vec<Mesh>,
    vertices: usize,
    pub materials: Vec<Material>,
    pub textures: Textures,
    /// By mesh and the bits of the morph weights.
    parts: HashMap<(usize, Vec<u64>), Vec<Part>>,
    /// From the file's materials to ours; `None` is the default material.
    known: HashMap<Option<usize>, usize>,
    /// The chosen one of KHR_materials_variants.
    variant: Option<usize>,
}

impl<'a> Library<'a> {
    pub(crate) fn new(document: &'a Document, variant: Option<usize>) -> Self {
        let textures = Textures::default();
        let (parts, known) = (HashMap::new(), HashMap::new());
        Self { document, meshes: Vec::new(), vertices: 0, materials: Vec::new(), textures, parts, known, variant }
    }

    /// The parts of a mesh that a node shows, at the node's morph weights and in the pose of its skin.
    pub(crate) fn parts(
        &mut self,
        node: &json::Node,
        index: Index<json::Mesh>,
        skin: Option<&Skin>,
        place: &str,
        warnings: &mut Warnings,
    ) -> Result<Vec<Part>, Flaw> {
        let mesh = get(&self.document.root.meshes, index, "meshes", &format!("{place}.mesh"))?;
        let weights = morph::weights(node, mesh, place)?;
        let key = (index.value(), weights.iter().map(|w| w.to_bits()).collect());
        if skin.is_some() {
            return self.read(index.value(), &weights, skin, warnings);
        }
        if let Some(parts) = self.parts.get(&key) {
            return Ok(parts.clone());
        }
        let parts = self.read(index.value(), &weights, None, warnings)?;
        self.parts.insert(key, parts.clone());
        Ok(parts)
    }

    fn read(
        &mut self,
        index: usize,
        weights: &[f64],
        skin: Option<&Skin>,
        warnings: &mut Warnings,
    ) -> Result<Vec<Part>, Flaw> {
        let document = self.document;
        let mut parts = Vec::new();
        for (i, primitive) in document.root.meshes[index].primitives.iter().enumerate() {
            let place = primitive::place(index, i);
            let read = primitive::read(document, primitive, weights, skin.is_some(), &place, warnings)?;
            let Some(Geometry { mut mesh, influences }) = read else { continue };
            if primitive.targets.as_ref().is_some_and(|targets| !targets.is_empty()) {
                warnings.mention("Morph targets", &place, "are shown at the weights that the file states");
            }
            let bent = skin.zip(influences.as_ref());
            if let Some((skin, influences)) = bent {
                skin.bend(&mut mesh, influences, &place)?;
            }
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
            self.vertices += mesh.positions.len();
            if self.vertices > limits::VERTICES {
                let problem = format!("is where all meshes together exceed {} vertices", limits::VERTICES);
                return Err(Flaw::new(Trouble::TooLarge, place, problem, "Split the scene"));
            }
            self.meshes.push(mesh);
            parts.push(Part { bent: bent.is_some(), mesh: self.meshes.len() - 1, material });
        }
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
