//! Morph targets, at the weights that the file states (section 3.7.2.2).

use gltf::json::accessor::Accessor;
use gltf::json::mesh::MorphTarget;
use gltf::json::{self, Index, Node};

use crate::accessor::{self, Rows};
use crate::document::Document;
use crate::error::Flaw;

/// The weights a mesh is shown with at a node: the node's own, else the mesh's, else none. Targets without a weight are
/// not applied.
///
/// # Errors
///
/// A weight that is not finite.
pub(crate) fn weights(node: &Node, mesh: &json::Mesh, place: &str) -> Result<Vec<f64>, Flaw> {
    let weights = node.weights.as_ref().or(mesh.weights.as_ref()).map_or(&[][..], Vec::as_slice);
    if let Some(bad) = weights.iter().find(|w| !w.is_finite()) {
        return Err(Flaw::malformed(format!("{place}.weights"), format!("holds {bad}, which is not finite")));
    }
    Ok(weights.iter().copied().map(f64::from).collect())
}

/// Adds to the first three numbers of each row the displacements of one attribute, which `choose` picks from a target.
///
/// # Errors
///
/// An accessor that cannot be read or has another number of entries than the attribute, and sums beyond what can be
/// computed with.
pub(crate) fn displace(
    document: &Document,
    targets: &[MorphTarget],
    weights: &[f64],
    choose: impl Fn(&MorphTarget) -> Option<Index<Accessor>>,
    name: &str,
    rows: &mut Rows,
    place: &str,
) -> Result<(), Flaw> {
    for (i, (target, &weight)) in targets.iter().zip(weights).enumerate() {
        let Some(index) = choose(target).filter(|_| weight != 0.0) else { continue };
        let place = format!("{place}.targets[{i}].{name}");
        let deltas = accessor::vectors(document, index, &[3], 0.0, &place)?;
        if deltas.rows.len() != rows.rows.len() {
            let problem = format!("has {} entries for {} vertices", deltas.rows.len(), rows.rows.len());
            return Err(Flaw::malformed(place, problem));
        }
        for (row, delta) in rows.rows.iter_mut().zip(&deltas.rows) {
            for (value, delta) in row.iter_mut().zip(delta).take(3) {
                *value += weight * delta;
            }
        }
        accessor::usable(&rows.rows, 3, &place)?;
    }
    Ok(())
}
