//! Skins in the pose in which their joints stand (section 3.7.3).

use ergodic_geometry::Mesh;
use glam::{DAffine3, DMat3, DVec3};
use gltf::json;

use crate::accessor::{self, Rows};
use crate::document::{Document, get};
use crate::error::Flaw;
use crate::warnings::Warnings;

/// A skin whose joints stand in the world.
pub(crate) struct Skin {
    /// For each joint from the mesh's space, at the time of binding, to the world.
    joints: Vec<DAffine3>,
}

/// Which joints move the vertices of a primitive: for each set JOINTS_n with WEIGHTS_n.
pub(crate) struct Influences {
    pub sets: Vec<(Rows, Rows)>,
}

impl Skin {
    /// The skin of a node; `None`, with a warning, if a joint does not stand in the scene. `worlds` has the transforms of the
    /// nodes that do.
    pub(crate) fn read(
        document: &Document,
        index: usize,
        worlds: &[Option<DAffine3>],
        place: &str,
        warnings: &mut Warnings,
    ) -> Result<Option<Self>, Flaw> {
        let count = document.skins.len();
        let skin = document.skins.get(index);
        let skin = skin.ok_or_else(|| Flaw::dangling(format!("{place}.skin"), "skins", index, count))?;
        let place = format!("skins[{index}]");
        let skin: json::Skin =
            serde_json::from_value(skin.clone()).map_err(|e| Flaw::malformed(&place, e.to_string()))?;
        let inverse = match skin.inverse_bind_matrices {
            Some(index) => accessor::matrices(document, index, &format!("{place}.inverseBindMatrices"))?,
            None => vec![DAffine3::IDENTITY; skin.joints.len()],
        };
        if inverse.len() < skin.joints.len() {
            let problem = format!("has {} matrices for {} joints", inverse.len(), skin.joints.len());
            return Err(Flaw::malformed(format!("{place}.inverseBindMatrices"), problem));
        }
        let mut joints = Vec::with_capacity(skin.joints.len());
        for (i, (joint, inverse)) in skin.joints.iter().zip(&inverse).enumerate() {
            get(&document.root.nodes, *joint, "nodes", &format!("{place}.joints[{i}]"))?;
            let Some(world) = worlds[joint.value()] else {
                let said = "has no place in the scene: the mesh is shown as modelled, at its node";
                warnings.note("A joint of a skin", format!("{place}.joints[{i}]"), said);
                return Ok(None);
            };
            joints.push(world * *inverse);
        }
        Ok(Some(Self { joints }))
    }

    /// Moves a mesh to where its joints stand in the world. Normals are moved by the inverse transposed matrices, as those of
    /// placed meshes are, and triangles that the joints mirror are turned round, as those of mirrored nodes are.
    pub(crate) fn bend(&self, mesh: &mut Mesh, influences: &Influences, place: &str) -> Result<(), Flaw> {
        let mut blended = Vec::with_capacity(mesh.positions.len());
        for vertex in 0..mesh.positions.len() {
            blended.push(self.blend(vertex, influences, place)?);
        }
        for (position, matrix) in mesh.positions.iter_mut().zip(&blended) {
            *position = matrix.transform_point3(*position);
        }
        if mesh.positions.iter().any(|p| !p.is_finite()) {
            return Err(Flaw::malformed(place, "is moved by its skin to where coordinates are not finite"));
        }
        for (normal, matrix) in mesh.normals.iter_mut().flatten().zip(&blended) {
            *normal = (cofactors(&matrix.matrix3) * *normal).normalize_or_zero();
        }
        for (tangent, matrix) in mesh.tangents.iter_mut().flatten().zip(&blended) {
            let sign = tangent.w * 1f64.copysign(matrix.matrix3.determinant());
            *tangent = (matrix.matrix3 * tangent.truncate()).normalize_or_zero().extend(sign);
        }
        for triangle in &mut mesh.triangles {
            if triangle.iter().all(|&i| blended[i as usize].matrix3.determinant() < 0.0) {
                triangle.swap(1, 2);
            }
        }
        Ok(())
    }

    /// The mean of the joints' matrices by a vertex's weights. A vertex without weights stays as modelled.
    fn blend(&self, vertex: usize, influences: &Influences, place: &str) -> Result<DAffine3, Flaw> {
        let mut total = 0.0;
        let mut sum = DAffine3::from_mat3(DMat3::ZERO);
        for (set, (joints, weights)) in influences.sets.iter().enumerate() {
            for (&joint, &weight) in joints.rows[vertex].iter().zip(&weights.rows[vertex]) {
                if weight <= 0.0 {
                    continue;
                }
                // Joints were read from integers; a fraction cannot be an index.
                let matrix = self.joints.get(joint as usize).filter(|_| joint >= 0.0 && joint.fract() == 0.0);
                let matrix = matrix.ok_or_else(|| {
                    let problem =
                        format!("names joint {joint} at vertex {vertex}, but the skin has {}", self.joints.len());
                    Flaw::malformed(format!("{place}.attributes.JOINTS_{set}"), problem)
                })?;
                sum.matrix3 += matrix.matrix3 * weight;
                sum.translation += matrix.translation * weight;
                total += weight;
            }
        }
        if total > 0.0 {
            Ok(DAffine3 { matrix3: sum.matrix3 * (1.0 / total), translation: sum.translation / total })
        } else {
            Ok(DAffine3::IDENTITY)
        }
    }
}

/// The inverse transposed matrix up to a positive factor, which exists for singular matrices too.
fn cofactors(m: &DMat3) -> DMat3 {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    cofactors * 1f64.copysign(x.dot(DVec3::cross(y, z)))
}
