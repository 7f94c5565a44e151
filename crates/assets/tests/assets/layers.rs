//! The material extensions beyond the layered surface, and variants.

use ergodic_assets::from_bytes_variant;
use ergodic_scattering::{Material, MaterialLayers, Rgb, TextureUse};
use glam::DVec2;
use serde_json::{Value, json};

use crate::support::{load, try_load};
use crate::textured::{textured, with_material};

fn material(extensions: &Value) -> Material {
    load(&with_material(json!({"extensions": extensions}))).description.materials[0].clone()
}

fn layers(name: &str, values: &Value) -> MaterialLayers {
    *material(&json!({name: values})).layers.expect("layers")
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-6
}

#[test]
fn every_factor_arrives() {
    let coat = layers("KHR_materials_clearcoat", &json!({"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.25}));
    assert_eq!((coat.clearcoat, coat.clearcoat_roughness, coat.clearcoat_normal_scale), (0.5, 0.25, 1.0));
    let sheen =
        layers("KHR_materials_sheen", &json!({"sheenColorFactor": [1, 0.5, 0.25], "sheenRoughnessFactor": 0.75}));
    assert_eq!((sheen.sheen_color, sheen.sheen_roughness), (Rgb::new(1.0, 0.5, 0.25), 0.75));
    let brushed = layers("KHR_materials_anisotropy", &json!({"anisotropyStrength": 0.5, "anisotropyRotation": -1.5}));
    assert_eq!((brushed.anisotropy, brushed.anisotropy_rotation), (0.5, -1.5));
    let film = layers(
        "KHR_materials_iridescence",
        &json!({"iridescenceFactor": 0.5, "iridescenceIor": 1.75, "iridescenceThicknessMinimum": 300,
                "iridescenceThicknessMaximum": 200}),
    );
    assert_eq!((film.iridescence, film.iridescence_ior), (0.5, 1.75));
    assert_eq!((film.iridescence_thickness_minimum, film.iridescence_thickness_maximum), (300.0, 200.0));
    let leaf = layers(
        "KHR_materials_diffuse_transmission",
        &json!({"diffuseTransmissionFactor": 0.5, "diffuseTransmissionColorFactor": [0.5, 1, 0]}),
    );
    assert_eq!((leaf.diffuse_transmission, leaf.diffuse_transmission_color), (0.5, Rgb::new(0.5, 1.0, 0.0)));
}

#[test]
fn defaults_are_the_specifications() {
    let film = layers("KHR_materials_iridescence", &json!({"iridescenceFactor": 1}));
    assert!(near(film.iridescence_ior, 1.3));
    assert_eq!((film.iridescence_thickness_minimum, film.iridescence_thickness_maximum), (100.0, 400.0));
    let leaf = layers("KHR_materials_diffuse_transmission", &json!({"diffuseTransmissionFactor": 1}));
    assert_eq!(leaf.diffuse_transmission_color, Rgb::ONE);
    // Present but with all factors at their defaults: nothing at all.
    for name in ["clearcoat", "sheen", "anisotropy", "iridescence", "diffuse_transmission"] {
        assert!(material(&json!({format!("KHR_materials_{name}"): {}})).layers.is_none(), "{name}");
    }
}

/// The material with a texture in one place of an extension, with a transform to know it by.
fn with_texture(name: &str, member: &str, values: &Value) -> (Material, Vec<ergodic_scattering::Texture>) {
    let mut values = values.clone();
    values[member] = json!({"index": 0, "extensions": {"KHR_texture_transform": {"offset": [0.25, 0.5]}}});
    let file = textured(json!({"extensions": {name: values}}), json!({}), false);
    let description = load(&file).description;
    (description.materials[0].clone(), description.textures)
}

/// Whether a texture arrived with its transform, and is decoded as colour or not.
fn check(used: Option<TextureUse>, textures: &[ergodic_scattering::Texture], color: bool, what: &str) {
    let used = used.unwrap_or_else(|| panic!("{what}"));
    assert_eq!(used.transform.transform_point2(DVec2::ZERO), DVec2::new(0.25, 0.5), "{what}");
    let red = textures[used.texture].lookup(DVec2::new(0.25, 0.5)).x;
    assert!((red - if color { 0.5 } else { 188.0 / 255.0 }).abs() < 0.003, "{what}: {red}");
}

#[test]
fn every_texture_arrives_with_its_transform_and_encoding() {
    /// A member, whether it is a colour, and where it arrives.
    type Member = (&'static str, bool, fn(&MaterialLayers) -> Option<TextureUse>);
    let cases: [(&str, Value, &[Member]); 5] = [
        (
            "KHR_materials_clearcoat",
            json!({"clearcoatFactor": 1}),
            &[
                ("clearcoatTexture", false, |l| l.clearcoat_texture),
                ("clearcoatRoughnessTexture", false, |l| l.clearcoat_roughness_texture),
                ("clearcoatNormalTexture", false, |l| l.clearcoat_normal_texture),
            ],
        ),
        (
            "KHR_materials_sheen",
            json!({"sheenColorFactor": [1, 1, 1]}),
            &[
                ("sheenColorTexture", true, |l| l.sheen_color_texture),
                ("sheenRoughnessTexture", false, |l| l.sheen_roughness_texture),
            ],
        ),
        (
            "KHR_materials_anisotropy",
            json!({"anisotropyStrength": 1}),
            &[("anisotropyTexture", false, |l| l.anisotropy_texture)],
        ),
        (
            "KHR_materials_iridescence",
            json!({"iridescenceFactor": 1}),
            &[
                ("iridescenceTexture", false, |l| l.iridescence_texture),
                ("iridescenceThicknessTexture", false, |l| l.iridescence_thickness_texture),
            ],
        ),
        (
            "KHR_materials_diffuse_transmission",
            json!({"diffuseTransmissionFactor": 1}),
            &[
                ("diffuseTransmissionTexture", false, |l| l.diffuse_transmission_texture),
                ("diffuseTransmissionColorTexture", true, |l| l.diffuse_transmission_color_texture),
            ],
        ),
    ];
    for (name, values, textures) in cases {
        for (member, color, get) in textures {
            let (material, all) = with_texture(name, member, &values);
            check(get(&material.layers.expect("layers")), &all, *color, member);
        }
    }
    // The scale of the coat's normal map.
    let normal = json!({"clearcoatFactor": 1, "clearcoatNormalTexture": {"index": 0, "scale": 0.5}});
    let file = textured(json!({"extensions": {"KHR_materials_clearcoat": normal}}), json!({}), false);
    let asset = load(&file);
    assert_eq!(asset.description.materials[0].layers.as_ref().unwrap().clearcoat_normal_scale, 0.5);
    // And its mesh gets tangents.
    assert!(asset.description.meshes[0].tangents.is_some());
}

#[test]
fn the_older_extensions_textures_arrive_too() {
    /// An extension, its member, whether that is a colour, and where it arrives.
    type Case = (&'static str, &'static str, bool, fn(&Material) -> Option<TextureUse>);
    let cases: [Case; 5] = [
        ("KHR_materials_specular", "specularTexture", false, |m| m.specular_texture),
        ("KHR_materials_specular", "specularColorTexture", true, |m| m.specular_color_texture),
        ("KHR_materials_transmission", "transmissionTexture", false, |m| m.transmission_texture),
        ("KHR_materials_pbrSpecularGlossiness", "diffuseTexture", true, |m| m.base_color_texture),
        ("KHR_materials_pbrSpecularGlossiness", "specularGlossinessTexture", true, |m| {
            m.specular_glossiness.and_then(|gloss| gloss.texture)
        }),
    ];
    for (name, member, color, get) in cases {
        let (material, all) = with_texture(name, member, &json!({}));
        check(get(&material), &all, color, member);
    }
}

#[test]
fn values_out_of_range_are_clamped_or_refused() {
    let place = |name: &str, values: Value| {
        let loaded = try_load(&with_material(json!({"extensions": {name: values}})));
        loaded.map_err(|error| error.place)
    };
    let clamped = place("KHR_materials_clearcoat", json!({"clearcoatFactor": 1.5})).unwrap();
    assert_eq!(clamped.description.materials[0].layers.as_ref().unwrap().clearcoat, 1.0);
    assert!(clamped.warnings[0].contains("materials[0].extensions.KHR_materials_clearcoat.clearcoatFactor is 1.5"));
    let film = json!({"iridescenceFactor": 1, "iridescenceIor": 0.5});
    let below = place("KHR_materials_iridescence", film).unwrap();
    assert_eq!(
        (below.description.materials[0].layers.as_ref().unwrap().iridescence_ior, below.warnings.len()),
        (1.0, 1)
    );
    let refused = [
        ("KHR_materials_iridescence", json!({"iridescenceThicknessMaximum": -1}), "iridescenceThicknessMaximum"),
        ("KHR_materials_sheen", json!({"sheenColorFactor": [1, 1]}), "sheenColorFactor"),
        ("KHR_materials_anisotropy", json!({"anisotropyRotation": "left"}), "anisotropyRotation"),
        ("KHR_materials_clearcoat", json!({"clearcoatTexture": {"index": 7}}), "clearcoatTexture"),
    ];
    for (name, values, member) in refused {
        let at = place(name, values).unwrap_err();
        assert_eq!(at, format!("materials[0].extensions.{name}.{member}"));
    }
}

#[test]
fn anisotropy_without_directions_is_warned_of() {
    let asset = load(&with_material(json!({"extensions": {"KHR_materials_anisotropy": {"anisotropyStrength": 1}}})));
    assert_eq!(asset.warnings.len(), 1);
    assert!(asset.warnings[0].contains("meshes[0].primitives[0]"), "{:?}", asset.warnings);
}

#[test]
fn specular_glossiness_takes_the_place_of_metal_and_roughness() {
    let old = json!({"diffuseFactor": [0.5, 0.25, 1, 1], "specularFactor": [0.25, 0.5, 0], "glossinessFactor": 0.75});
    let file = with_material(json!({
        "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1], "roughnessFactor": 0.1},
        "extensions": {"KHR_materials_pbrSpecularGlossiness": old},
    }));
    let material = load(&file).description.materials[0].clone();
    assert_eq!((material.base_color, material.metallic, material.ior), (Rgb::new(0.5, 0.25, 1.0), 0.0, 0.0));
    assert_eq!(material.specular_color, Rgb::new(0.25, 0.5, 0.0));
    assert_eq!(material.specular_glossiness.unwrap().glossiness, 0.75);
    assert!(load(&file).warnings.is_empty());
}

#[test]
fn an_unlit_material_emits_its_base_colour_and_scatters_nothing() {
    let file = with_material(json!({
        "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 1, 1], "roughnessFactor": 0.1},
        "emissiveFactor": [1, 1, 1],
        "extensions": {"KHR_materials_unlit": {}},
    }));
    let material = load(&file).description.materials[0].clone();
    assert!(material.unlit);
    assert_eq!((material.emission, material.base_color), (Rgb::new(0.5, 0.25, 1.0), Rgb::ZERO));
    assert_eq!(material.constant_bsdf(), Some(ergodic_scattering::Bsdf::BLACK));
}

fn with_variants() -> Value {
    let mut file = with_material(json!({"name": "plain"}));
    file["materials"] = json!([{"name": "plain"}, {"name": "red"}, {"name": "blue"}]);
    file["extensionsUsed"] = json!(["KHR_materials_variants"]);
    file["extensions"] =
        json!({"KHR_materials_variants": {"variants": [{"name": "warm"}, {"name": "cold"}, {"name": "as it is"}]}});
    file["meshes"][0]["primitives"][0]["extensions"] = json!({"KHR_materials_variants": {"mappings": [
        {"material": 1, "variants": [0]}, {"material": 2, "variants": [1]},
    ]}});
    file
}

#[test]
fn variants_are_chosen_by_name() {
    let file = with_variants();
    let name = |variant: &str| {
        let asset = from_bytes_variant(file.to_string().as_bytes(), "test.gltf", variant).unwrap();
        assert!(asset.warnings.is_empty(), "{:?}", asset.warnings);
        assert_eq!(asset.summary.variants, ["warm", "cold", "as it is"]);
        let used = asset.description.placements[0].material;
        asset.description.materials[used].name.clone()
    };
    assert_eq!(
        (name(""), name("warm"), name("cold"), name("as it is")),
        ("plain".into(), "red".into(), "blue".into(), "plain".into())
    );
}

#[test]
fn an_unknown_variant_is_an_error_that_lists_them() {
    let choose = |file: &Value| from_bytes_variant(file.to_string().as_bytes(), "test.gltf", "hot").unwrap_err();
    let error = choose(&with_variants());
    assert!(error.mend.contains("\"warm\", \"cold\", \"as it is\"") && error.problem.contains("\"hot\""), "{error}");
    assert!(choose(&with_material(json!({}))).to_string().contains("has no variants"));
    let mut broken = with_variants();
    broken["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"][0]["material"] = 9.into();
    let error = from_bytes_variant(broken.to_string().as_bytes(), "test.gltf", "warm").unwrap_err();
    assert!(error.place.contains("meshes[0].primitives[0]"), "{error}");
}

#[test]
fn dispersion_arrives_and_is_warned_of_where_it_has_no_effect() {
    let glass = |changes: &Value| {
        let mut extensions = json!({
            "KHR_materials_transmission": {"transmissionFactor": 1},
            "KHR_materials_volume": {"thicknessFactor": 1},
            "KHR_materials_dispersion": {"dispersion": 0.5},
        });
        for (name, value) in changes.as_object().expect("an object") {
            extensions[name] = value.clone();
        }
        let asset =
            load(&with_material(json!({"extensions": extensions, "pbrMetallicRoughness": {"metallicFactor": 0}})));
        let warned = asset.warnings.iter().any(|warning| warning.contains("KHR_materials_dispersion"));
        (asset.description.materials[0].clone(), warned)
    };
    let (material, warned) = glass(&json!({}));
    assert!(material.dispersion == 0.5 && material.disperses() && !warned);
    let without_effect = [
        json!({"KHR_materials_transmission": {"transmissionFactor": 0}}),
        json!({"KHR_materials_volume": {"thicknessFactor": 0}}),
        json!({"KHR_materials_ior": {"ior": 1}}),
        json!({"KHR_materials_unlit": {}}),
        json!({"KHR_materials_pbrSpecularGlossiness": {}}),
    ];
    for changes in without_effect {
        let (material, warned) = glass(&changes);
        assert!(!material.disperses() && warned, "{changes}");
    }
    // Switched off, there is nothing to warn of.
    let (material, warned) = glass(&json!({"KHR_materials_dispersion": {}}));
    assert!(!material.disperses() && !warned);
    let negative = json!({"extensions": {"KHR_materials_dispersion": {"dispersion": -1}}});
    let error = try_load(&with_material(negative)).expect_err("a negative dispersion").to_string();
    assert!(error.contains("KHR_materials_dispersion.dispersion") && error.contains("negative"), "{error}");
}
