//! KHR_materials_volume_scatter, a draft: the attenuation of KHR_materials_volume is scattering and absorption together.

use std::collections::HashMap;

use ergodic_geometry::Mesh;
use ergodic_pathspace::SceneDescription;
use ergodic_scattering::{Material, Rgb};
use serde::Deserialize;
use serde_json::{Map, Value};

use crate::error::Flaw;
use crate::material::Reader;
use crate::material_layers::extension;
use crate::warnings::Warnings;

pub(crate) const NAME: &str = "KHR_materials_volume_scatter";

/// Nearer to 1 or -1 the phase function is a needle that no sampler of lights ever meets.
const MOST_ANISOTROPY: f64 = 0.999;

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct VolumeScatter {
    /// The draft's name changed; files with either are about.
    #[serde(alias = "multiscatterColorFactor")]
    multiscatter_color: [f32; 3],
    scatter_anisotropy: f32,
}

/// The share of attenuation that is scattering, for the colour that a deep medium shows after many turns (Kulla and Conty 2017, as
/// the draft has it).
fn single_scatter_albedo(multiple: f64) -> f64 {
    let root = (9.59217 + 41.6808 * multiple + 17.7126 * multiple * multiple).sqrt();
    let s = 4.09712 + 4.20863 * multiple - root;
    (1.0 - s * s).clamp(0.0, 1.0)
}

/// Splits the attenuation of a material whose volume has been read.
pub(crate) fn read(
    extensions: &Map<String, Value>,
    material: &mut Material,
    reader: &mut Reader<'_>,
) -> Result<(), Flaw> {
    let place = reader.place.clone();
    let Some(scatter) = extension::<VolumeScatter>(extensions, NAME, &place)? else { return Ok(()) };
    let at = |name: &str| format!("extensions.{NAME}.{name}");
    let color = reader.shares(scatter.multiscatter_color, &at("multiscatterColor"))?;
    let anisotropy = reader.number(scatter.scatter_anisotropy, &at("scatterAnisotropy"))?;
    if anisotropy.abs() > MOST_ANISOTROPY {
        let place = format!("{place}.{} is {anisotropy}", at("scatterAnisotropy"));
        reader.warnings.note("An anisotropy outside [-0.999, 0.999]", place, "is clamped");
    }
    if color == Rgb::ZERO {
        return Ok(());
    }
    if !material.solid {
        reader.warnings.note(NAME, &place, "has no effect without a KHR_materials_volume.thicknessFactor above 0");
        return Ok(());
    }
    let attenuation = material.absorption;
    if attenuation == Rgb::ZERO {
        reader.warnings.note(
            NAME,
            &place,
            "has no effect without a KHR_materials_volume.attenuationDistance and a colour below 1",
        );
    }
    let albedo = Rgb::from_array(color.to_array().map(single_scatter_albedo));
    material.scattering = attenuation * albedo;
    material.absorption = attenuation * (1.0 - albedo);
    material.anisotropy = anisotropy.clamp(-MOST_ANISOTROPY, MOST_ANISOTROPY);
    Ok(())
}

/// Whether some edge of a mesh has a triangle on one of its sides only. Vertices at one place are one.
fn is_open(mesh: &Mesh) -> bool {
    let place = |index: u32| mesh.positions[index as usize].to_array().map(|x| (x + 0.0).to_bits());
    let mut balance: HashMap<_, i64> = HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)].map(|(from, to)| (place(from), place(to))) {
            if from < to {
                *balance.entry((from, to)).or_default() += 1;
            } else if to < from {
                *balance.entry((to, from)).or_default() -= 1;
            }
        }
    }
    balance.values().any(|balance| *balance != 0)
}

/// Warns of scattering inside meshes that bound nothing.
pub(crate) fn warn_of_open_meshes(description: &SceneDescription, warnings: &mut Warnings) {
    for placement in &description.placements {
        let material = &description.materials[placement.material];
        if material.medium().scatters() && is_open(&description.meshes[placement.mesh]) {
            let place = format!("mesh with material {:?}", material.name);
            warnings.note("A medium that scatters in a mesh with holes", place, "leaks out of them: close the mesh");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_shows_no_colour_scatters_nothing_and_white_absorbs_nothing() {
        assert!(single_scatter_albedo(0.0).abs() < 1e-5 && (single_scatter_albedo(1.0) - 1.0).abs() < 1e-5);
        // Kulla and Conty's mapping is steep near black: half the colour needs far more than half the scattering.
        assert!((single_scatter_albedo(0.5) - 0.9).abs() < 0.05, "{}", single_scatter_albedo(0.5));
    }

    #[test]
    fn a_mesh_with_a_hole_is_open() {
        let corner = |x, y, z| glam::DVec3::new(x, y, z);
        let positions = vec![corner(0., 0., 0.), corner(1., 0., 0.), corner(0., 1., 0.), corner(0., 0., 1.)];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let mut mesh = Mesh { positions, triangles, ..Mesh::default() };
        assert!(!is_open(&mesh));
        // A corner that is there twice is one place.
        mesh.positions.push(corner(-0.0, 0., 1.));
        mesh.triangles[3] = [1, 2, 4];
        assert!(!is_open(&mesh));
        mesh.triangles.pop();
        assert!(is_open(&mesh));
    }
}
