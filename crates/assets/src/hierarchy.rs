//! Walks the node hierarchy, in f64: where meshes, cameras and lights stand in the world.

use std::f64::consts::PI;

use ergodic_pathspace::{CameraDescription, Placement};
use ergodic_scattering::{PunctualLight, Rgb};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use gltf::json::accessor::Accessor;
use gltf::json::extensions::scene::khr_lights_punctual::{Light, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, Node};

use crate::camera;
use crate::document::{Document, get};
use crate::error::{Flaw, Trouble};
use crate::library::Library;
use crate::skin::Skin;
use crate::warnings::Warnings;
use crate::{accessor, limits};

/// A camera with the number and names by which it can be asked for.
pub(crate) struct PlacedCamera {
    pub number: usize,
    pub camera_name: String,
    pub description: CameraDescription,
}

/// What stands in the world.
#[derive(Default)]
pub(crate) struct World {
    pub placements: Vec<Placement>,
    pub lights: Vec<PunctualLight>,
    pub cameras: Vec<PlacedCamera>,
}

/// A node of the scene that is shown.
struct Standing {
    index: usize,
    transform: DAffine3,
    /// Whether it and all above it are visible (KHR_node_visibility); cameras see in any case.
    visible: bool,
}

/// Places everything that the file's default scene shows.
pub(crate) fn place(document: &Document, library: &mut Library<'_>, warnings: &mut Warnings) -> Result<World, Flaw> {
    let nodes = &document.root.nodes;
    let standing = walk(document)?;
    let mut worlds = vec![None; nodes.len()];
    for node in &standing {
        worlds[node.index] = Some(node.transform);
    }
    let mut world = World::default();
    for &Standing { index, transform, visible } in &standing {
        let (node, place) = (&nodes[index], format!("nodes[{index}]"));
        if visible {
            place_mesh(document, node, &place, &worlds, transform, library, &mut world, warnings)?;
            place_light(document, node, &place, transform, &mut world, warnings)?;
        } else if node.mesh.is_some() {
            warnings.mention("Invisible nodes", &place, "are not shown");
        }
        place_camera(document, node, &place, transform, &mut world, warnings)?;
    }
    world.cameras.sort_by_key(|camera| camera.number);
    Ok(world)
}

/// The nodes of the default scene, parents first, with their transforms to the world.
fn walk(document: &Document) -> Result<Vec<Standing>, Flaw> {
    let nodes = &document.root.nodes;
    let mut standing = Vec::new();
    let mut reached = vec![false; nodes.len()];
    let mut open: Vec<(usize, String, DAffine3, bool)> = Vec::new();
    for (index, place) in roots(document)?.into_iter().rev() {
        open.push((index, place, DAffine3::IDENTITY, true));
    }
    while let Some((index, place, parent, visible)) = open.pop() {
        let count = nodes.len();
        let node = nodes.get(index).ok_or_else(|| Flaw::dangling(place, "nodes", index, count))?;
        let place = format!("nodes[{index}]");
        if std::mem::replace(&mut reached[index], true) {
            return Err(Flaw::malformed(
                place,
                "is reached twice; every node has at most one parent, and none its own",
            ));
        }
        let transform = parent * local(node, &place)?;
        if !transform.is_finite() {
            return Err(Flaw::malformed(place, "has a transform that is not finite in the world"));
        }
        let visible = visible && is_visible(node);
        standing.push(Standing { index, transform, visible });
        for (i, child) in node.children.as_deref().unwrap_or_default().iter().enumerate().rev() {
            open.push((child.value(), format!("{place}.children[{i}]"), transform, visible));
        }
    }
    Ok(standing)
}

/// What KHR_node_visibility says of a node itself.
fn is_visible(node: &Node) -> bool {
    let extension = node.extensions.as_ref().and_then(|e| e.others.get("KHR_node_visibility"));
    extension.and_then(|e| e.get("visible")?.as_bool()).unwrap_or(true)
}

/// The scene that is shown: the default one, else the first; `None` if the file has none.
pub(crate) fn shown(document: &Document) -> Result<Option<usize>, Flaw> {
    let root = &document.root;
    match root.scene {
        Some(index) => {
            get(&root.scenes, index, "scenes", "scene")?;
            Ok(Some(index.value()))
        }
        None if root.scenes.is_empty() => Ok(None),
        None => Ok(Some(0)),
    }
}

/// The nodes to start from: those of the scene that is shown, else all that have no parent.
fn roots(document: &Document) -> Result<Vec<(usize, String)>, Flaw> {
    let root = &document.root;
    let index = shown(document)?;
    if let Some(index) = index {
        let nodes = root.scenes[index].nodes.iter().enumerate();
        return Ok(nodes.map(|(i, node)| (node.value(), format!("scenes[{index}].nodes[{i}]"))).collect());
    }
    let mut has_parent = vec![false; root.nodes.len()];
    for child in root.nodes.iter().filter_map(|n| n.children.as_ref()).flatten() {
        if let Some(mark) = has_parent.get_mut(child.value()) {
            *mark = true;
        }
    }
    let free = has_parent.iter().enumerate().filter(|(_, has)| !**has);
    Ok(free.map(|(i, _)| (i, format!("nodes[{i}]"))).collect())
}

/// The node's own transform.
fn local(node: &Node, place: &str) -> Result<DAffine3, Flaw> {
    let affine = if let Some(matrix) = node.matrix {
        let m = matrix.map(f64::from);
        if [m[3], m[7], m[11], m[15]] != [0.0, 0.0, 0.0, 1.0] {
            return Err(Flaw::malformed(format!("{place}.matrix"), "is not affine: its last row must be 0 0 0 1"));
        }
        let column = |i: usize| DVec3::new(m[i], m[i + 1], m[i + 2]);
        DAffine3 { matrix3: DMat3::from_cols(column(0), column(4), column(8)), translation: column(12) }
    } else {
        let vector = |v: Option<[f32; 3]>, or: f64| v.map_or(DVec3::splat(or), |v| DVec3::from_array(v.map(f64::from)));
        let rotation = node.rotation.map_or(DQuat::IDENTITY, |q| DQuat::from_array(q.0.map(f64::from)));
        trs(vector(node.translation, 0.0), rotation, vector(node.scale, 1.0), place)?
    };
    if affine.is_finite() { Ok(affine) } else { Err(Flaw::malformed(place, "has a transform that is not finite")) }
}

fn trs(translation: DVec3, rotation: DQuat, scale: DVec3, place: &str) -> Result<DAffine3, Flaw> {
    let length = rotation.length();
    if !(length > 0.0 && length.is_finite()) {
        return Err(Flaw::malformed(format!("{place}.rotation"), "is a quaternion of length 0"));
    }
    Ok(DAffine3::from_scale_rotation_translation(scale, rotation * (1.0 / length), translation))
}

fn place_mesh(
    document: &Document,
    node: &Node,
    place: &str,
    worlds: &[Option<DAffine3>],
    transform: DAffine3,
    library: &mut Library<'_>,
    world: &mut World,
    warnings: &mut Warnings,
) -> Result<(), Flaw> {
    let Some(mesh) = node.mesh else { return Ok(()) };
    let mut skin = None;
    if let Some(index) = node.skin {
        skin = Skin::read(document, index.value(), worlds, place, warnings)?;
        if skin.is_some() {
            warnings.mention("Skins", place, "are shown in the pose in which the file's nodes stand");
        }
    }
    let copies = copies(document, node, place)?;
    for part in library.parts(node, mesh, skin.as_ref(), place, warnings)? {
        if world.placements.len() + copies.len() > limits::PLACEMENTS {
            let problem = format!("is where there are more than {} placed meshes", limits::PLACEMENTS);
            return Err(Flaw::new(Trouble::TooLarge, place, problem, "Split the scene"));
        }
        let (mesh, material) = (part.mesh, part.material);
        if part.bent {
            world.placements.push(Placement { mesh, material, transform: DAffine3::IDENTITY });
            continue;
        }
        let put = |local: &DAffine3| Placement { mesh, material, transform: transform * *local };
        world.placements.extend(copies.iter().map(put));
    }
    Ok(())
}

/// Transforms of the node's copies of its mesh: one, or those of EXT_mesh_gpu_instancing.
fn copies(document: &Document, node: &Node, place: &str) -> Result<Vec<DAffine3>, Flaw> {
    const NAME: &str = "EXT_mesh_gpu_instancing";
    let Some(instancing) = node.extensions.as_ref().and_then(|e| e.others.get(NAME)) else {
        return Ok(vec![DAffine3::IDENTITY]);
    };
    let place = format!("{place}.extensions.{NAME}");
    let attributes = instancing.get("attributes").and_then(|a| a.as_object());
    let accessor = |name: &str| {
        let Some(index) = attributes.and_then(|a| a.get(name)) else { return Ok(None) };
        let index = index.as_u64().and_then(|i| u32::try_from(i).ok()).map(Index::<Accessor>::new);
        let wrong = || Flaw::malformed(format!("{place}.attributes.{name}"), "is not the index of an accessor");
        index.ok_or_else(wrong).map(Some)
    };
    let read = |name: &str, components: usize| {
        let Some(index) = accessor(name)? else { return Ok(None) };
        let place = format!("{place}.attributes.{name}");
        accessor::vectors(document, index, &[components], 0.0, &place).map(|rows| Some(rows.rows))
    };
    let (translations, rotations, scales) = (read("TRANSLATION", 3)?, read("ROTATION", 4)?, read("SCALE", 3)?);
    let mut counts = [&translations, &rotations, &scales].into_iter().flatten().map(Vec::len);
    let count = match (counts.next(), attributes.and_then(|a| a.keys().next())) {
        (Some(count), _) => count,
        // Attributes of the file's own: as many copies as they have entries, all at the node.
        (None, Some(name)) => match accessor(name)? {
            Some(index) => accessor::vectors(document, index, &[1, 2, 3, 4], 0.0, &place)?.rows.len(),
            None => 0,
        },
        (None, None) => 0,
    };
    if counts.any(|other| other != count) {
        return Err(Flaw::malformed(place, "has attributes of different lengths"));
    }
    let vector = |list: &Option<Vec<[f64; 4]>>, i: usize, or: f64| {
        list.as_ref().map_or(DVec3::splat(or), |list| DVec3::new(list[i][0], list[i][1], list[i][2]))
    };
    (0..count)
        .map(|i| {
            let rotation = rotations.as_ref().map_or(DQuat::IDENTITY, |list| DQuat::from_array(list[i]));
            trs(vector(&translations, i, 0.0), rotation, vector(&scales, i, 1.0), &place)
        })
        .collect()
}

fn place_camera(
    document: &Document,
    node: &Node,
    place: &str,
    transform: DAffine3,
    world: &mut World,
    warnings: &mut Warnings,
) -> Result<(), Flaw> {
    let Some(index) = node.camera else { return Ok(()) };
    let camera = get(&document.root.cameras, index, "cameras", &format!("{place}.camera"))?;
    let place = format!("cameras[{}]", index.value());
    let extras = document.camera_extras.get(index.value());
    let projection = camera::projection(camera, extras, &place, warnings)?;
    let camera_name = camera.name.clone().unwrap_or_default();
    let name = node.name.clone().unwrap_or_else(|| camera_name.clone());
    let description = CameraDescription { name, transform, projection };
    world.cameras.push(PlacedCamera { number: index.value(), camera_name, description });
    Ok(())
}

fn place_light(
    document: &Document,
    node: &Node,
    place: &str,
    transform: DAffine3,
    world: &mut World,
    warnings: &mut Warnings,
) -> Result<(), Flaw> {
    const NAME: &str = "KHR_lights_punctual";
    let Some(reference) = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref()) else {
        return Ok(());
    };
    let lights = document.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    let lights = lights.map_or(&[][..], |l| &l.lights);
    let light = get(lights, reference.light, "lights", &format!("{place}.extensions.{NAME}.light"))?;
    let place = format!("extensions.{NAME}.lights[{}]", reference.light.value());
    if light.range.is_some() {
        warnings.note("Ranges of lights", &place, "are not supported: light falls off with the square of the distance");
    }
    let emitted = Rgb::from_array(light.color.map(f64::from)) * f64::from(light.intensity);
    if !emitted.is_finite() || emitted.min_element() < 0.0 {
        return Err(Flaw::malformed(place, "has a colour or intensity that is negative or not finite"));
    }
    world.lights.push(punctual(light, emitted, transform, &place)?);
    Ok(())
}

fn punctual(light: &Light, emitted: Rgb, transform: DAffine3, place: &str) -> Result<PunctualLight, Flaw> {
    let position = transform.translation;
    // Lights shine along their -z.
    let direction = || {
        let direction = (-transform.matrix3.z_axis).try_normalize();
        direction.ok_or_else(|| Flaw::malformed(place, "stands at a node whose scale leaves it no direction"))
    };
    match light.type_ {
        Checked::Valid(Type::Point) => Ok(PunctualLight::Point { position, intensity: emitted }),
        Checked::Valid(Type::Directional) => {
            Ok(PunctualLight::Directional { direction: direction()?, irradiance: emitted })
        }
        Checked::Valid(Type::Spot) => {
            let spot = light.spot.as_ref();
            let spot = spot.ok_or_else(|| Flaw::malformed(place, "is a spot light without spot"))?;
            let (inner, outer) = (f64::from(spot.inner_cone_angle), f64::from(spot.outer_cone_angle));
            // A half turn of a degree more: exporters round pi / 2 upwards.
            if !(inner >= 0.0 && inner <= outer && outer > 0.0 && outer <= PI / 2.0 + 0.01) {
                let problem = format!("has cone angles {inner} and {outer}; 0 <= inner <= outer <= pi / 2 must hold");
                return Err(Flaw::malformed(format!("{place}.spot"), problem));
            }
            let (cos_inner, cos_outer) = (libm::cos(inner), libm::cos(outer).max(0.0));
            Ok(PunctualLight::Spot { position, axis: direction()?, intensity: emitted, cos_inner, cos_outer })
        }
        Checked::Invalid => Err(Flaw::malformed(format!("{place}.type"), "is not point, spot or directional")),
    }
}
