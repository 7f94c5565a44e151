//! What a scene is made with: lights, solids and the camera brought into its own space.

use super::*;

/// Draws the meshes of refracting solids in; `offset` is how far off surfaces rays start in the scene's own space.
pub(super) fn draw_solids_in(
    meshes: &mut [Mesh],
    placements: &[Placement],
    instances: &[Instance],
    materials: &[Material],
    offset: f64,
) {
    // A plane with unit normal n that moves by d moves by d / |M^-T n| in the world.
    let mut maps: BTreeMap<u32, Vec<DMat3>> = BTreeMap::new();
    for (_, instance) in placements.iter().zip(instances).filter(|(p, _)| materials[p.material].is_solid()) {
        let map = instance.transform.matrix3.inverse().transpose();
        if map.is_finite() {
            maps.entry(instance.mesh).or_default().push(map);
        }
    }
    for (rank, (mesh, maps)) in maps.into_iter().enumerate() {
        let by = drawn_in(rank) * offset;
        let distance = |n: DVec3| maps.iter().map(|map| (*map * n).length()).fold(0.0, f64::max) * by;
        draw_in(&mut meshes[mesh as usize], distance);
    }
}

/// The camera of a view in the scene's own space.
pub(super) fn camera(view: &View, to_scene: &DAffine3, scale: f64) -> Camera {
    let mut transform = *to_scene * rigid(&view.camera.transform);
    let (width, height, margin) = (view.width, view.height, view.margin);
    let camera = match view.camera.projection {
        Projection::Perspective { vertical_fov, lens } => {
            let pinhole = Camera::new(transform, vertical_fov, width, height, margin);
            lens.map_or(pinhole, |lens| {
                let (radius, focus_distance) = (lens.radius * scale, lens.focus_distance * scale);
                pinhole.with_lens(Lens { radius, focus_distance, ..lens })
            })
        }
        Projection::Orthographic { height: tall, near } => {
            transform.translation -= transform.matrix3.z_axis * near;
            Camera::orthographic(transform, tall * scale, width, height, margin)
        }
    };
    match view.crop {
        None => camera,
        Some((left, top, right, bottom)) => {
            let corner = |x: u32, y: u32| DVec2::new(f64::from(x), f64::from(y));
            camera.cropped(corner(left, top), corner(right, bottom))
        }
    }
}

/// A camera's end of a path; of a lens its middle.
pub(super) fn eye_vertex(camera: &Camera, medium: u32) -> Vertex {
    let free_space = Interaction::none();
    let (kind, position, ng) = match camera.optics() {
        Optics::Pinhole => (Kind::Camera, camera.position(), free_space.ng),
        Optics::Lens { .. } => (Kind::Aperture, camera.position(), camera.forward()),
        Optics::Orthographic => (Kind::DistantCamera, DVec3::ZERO, camera.forward()),
    };
    let (component, interaction) = (Component::Rough, free_space.with_normal(ng));
    let medium = if kind == Kind::DistantCamera { AIR } else { medium };
    Vertex {
        kind,
        component,
        coverage: Coverage::WHOLE,
        emitter: NO_EMITTER,
        material: 0,
        medium,
        position,
        interaction,
        emission: Rgb::ZERO,
    }
}

/// The rotation and translation of a transform, without scale.
pub(super) fn rigid(transform: &DAffine3) -> DAffine3 {
    let m = transform.matrix3;
    let z = m.z_axis.normalize_or(DVec3::Z);
    let y = m.y_axis.reject_from_normalized(z).normalize_or(z.any_orthonormal_vector());
    let matrix3 = DMat3::from_cols(y.cross(z), y, z);
    DAffine3 { matrix3, translation: transform.translation }
}

/// A light in the scene's own space: intensity grows with the square of the scale, irradiance stays.
pub(super) fn scaled_light(light: &PunctualLight, to_scene: &DAffine3, scale: f64) -> PunctualLight {
    let mut light = *light;
    match &mut light {
        PunctualLight::Point { position, intensity } | PunctualLight::Spot { position, intensity, .. } => {
            *position = to_scene.transform_point3(*position);
            *intensity *= scale * scale;
        }
        PunctualLight::Directional { .. } => {}
    }
    light
}

/// Where a light is, unless it is infinitely far away.
pub(super) fn position_of(light: &PunctualLight) -> Option<DVec3> {
    match light {
        PunctualLight::Directional { .. } => None,
        PunctualLight::Point { position, .. } | PunctualLight::Spot { position, .. } => Some(*position),
    }
}

/// Radius of a ball that holds the one of `radius` and these points, clear of its surface.
pub(super) fn ball_around(centre: DVec3, radius: f64, points: impl Iterator<Item = DVec3>) -> f64 {
    points.map(|point| point.distance(centre)).fold(radius, f64::max) * (1.0 + 1e-6)
}

/// Number of points at which a textured emitter's radiance is averaged to weigh its triangles.
const POWER_SAMPLES: usize = 16;

/// A textured triangle weighs at least this share of its untextured power, so that no bright spot between the averaged
/// points has density 0.
const POWER_FLOOR: f64 = 0.05;

/// Area of an emissive triangle and the luminous power that weighs it. Degenerate triangles have power 0.
pub(super) fn triangle_power(
    world: &World,
    textures: &[Texture],
    material: &Material,
    instance: u32,
    triangle: u32,
) -> (f64, f64) {
    let [a, b, c] = world.triangle(instance, triangle);
    let area = (b - a).cross(c - a).length() * 0.5;
    let full = luminance(material.emission);
    let radiance = if material.emission_varies() {
        let sum: f64 = (0..POWER_SAMPLES)
            .map(|i| {
                let (u, v) = warp::uniform_triangle([
                    (i as f64 + 0.5) / POWER_SAMPLES as f64,
                    (0.5 + i as f64 * 0.618_033_988_749_895).fract(),
                ]);
                luminance(material.emitted(textures, &world.surface_at(instance, triangle, u, v)))
            })
            .sum();
        (sum / POWER_SAMPLES as f64).max(POWER_FLOOR * full)
    } else {
        full
    };
    let faces = if material.double_sided { 2.0 } else { 1.0 };
    (area, std::f64::consts::PI * radiance * area * faces)
}
