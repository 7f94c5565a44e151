//! A room of things whose materials have layers and effects beyond glTF's core.

use ergodic_geometry::Mesh;
use ergodic_pathspace::SceneDescription;
use ergodic_scattering::{Material, MaterialLayers, Rgb};
use glam::DVec3;

use crate::{Eye, cuboid, description_of, diffuse, quad, sphere};

/// A mesh with the normals of a sphere about `centre`.
fn smooth(mesh: Mesh, centre: DVec3) -> Mesh {
    let normals = mesh.positions.iter().map(|p| (p - centre).normalize()).collect();
    Mesh { normals: Some(normals), ..mesh }
}

fn with(material: Material, layers: MaterialLayers) -> Material {
    Material { layers: Some(Box::new(layers)), ..material }
}

/// A closed room with a lamp and one thing of each effect: a rough coat, a smooth coat, a sheen, brushed metal, a thin film
/// on glass, a leaf, and a lump of absorbing wax.
pub fn layered_room() -> SceneDescription {
    let ball = |x: f64, y: f64, z: f64, radius: f64| {
        let centre = DVec3::new(x, y, z);
        smooth(sphere(centre, radius, 16, false), centre)
    };
    let dielectric = Material { metallic: 0.0, roughness: 0.4, base_color: Rgb::splat(0.7), ..Material::default() };
    let metal = Material { metallic: 1.0, roughness: 0.5, base_color: Rgb::new(0.9, 0.6, 0.3), ..Material::default() };
    let none = MaterialLayers::default;
    let varnish = MaterialLayers { clearcoat: 1.0, clearcoat_roughness: 0.3, ..none() };
    let velvet = MaterialLayers { sheen_color: Rgb::new(0.9, 0.5, 0.7), sheen_roughness: 0.4, ..none() };
    let brushed = MaterialLayers { anisotropy: 0.8, anisotropy_rotation: 0.6, ..none() };
    let film = MaterialLayers { iridescence: 1.0, iridescence_thickness_maximum: 420.0, ..none() };
    let leaf =
        MaterialLayers { diffuse_transmission: 0.6, diffuse_transmission_color: Rgb::new(0.5, 0.9, 0.2), ..none() };
    let wax = MaterialLayers { diffuse_transmission: 0.8, ..none() };
    let lacquer = MaterialLayers { clearcoat: 1.0, ..none() };
    let mut back = quad(DVec3::new(-1.0, 0.99, -1.0), DVec3::X * 2.0, DVec3::Z * 2.0);
    back.normals = Some(vec![DVec3::NEG_Y; 4]);
    back.tangents = Some(vec![DVec3::X.extend(1.0); 4]);
    let glass = Material { transmission: 1.0, solid: true, roughness: 0.3, base_color: Rgb::ONE, ..dielectric.clone() };
    let absorbing = Material { solid: true, absorption: Rgb::new(0.5, 1.0, 3.0), ..dielectric.clone() };
    let things = vec![
        (cuboid(DVec3::ONE, true), diffuse(0.6, 0.0)),
        (quad(DVec3::new(-0.4, -0.4, 0.98), DVec3::Y * 0.8, DVec3::X * 0.8), diffuse(0.0, 6.0)),
        (ball(-0.6, 0.3, -0.65, 0.3), with(metal.clone(), varnish)),
        (ball(0.1, 0.6, -0.7, 0.25), with(diffuse(0.5, 0.0), velvet)),
        (back, with(metal, brushed)),
        (ball(0.6, 0.2, -0.6, 0.3), with(glass, film)),
        (
            quad(DVec3::new(-0.5, -0.1, 0.1), DVec3::new(0.5, 0.3, 0.1), DVec3::new(0.0, 0.2, 0.5)),
            with(dielectric.clone(), leaf),
        ),
        (ball(0.0, -0.2, -0.75, 0.2), with(absorbing, wax)),
        (quad(DVec3::new(-1.0, -1.0, -0.98), DVec3::X * 2.0, DVec3::Y * 2.0), with(dielectric, lacquer)),
    ];
    let eye = Eye { from: DVec3::new(0.0, -0.95, 0.0), at: DVec3::new(0.0, 0.3, -0.3), up: DVec3::Z, fov: 1.2 };
    description_of(things, Vec::new(), &eye)
}
