//! `ergodic inspect`.

use ergodic_assets::{Asset, load_variant};
use ergodic_pathspace::Projection;
use ergodic_render::Settings;
use ergodic_scattering::{AlphaMode, Material, MaterialLayers, PunctualLight};

use crate::error::CliError;
use crate::options::InspectOptions;
use crate::{census, environment};
use crate::{table, terminal};

/// Tells what is in a file.
pub fn run(options: &InspectOptions) -> Result<(), CliError> {
    let mut asset = load_variant(&options.scene, &options.variant)?;
    if let Some(file) = &options.environment {
        let settings = environment::with_file(None, file);
        let (environment, warnings) = environment::load(Some(&settings))?;
        asset.description.environment = environment;
        asset.warnings.extend(warnings);
    }
    terminal::print_lines(lines(&asset));
    Ok(())
}

fn lines(asset: &Asset) -> Vec<String> {
    let (description, summary) = (&asset.description, &asset.summary);
    let mut lines = vec![format!("{}: glTF {}", asset.file, summary.version)];
    let facts = [("written by", &summary.generator), ("copyright", &summary.copyright)];
    lines.extend(facts.iter().filter_map(|(what, fact)| fact.as_ref().map(|fact| format!("  {what} {fact}"))));
    if !summary.extensions_used.is_empty() {
        lines.push(format!("  extensions used: {}", summary.extensions_used.join(", ")));
    }
    if !summary.extensions_required.is_empty() {
        lines.push(format!("  extensions required: {}", summary.extensions_required.join(", ")));
    }
    if !summary.variants.is_empty() {
        let names = summary.variants.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>();
        lines.push(format!("  variants: {}", names.join(", ")));
    }
    let triangles: usize = description.placements.iter().map(|p| description.meshes[p.mesh].triangles.len()).sum();
    lines.push(format!(
        "  {} meshes, placed {} times: {} triangles in all; {} textures",
        description.meshes.len(),
        description.placements.len(),
        triangles,
        description.textures.len(),
    ));
    if let Some((low, high)) = description.bounds() {
        lines.push(format!("  from {low:.4} to {high:.4}"));
    }

    section(&mut lines, "Cameras", &cameras(asset), &["number", "name", "vertical field of view", "lens", "position"]);
    if description.cameras.is_empty() {
        lines.push("no camera: a picture would frame the whole scene from the front".into());
    }
    section(&mut lines, "Lights", &lights(asset), &["kind", "radiance, intensity or irradiance", "where"]);
    if lights(asset).is_empty() {
        lines.push(
            "no light: give a material an emissiveFactor, add a light by KHR_lights_punctual, or render with \
             --environment; without one nothing can be rendered"
                .into(),
        );
    }
    let materials: Vec<Vec<String>> = description.materials.iter().map(material).collect();
    section(&mut lines, "Materials", &materials, &["name", "kind", "base colour", "metallic", "roughness", "more"]);

    lines.push(String::new());
    lines.extend(census::lines(description, &Settings::default().mlt.mutations));
    lines.push(String::new());
    if asset.warnings.is_empty() {
        lines.push("Everything in the file is supported.".into());
    } else {
        lines.push("Not supported, or not as it should be:".into());
        lines.extend(asset.warnings.iter().map(|warning| format!("  {warning}")));
    }
    let notes: Vec<String> = asset.notes.iter().cloned().chain(asset.light_units_hint()).collect();
    if !notes.is_empty() {
        lines.push("To know:".into());
        lines.extend(notes.iter().map(|note| format!("  {note}")));
    }
    lines
}

fn section(lines: &mut Vec<String>, title: &str, rows: &[Vec<String>], head: &[&str]) {
    lines.push(String::new());
    if !rows.is_empty() {
        lines.push(format!("{title}:"));
        lines.extend(table::lines(head, rows).iter().map(|line| format!("  {line}")));
    }
}

fn cameras(asset: &Asset) -> Vec<Vec<String>> {
    let row = |(camera, (number, own_name)): (&ergodic_pathspace::CameraDescription, &(usize, String))| {
        let name = if camera.name == *own_name || own_name.is_empty() {
            camera.name.clone()
        } else {
            format!("{} ({own_name})", camera.name)
        };
        let (view, lens) = match camera.projection {
            Projection::Perspective { vertical_fov, lens } => {
                (format!("{:.2} degrees", vertical_fov.to_degrees()), lens)
            }
            Projection::Orthographic { height, .. } => (format!("{height:.4} high, orthographic"), None),
        };
        let lens = lens.map_or("none".into(), |lens| {
            let shape = if lens.blades == 0 { "disk".into() } else { format!("{} blades", lens.blades) };
            format!("radius {:.4}, {shape}, focus at {:.4}", lens.radius, lens.focus_distance)
        });
        vec![number.to_string(), name, view, lens, format!("{:.4}", camera.transform.translation)]
    };
    asset.description.cameras.iter().zip(&asset.summary.cameras).map(row).collect()
}

fn lights(asset: &Asset) -> Vec<Vec<String>> {
    let description = &asset.description;
    let mut rows = Vec::new();
    for placement in &description.placements {
        let material = &description.materials[placement.material];
        if material.emission.max_element() > 0.0 {
            let triangles = description.meshes[placement.mesh].triangles.len();
            let sides = if material.double_sided { "both sides" } else { "front" };
            rows.push(vec![
                format!("surface, {sides}"),
                format!("{:.4}", material.emission),
                format!("{triangles} triangles of {:?}", material.name),
            ]);
        }
    }
    if let Some(environment) = &description.environment {
        let [size, mean, orientation] = environment::describe(environment);
        rows.push(vec![format!("environment, {size}"), format!("mean {mean}"), orientation]);
    }
    for light in &description.lights {
        rows.push(match light {
            PunctualLight::Point { position, intensity } => {
                vec!["point".into(), format!("{intensity:.4}"), format!("{position:.4}")]
            }
            PunctualLight::Spot { position, intensity, .. } => {
                vec!["spot".into(), format!("{intensity:.4}"), format!("{position:.4}")]
            }
            PunctualLight::Directional { direction, irradiance } => {
                vec!["directional".into(), format!("{irradiance:.4}"), format!("along {direction:.4}")]
            }
        });
    }
    rows
}

/// The effects of a material's layers, each with how much there is of it.
fn effects(layers: &MaterialLayers) -> Vec<String> {
    let mut effects = Vec::new();
    if layers.clearcoat > 0.0 {
        effects.push(format!("clearcoat {:.2}, roughness {:.2}", layers.clearcoat, layers.clearcoat_roughness));
    }
    if layers.sheen_color.max_element() > 0.0 {
        effects.push(format!("sheen {:.2}, roughness {:.2}", layers.sheen_color, layers.sheen_roughness));
    }
    if layers.anisotropy > 0.0 {
        effects.push(format!("anisotropy {:.2}", layers.anisotropy));
    }
    if layers.iridescence > 0.0 {
        let (thin, thick) = (layers.iridescence_thickness_minimum, layers.iridescence_thickness_maximum);
        let thickness = match layers.iridescence_thickness_texture {
            Some(_) => format!("{thin:.0} to {thick:.0} nm"),
            None => format!("{thick:.0} nm"),
        };
        effects.push(format!("iridescence {:.2}, film of {thickness}", layers.iridescence));
    }
    if layers.diffuse_transmission > 0.0 {
        let (share, color) = (layers.diffuse_transmission, layers.diffuse_transmission_color);
        effects.push(format!("diffuse transmission {share:.2} of {color:.2}"));
    }
    effects
}

fn material(material: &Material) -> Vec<String> {
    let kind = if material.unlit {
        "unlit"
    } else if material.is_solid() {
        "solid dielectric"
    } else if material.transmission > 0.0 {
        "thin-walled dielectric"
    } else if material.specular_glossiness.is_some() {
        "specular-glossiness"
    } else if material.metallic >= 1.0 && material.metallic_roughness_texture.is_none() {
        "metal"
    } else if material.specular == 0.0 && material.metallic == 0.0 {
        "diffuse"
    } else {
        "dielectric over diffuse"
    };
    let textures = [
        ("base colour", &material.base_color_texture),
        ("metallic-roughness", &material.metallic_roughness_texture),
        ("normal", &material.normal_texture),
        ("emissive", &material.emission_texture),
        ("specular", &material.specular_texture),
        ("specular colour", &material.specular_color_texture),
        ("transmission", &material.transmission_texture),
    ];
    let gloss = material.specular_glossiness.and_then(|gloss| gloss.texture);
    let layers = material.layers.as_deref().map_or_else(Vec::new, |layers| layers.textures().to_vec());
    let textures = textures.into_iter().chain([("specular-glossiness", &gloss)]).chain(layers);
    let textures: Vec<&str> = textures.filter(|(_, used)| used.is_some()).map(|(name, _)| name).collect();
    let mut more = Vec::new();
    if !textures.is_empty() {
        more.push(format!("textures: {}", textures.join(", ")));
    }
    if let Some(layers) = &material.layers {
        more.extend(effects(layers));
    }
    if material.is_solid() || (material.ior - 1.5).abs() > 1e-6 && material.specular_glossiness.is_none() {
        more.push(format!("index {:.3}", material.ior));
    }
    if material.disperses() {
        more.push(format!("disperses light, Abbe number {:.1}", 20.0 / material.dispersion));
    }
    if material.is_solid() && material.absorption.max_element() > 0.0 {
        more.push(format!("absorbs {:.3}", material.absorption));
    }
    if material.medium().scatters() {
        more.push(format!("scatters {:.3}, mean cosine {:.2}", material.scattering, material.anisotropy));
    }
    match material.alpha_mode {
        AlphaMode::Opaque => {}
        AlphaMode::Mask { cutoff } => more.push(format!("there where alpha is at least {cutoff:.3}")),
        AlphaMode::Blend => more.push(format!("covers by alpha, {:.3}", material.alpha)),
    }
    if material.emission.max_element() > 0.0 {
        more.push("emits".into());
    }
    vec![
        material.name.clone(),
        kind.into(),
        format!("{:.3}", if material.unlit { material.emission } else { material.base_color }),
        format!("{:.2}", material.metallic),
        format!("{:.2}", material.specular_glossiness.map_or(material.roughness, |gloss| 1.0 - gloss.glossiness)),
        more.join("; "),
    ]
}
