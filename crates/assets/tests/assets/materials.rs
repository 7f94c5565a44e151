//! Materials, their extensions and textures.

use ergodic_scattering::{AlphaMode, Interpolation, Rgb, Wrap};
use glam::{DVec2, DVec4};
use serde_json::json;

use crate::support::{load, try_load};
use crate::textured::{textured, with_material};

#[test]
fn every_factor_arrives() {
    let asset = load(&with_material(json!({
        "name": "all",
        "doubleSided": true,
        "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.25},
        "emissiveFactor": [1, 0.5, 0],
        "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 8},
            "KHR_materials_ior": {"ior": 1.25},
            "KHR_materials_specular": {"specularFactor": 0.75, "specularColorFactor": [1, 2, 0.5]},
            "KHR_materials_transmission": {"transmissionFactor": 1},
            "KHR_materials_volume": {
                "thicknessFactor": 0.5, "attenuationDistance": 2, "attenuationColor": [0.5, 1, 0.25],
            },
        },
    })));
    let m = &asset.description.materials[0];
    assert_eq!(m.name, "all");
    assert!((m.base_color - Rgb::new(0.1, 0.2, 0.3)).length() < 1e-7);
    assert_eq!((m.metallic, m.roughness, m.ior, m.specular, m.transmission), (0.5, 0.25, 1.25, 0.75, 1.0));
    assert_eq!((m.specular_color, m.emission), (Rgb::new(1.0, 2.0, 0.5), Rgb::new(8.0, 4.0, 0.0)));
    assert!(m.double_sided && m.solid);
    // Over the attenuation distance white light takes the attenuation colour.
    let left = (-m.absorption * 2.0).to_array().map(f64::exp);
    assert!((Rgb::from_array(left) - Rgb::new(0.5, 1.0, 0.25)).length() < 1e-12);
}

#[test]
fn a_volume_without_thickness_is_thin_walled() {
    let volume = json!({"attenuationColor": [0.5, 0.5, 0.5]});
    let asset = load(&with_material(json!({"extensions": {"KHR_materials_volume": volume}})));
    assert!(!asset.description.materials[0].solid);
    assert_eq!(asset.description.materials[0].absorption, Rgb::ZERO);
}

#[test]
fn values_out_of_range_are_clamped_or_refused() {
    let pbr = |name: &str, value: f64| with_material(json!({"pbrMetallicRoughness": {name: value}}));
    let clamped = load(&pbr("roughnessFactor", 1.5));
    assert_eq!(clamped.description.materials[0].roughness, 1.0);
    assert!(clamped.warnings[0].contains("materials[0].pbrMetallicRoughness.roughnessFactor is 1.5"));
    let ior = load(&with_material(json!({"extensions": {"KHR_materials_ior": {"ior": 0.5}}})));
    assert_eq!((ior.description.materials[0].ior, ior.warnings.len()), (1.0, 1));
    let negative = try_load(&with_material(json!({"emissiveFactor": [0, -1, 0]}))).unwrap_err();
    assert_eq!(negative.place, "materials[0].emissiveFactor");
    let volume = json!({"extensions": {"KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 0}}});
    assert!(try_load(&with_material(volume)).unwrap_err().place.ends_with("attenuationDistance"));
}

#[test]
fn alpha_is_read_with_its_mode() {
    let read = |mut material: serde_json::Value| {
        material["pbrMetallicRoughness"] = json!({"baseColorFactor": [1, 1, 1, 0.25]});
        let asset = load(&with_material(material));
        (asset.description.materials[0].alpha_mode, asset.description.materials[0].alpha, asset.warnings)
    };
    assert_eq!(read(json!({})), (AlphaMode::Opaque, 0.25, vec![]));
    assert_eq!(read(json!({"alphaMode": "BLEND"})), (AlphaMode::Blend, 0.25, vec![]));
    assert_eq!(read(json!({"alphaMode": "MASK"})).0, AlphaMode::Mask { cutoff: 0.5 });
    assert_eq!(read(json!({"alphaMode": "MASK", "alphaCutoff": 0.75})).0, AlphaMode::Mask { cutoff: 0.75 });
    let error = try_load(&with_material(json!({"alphaMode": "MASK", "alphaCutoff": -1}))).unwrap_err();
    assert_eq!(error.place, "materials[0].alphaCutoff");
    let solid = json!({"alphaMode": "BLEND", "extensions": {
        "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": {"thicknessFactor": 1}}});
    let mut file = with_material(solid);
    file["materials"][0]["pbrMetallicRoughness"] = json!({"metallicFactor": 0});
    assert!(load(&file).warnings[0].starts_with("Alpha of refracting solids"));
}

#[test]
fn unsupported_extensions_are_named_once_and_required_ones_refused() {
    let mut file = with_material(json!({}));
    file["extensionsUsed"] = json!(["ADOBE_materials_thin_transparency", "KHR_materials_ior"]);
    let warnings = load(&file).warnings;
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].starts_with("ADOBE_materials_thin_transparency"));
    file["extensionsRequired"] = json!(["ADOBE_materials_thin_transparency"]);
    let error = try_load(&file).unwrap_err();
    assert_eq!((error.trouble, error.place.as_str()), (ergodic_assets::Trouble::Unsupported, "extensionsRequired"));
}

#[test]
fn colour_is_decoded_from_srgb_and_data_is_not() {
    let pbr = json!({"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 0}});
    let sampler = json!({"magFilter": 9728, "wrapS": 33071, "wrapT": 33648});
    let description = load(&textured(json!({"pbrMetallicRoughness": pbr}), sampler, false)).description;
    let material = &description.materials[0];
    let read = |used: Option<ergodic_scattering::TextureUse>| {
        description.textures[used.unwrap().texture].lookup(DVec2::new(0.25, 0.5))
    };
    let color = read(material.base_color_texture);
    assert!((color.x - 0.5).abs() < 0.003 && color.z == 1.0 && (color.w - 0.2).abs() < 1e-12, "{color}");
    assert_eq!(read(material.metallic_roughness_texture), DVec4::new(188.0, 0.0, 255.0, 51.0) / 255.0);
    let texture = &description.textures[0];
    assert_eq!((texture.width, texture.height, texture.interpolation), (2, 1, Interpolation::Nearest));
    assert_eq!((texture.wrap_u, texture.wrap_v), (Wrap::ClampToEdge, Wrap::MirroredRepeat));
}

#[test]
fn texture_transforms_offset_turn_and_scale() {
    // The example of KHR_texture_transform: a texture in the top right quarter, turned by 90 degrees.
    let transform =
        json!({"offset": [0, 1], "rotation": std::f64::consts::FRAC_PI_2, "scale": [0.5, 0.5], "texCoord": 1});
    let info = json!({"index": 0, "extensions": {"KHR_texture_transform": transform}});
    let file = textured(json!({"pbrMetallicRoughness": {"baseColorTexture": info}}), json!({}), true);
    let used = load(&file).description.materials[0].base_color_texture.unwrap();
    assert_eq!(used.texcoord, 1);
    let to = |u: f64, v: f64| used.transform.transform_point2(DVec2::new(u, v));
    // (1, 0): scaled to (1/2, 0), turned to (0, -1/2), moved to (0, 1/2).
    assert!((to(0.0, 0.0) - DVec2::new(0.0, 1.0)).length() < 1e-7);
    assert!((to(1.0, 0.0) - DVec2::new(0.0, 0.5)).length() < 1e-7, "{}", to(1.0, 0.0));
    assert!((to(0.0, 1.0) - DVec2::new(0.5, 1.0)).length() < 1e-7, "{}", to(0.0, 1.0));

    let normal = json!({"normalTexture": info, "pbrMetallicRoughness": {}});
    let used = load(&textured(normal, json!({}), true)).description.materials[0].normal_texture.unwrap();
    assert!((used.transform.transform_point2(DVec2::X) - DVec2::new(0.0, 0.5)).length() < 1e-7);
}

#[test]
fn a_third_set_of_coordinates_is_left_out_with_a_warning() {
    let pbr = json!({"baseColorTexture": {"index": 0, "texCoord": 2}});
    let asset = load(&textured(json!({"pbrMetallicRoughness": pbr}), json!({}), false));
    assert!(asset.description.materials[0].base_color_texture.is_none());
    assert_eq!(asset.warnings.len(), 1);
}
