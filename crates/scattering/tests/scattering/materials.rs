//! From the material's factors and textures to the scattering at a point.

use ergodic_scattering::{Bsdf, Component, Interpolation, Material, Rgb, Texels, Texture, TextureUse, Wrap};
use glam::{DAffine2, DVec2, DVec3, DVec4};

use crate::support::{inclined, surface};

fn texture(texel: [f32; 4]) -> Texture {
    let interpolation = Interpolation::Bilinear;
    Texture {
        width: 1,
        height: 1,
        texels: Texels::Float([texel].into()),
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        interpolation,
    }
}

fn used(texture: usize) -> Option<TextureUse> {
    Some(TextureUse { texture, texcoord: 0, transform: DAffine2::IDENTITY })
}

#[test]
fn factors_textures_and_vertex_colours_multiply() {
    let textures = [texture([0.5, 0.5, 0.25, 1.0])];
    let plain = Material { base_color: Rgb::splat(0.8), metallic: 0.0, specular: 0.0, ..Material::default() };
    let textured = Material { base_color_texture: used(0), ..plain.clone() };
    let mut at = surface(DVec3::Z);
    at.color = DVec4::new(0.5, 1.0, 1.0, 1.0);
    let (light, eye) = (inclined(0.5, 0.0), inclined(0.7, 2.0));
    let f = textured.interaction(&textures, &at).eval(light, eye, Component::Rough);
    assert!((f * std::f64::consts::PI - Rgb::new(0.2, 0.4, 0.2)).length() < 1e-12);
    // Roughness is in G, metallic in B.
    let metal = Material { metallic: 1.0, roughness: 1.0, metallic_roughness_texture: used(0), ..Material::default() };
    let factors = Material { metallic: 0.25, roughness: 0.5, ..Material::default() };
    let at = surface(DVec3::Z);
    let (a, b) = (metal.interaction(&textures, &at), factors.interaction(&textures, &at));
    assert!((a.eval(light, eye, Component::Rough) - b.eval(light, eye, Component::Rough)).length() < 1e-12);
    // Specular in A, its colour in RGB, transmission in R.
    let layered = Material {
        specular_texture: used(0),
        specular_color_texture: used(0),
        transmission: 1.0,
        transmission_texture: used(0),
        ..plain.clone()
    };
    let layered = Material { specular: 1.0, ..layered };
    let factors = Material { specular: 1.0, specular_color: Rgb::new(0.5, 0.5, 0.25), transmission: 0.5, ..plain };
    let (a, b) = (layered.interaction(&textures, &at), factors.interaction(&textures, &at));
    assert_eq!(a.eval(light, eye, Component::Rough), b.eval(light, eye, Component::Rough));
    assert_eq!(a.eval(light, -eye, Component::Rough), b.eval(light, -eye, Component::Rough));
}

#[test]
fn emission_is_textured() {
    let textures = [texture([0.5, 0.25, 1.0, 1.0])];
    let material = Material { emission: Rgb::splat(4.0), emission_texture: used(0), ..Material::default() };
    assert_eq!(material.emitted(&textures, &surface(DVec3::Z)), Rgb::new(2.0, 1.0, 4.0));
    assert_eq!(Material::default().emitted(&[], &surface(DVec3::Z)), Rgb::ZERO);
}

#[test]
fn without_specular_and_metal_a_surface_is_purely_lambertian() {
    let diffuse = Material { metallic: 0.0, specular: 0.0, roughness: 0.0, ..Material::default() };
    let at = diffuse.interaction(&[], &surface(DVec3::Z));
    assert!(matches!(at.bsdf, Bsdf::Lambert(_)));
    assert!(at.has_rough() && !at.has_dirac(Component::DiracReflection) && !at.has_dirac(Component::DiracTransmission));
    // A texture that takes the specular layer away does the same.
    let textures = [texture([1.0, 1.0, 0.0, 0.0])];
    let textured = Material { specular_texture: used(0), metallic_roughness_texture: used(0), ..Material::default() };
    assert!(matches!(textured.interaction(&textures, &surface(DVec3::Z)).bsdf, Bsdf::Lambert(_)));
    // A solid stays a solid.
    let solid = Material { transmission: 1.0, solid: true, ..diffuse };
    assert!(solid.is_solid() && solid.interaction(&[], &surface(DVec3::Z)).medium_below());
    let opaque = Material { transmission: 0.0, ..solid };
    assert!(!opaque.is_solid() && !opaque.interaction(&[], &surface(DVec3::Z)).medium_below());
}

#[test]
fn normal_maps_lean_the_shading_frame() {
    let textures = [texture([0.8, 0.5, 0.9, 1.0])];
    let material = Material { normal_texture: used(0), ..Material::default() };
    let mut at = surface(DVec3::Z);
    (at.tangent, at.bitangent_sign, at.texcoords) = (DVec3::X, 1.0, [DVec2::ZERO; 2]);
    let interaction = material.interaction(&textures, &at);
    assert!((interaction.frame.n - DVec3::new(0.6, 0.0, 0.8)).length() < 1e-6);
    assert_eq!(interaction.ng, DVec3::Z);
}

#[test]
fn an_index_of_zero_reflects_all_of_the_specular_colour() {
    // KHR_materials_ior keeps 0 for the old specular-glossiness workflow.
    let material = Material {
        metallic: 0.0,
        ior: 0.0,
        transmission: 1.0,
        solid: true,
        roughness: 0.0,
        specular_color: Rgb::new(0.9, 0.5, 0.1),
        ..Material::default()
    };
    let at = material.interaction(&[], &surface(DVec3::Z));
    assert!(!at.medium_below() && at.dirac_direction(DVec3::Z, Component::DiracTransmission).is_none());
    let reflected = at.eval(DVec3::Z, DVec3::Z, Component::DiracReflection);
    assert!((reflected - material.specular_color).length() < 1e-12);
}
