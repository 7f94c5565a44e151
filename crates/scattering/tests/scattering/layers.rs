//! From a material's layers and textures to the scattering at a point.

use std::f64::consts::{FRAC_PI_2, PI};

use ergodic_scattering::{
    Bsdf, Component, Interaction, Interpolation, Material, MaterialLayers, Rgb, SpecularGlossiness, Texels, Texture,
    TextureUse, Wrap,
};
use glam::{DAffine2, DVec3, DVec4};

use crate::support::{BASE, Kind, Random, inclined, surface};

fn texture(texel: [f32; 4]) -> Texture {
    let (wrap, interpolation) = (Wrap::Repeat, Interpolation::Bilinear);
    let texels = Texels::Float([texel].into());
    Texture { width: 1, height: 1, texels, wrap_u: wrap, wrap_v: wrap, interpolation }
}

fn used(texture: usize) -> Option<TextureUse> {
    Some(TextureUse { texture, texcoord: 0, transform: DAffine2::IDENTITY })
}

fn base() -> Material {
    Material { base_color: BASE, metallic: 0.3, roughness: 0.5, ..Material::default() }
}

fn with(layers: MaterialLayers) -> Material {
    Material { layers: Some(Box::new(layers)), ..base() }
}

/// Whether two interactions scatter alike, to the precision of 16 bits.
fn assert_alike(a: &Interaction, b: &Interaction, what: &str) {
    let mut random = Random::new(11);
    for _ in 0..500 {
        let (light, eye) = (random.direction(), random.direction());
        let (fa, fb) = (a.eval(light, eye, Component::Rough), b.eval(light, eye, Component::Rough));
        assert!((fa - fb).abs().max_element() <= 1e-3 * fb.abs().max_element() + 1e-6, "{what}: {fa} {fb}");
        let (pa, pb) = (a.pdf(light, eye, Component::Rough), b.pdf(light, eye, Component::Rough));
        assert!((pa - pb).abs() <= 1e-3 * pb + 1e-6, "{what}: {pa} {pb}");
    }
}

#[test]
fn layers_without_effect_leave_the_base() {
    // So weak that it is stored as nothing, but it is another kind of surface.
    let weak = MaterialLayers { clearcoat: 1e-6, ..MaterialLayers::default() };
    for kind in [Kind::Coated, Kind::HalfMetal, Kind::Glass, Kind::MixedSolid, Kind::MixedThin, Kind::Bubble] {
        for alpha in [0.5, 0.05, 0.0] {
            let plain = kind.material(alpha);
            let layered = Material { layers: Some(Box::new(weak.clone())), ..plain.clone() };
            let at = |material: &Material| material.interaction(&[], &surface(DVec3::Z));
            let (a, b) = (at(&layered), at(&plain));
            assert!(matches!(a.bsdf, Bsdf::Extended(_)) && matches!(b.bsdf, Bsdf::Layered(_)));
            assert_eq!((a.medium_below(), a.has_rough()), (b.medium_below(), b.has_rough()));
            assert!((a.index_below() - b.index_below()).abs() < 1e-6);
            assert_alike(&a, &b, &format!("{kind:?} {alpha}"));
            let from = inclined(0.6, 0.4);
            for component in [Component::DiracReflection, Component::DiracTransmission] {
                assert_eq!(a.has_dirac(component), b.has_dirac(component));
                let (to_a, to_b) = (a.dirac_direction(from, component), b.dirac_direction(from, component));
                assert_eq!(to_a.is_some(), to_b.is_some());
                let (Some(to), Some(to_b)) = (to_a, to_b) else { continue };
                assert!((to - to_b).length() < 1e-6);
                assert!((a.eval(from, to, component) - b.eval(from, to_b, component)).abs().max_element() < 1e-4);
                assert!((a.pdf(from, to, component) - b.pdf(from, to_b, component)).abs() < 1e-4);
            }
        }
    }
}

#[test]
fn every_texture_multiplies_its_factor_from_its_channel() {
    let textures = [texture([0.5, 0.25, 0.75, 0.125])];
    let none = MaterialLayers::default;
    let coat = MaterialLayers { clearcoat: 0.8, clearcoat_roughness: 0.8, ..none() };
    let sheen = MaterialLayers { sheen_color: Rgb::splat(0.8), sheen_roughness: 0.8, ..none() };
    let film = MaterialLayers { iridescence: 0.8, ..none() };
    let leaf = MaterialLayers { diffuse_transmission: 0.8, ..none() };
    let cases = [
        (
            "R",
            MaterialLayers { clearcoat_texture: used(0), ..coat.clone() },
            MaterialLayers { clearcoat: 0.4, ..coat.clone() },
        ),
        (
            "G",
            MaterialLayers { clearcoat_roughness_texture: used(0), ..coat.clone() },
            MaterialLayers { clearcoat_roughness: 0.2, ..coat },
        ),
        (
            "RGB",
            MaterialLayers { sheen_color_texture: used(0), ..sheen.clone() },
            MaterialLayers { sheen_color: Rgb::new(0.4, 0.2, 0.6), ..sheen.clone() },
        ),
        (
            "A",
            MaterialLayers { sheen_roughness_texture: used(0), ..sheen.clone() },
            MaterialLayers { sheen_roughness: 0.1, ..sheen },
        ),
        (
            "R",
            MaterialLayers { iridescence_texture: used(0), ..film.clone() },
            MaterialLayers { iridescence: 0.4, ..film.clone() },
        ),
        (
            "G",
            MaterialLayers { iridescence_thickness_texture: used(0), ..film.clone() },
            MaterialLayers { iridescence_thickness_maximum: 175.0, ..film },
        ),
        (
            "A",
            MaterialLayers { diffuse_transmission_texture: used(0), ..leaf.clone() },
            MaterialLayers { diffuse_transmission: 0.1, ..leaf.clone() },
        ),
        (
            "RGB",
            MaterialLayers { diffuse_transmission_color_texture: used(0), ..leaf.clone() },
            MaterialLayers { diffuse_transmission_color: Rgb::new(0.5, 0.25, 0.75), ..leaf },
        ),
    ];
    for (channel, textured, factors) in cases {
        let at = |layers: &MaterialLayers| with(layers.clone()).interaction(&textures, &surface(DVec3::Z));
        assert_alike(&at(&textured), &at(&factors), &format!("{channel}: {textured:?}"));
    }
    // A texture that takes the effect away leaves the plain surface.
    let textures = [texture([0.0, 1.0, 1.0, 1.0])];
    let bare = with(MaterialLayers { clearcoat: 1.0, clearcoat_texture: used(0), ..none() });
    assert!(matches!(bare.interaction(&textures, &surface(DVec3::Z)).bsdf, Bsdf::Layered(_)));
}

#[test]
fn constant_layers_are_known_without_a_point() {
    let constant = with(MaterialLayers { clearcoat: 1.0, ..MaterialLayers::default() });
    let bsdf = constant.constant_bsdf().unwrap();
    assert_eq!(bsdf, constant.interaction(&[], &surface(DVec3::Z)).bsdf);
    let textured = with(MaterialLayers { clearcoat: 1.0, clearcoat_texture: used(0), ..MaterialLayers::default() });
    assert!(textured.constant_bsdf().is_none());
    // The frame depends on the point.
    assert!(with(MaterialLayers { anisotropy: 0.5, ..MaterialLayers::default() }).constant_bsdf().is_none());
}

#[test]
fn anisotropy_follows_tangent_rotation_and_texture() {
    let along = |rotation: f64, texel: Option<[f32; 4]>, sign: f64| {
        let textures: Vec<Texture> = texel.map(texture).into_iter().collect();
        let anisotropy_texture = texel.and_then(|_| used(0));
        let layers = MaterialLayers {
            anisotropy: 1.0,
            anisotropy_rotation: rotation,
            anisotropy_texture,
            ..MaterialLayers::default()
        };
        let mut point = surface(DVec3::Z);
        point.bitangent_sign = sign;
        with(layers).interaction(&textures, &point).frame.t
    };
    let near = |a: DVec3, b: DVec3| (a - b).length() < 1e-6 || (a + b).length() < 1e-6;
    assert!(near(along(0.0, None, 1.0), DVec3::X));
    // Counter-clockwise towards the bitangent, wherever that is.
    assert!(near(along(0.5, None, 1.0), inclined(0.0, 0.5)));
    assert!(near(along(0.5, None, -1.0), inclined(0.0, -0.5)));
    // The texture's (0, 1) is the bitangent, and the rotation comes on top.
    assert!(near(along(0.0, Some([0.5, 1.0, 1.0, 1.0]), 1.0), DVec3::Y));
    assert!(near(along(FRAC_PI_2, Some([0.5, 1.0, 1.0, 1.0]), 1.0), DVec3::X));
    // Rougher along the tangent: a highlight is longer there.
    let at = with(MaterialLayers { anisotropy: 0.8, ..MaterialLayers::default() }).interaction(&[], &surface(DVec3::Z));
    let f = |phi: f64| at.eval(DVec3::Z, inclined(0.8, phi), Component::Rough).x;
    assert!(f(0.0) > 1.2 * f(FRAC_PI_2), "{} {}", f(0.0), f(FRAC_PI_2));
    // Without a tangent there is no direction.
    let mut point = surface(DVec3::Z);
    (point.tangent, point.bitangent_sign) = (DVec3::ZERO, 0.0);
    let flat = with(MaterialLayers { anisotropy: 0.8, ..MaterialLayers::default() });
    assert!(matches!(flat.interaction(&[], &point).bsdf, Bsdf::Layered(_)));
}

#[test]
fn a_coat_darkens_the_emission_below_it() {
    let coat = MaterialLayers { clearcoat: 0.5, ..MaterialLayers::default() };
    let at = with(coat).interaction(&[], &surface(DVec3::Z));
    for cos in [1.0_f64, 0.5, -0.2] {
        let fresnel = 0.04 + 0.96 * (1.0 - cos.abs()).powi(5);
        assert!((at.emission_factor(inclined(cos, 0.3)) - (1.0 - 0.5 * fresnel)).abs() < 1e-5);
    }
    assert_eq!(base().interaction(&[], &surface(DVec3::Z)).emission_factor(DVec3::Z), 1.0);
}

#[test]
fn specular_glossiness_is_the_archived_extensions() {
    let textures = [texture([0.5, 0.25, 1.0, 0.5])];
    let gloss = SpecularGlossiness { glossiness: 0.8, texture: used(0) };
    let material = Material {
        base_color: Rgb::new(0.8, 0.6, 0.4),
        metallic: 0.0,
        ior: 0.0,
        specular_color: Rgb::new(0.4, 0.8, 0.1),
        specular_glossiness: Some(gloss),
        ..Material::default()
    };
    let at = material.interaction(&textures, &surface(DVec3::Z));
    // specular (0.2, 0.2, 0.1), so diffuse times 0.8; roughness 1 - 0.8 * 0.5.
    let (light, eye) = (inclined(0.7, 0.3), inclined(0.5, 2.0));
    let h = (light + eye).normalize();
    let f0 = Rgb::new(0.2, 0.2, 0.1);
    let fresnel = f0 + (Rgb::ONE - f0) * (1.0 - light.dot(h)).powi(5);
    let alpha2 = 0.6_f64.powi(4);
    let d = alpha2 / (PI * (h.z * h.z * (alpha2 - 1.0) + 1.0).powi(2));
    let root = |w: DVec3| (alpha2 + (1.0 - alpha2) * w.z * w.z).sqrt();
    let v = 0.5 / (light.z * root(eye) + eye.z * root(light));
    let diffuse = material.base_color * 0.8 * ((1.0 - fresnel.max_element()) / PI);
    let expected = diffuse + fresnel * (d * v);
    let found = at.eval(light, eye, Component::Rough);
    assert!((found - expected).abs().max_element() < 1e-6, "{found} {expected}");
}

#[test]
fn an_unlit_surface_emits_with_the_colour_of_the_mesh() {
    let material = Material { unlit: true, emission: Rgb::new(0.5, 1.0, 0.25), ..Material::default() };
    let mut point = surface(DVec3::Z);
    point.color = DVec4::new(0.5, 1.0, 0.0, 1.0);
    assert_eq!(material.emitted(&[], &point), Rgb::new(0.25, 1.0, 0.0));
}
