//! The scene as paths see it: points of surfaces, lights, the camera, visibility. Built once, then read only.
//!
//! The scene lives in a space of its own: recentred on the bounding box and scaled by a power of two so that its larger
//! half extent lies in [1/2, 1). Lights and absorption are scaled with it, so that the picture does not depend on the
//! file's units.

mod emitters;
mod eye;
mod making;
mod within;

use std::cell::Cell;
use std::collections::BTreeMap;
use std::sync::Arc;

use ergodic_geometry::phase::{self, Phase};
use ergodic_geometry::{Anchor, Hit, Instance, Isa, Mesh, Ray, Surface, World, spawn_offset};
use ergodic_metropolis::RandomSource;
use ergodic_scattering::{
    Bsdf, Camera, Component, Core, Environment, Everything, Interaction, Lens, Material, Matte, Optics, PunctualLight,
    Repertoire, Rgb, Sight, Texture, Wavelength, emission, luminance, warp,
};
use glam::{DAffine3, DMat3, DVec2, DVec3, DVec4};

use crate::gap::{draw_in, drawn_in};
use crate::lights::{Emitter, Lights};
use crate::media::{AIR, Media};
use crate::record;
use crate::vertex::{ENVIRONMENT, NO_EMITTER};
use crate::{
    CameraDescription, Census, Coverage, Edge, Effect, Effects, Kind, Placement, Projection, SceneDescription,
    SceneError, Vertex,
};

pub use within::{Compiled, Within};

use making::{ball_around, camera, draw_solids_in, eye_vertex, position_of, scaled_light, triangle_power};

/// The name, to a [`RandomSource`], of the choices that belong to neither walk (see [`crate::End`]).
const CHOICES: usize = 2;

/// The place of the wavelength among them.
const WAVELENGTH: usize = 2;

thread_local! {
    static RAYS: Cell<u64> = const { Cell::new(0) };
}

/// Rays, shadow rays included, that this thread has traced so far. A plain counter: nothing that is rendered depends on it.
pub fn rays_traced() -> u64 {
    RAYS.get()
}

#[inline]
pub(crate) fn count_ray() {
    RAYS.set(RAYS.get() + 1);
}

/// The image that a scene is looked at through.
#[derive(Clone, Debug)]
pub struct View {
    /// The camera, in the description's space.
    pub camera: CameraDescription,
    /// Width of the image in pixels.
    pub width: u32,
    /// Height of the image in pixels.
    pub height: u32,
    /// The window of the image that is rendered, `(left, top, right, bottom)` in pixels, or all of it. The raster begins at its
    /// corner.
    pub crop: Option<(u32, u32, u32, u32)>,
    /// Pixels by which the raster domain is wider than the image on each side: what the reconstruction filter reaches
    /// beyond the outermost pixel centres, less half a pixel.
    pub margin: f64,
}

/// A scene ready for light transport: a handle, cheap to clone, to what is built once.
///
/// Its type says what code that takes it is compiled for. A scene is made for [`Everything`]; [`Scene::within`] renders it by code
/// that has what it needs and no more.
#[derive(Clone, Debug)]
pub struct Scene<R: Repertoire = Everything> {
    pub(crate) parts: Arc<Parts>,
    camera: Camera<R>,
}

/// What a scene consists of.
#[derive(Debug)]
pub(crate) struct Parts {
    pub(crate) world: World,
    effects: Effects,
    repertoire: Compiled,
    materials: Vec<Material>,
    /// Of each material, its scattering if that is the same everywhere.
    constant: Vec<Option<Bsdf>>,
    textures: Vec<Texture>,
    material_of_instance: Vec<u32>,
    /// Of each instance, whether it covers a share only anywhere; empty if none does.
    is_partial: Vec<bool>,
    /// Whether paths have a wavelength: some surface refracts different ones differently, or is to be ready for it.
    disperses: bool,
    /// Index of an instance's first emissive triangle, or [`NO_EMITTER`].
    first_emitter: Vec<u32>,
    lights: Lights,
    /// Boxed, so that scenes without one keep what they read close together.
    environment: Option<Box<Environment>>,
    /// Radius of a ball about [`Self::centre`] that holds all surfaces, and all else where there is a medium outside solids, which
    /// it bounds.
    pub(crate) radius: f64,
    scale: f64,
    pub(crate) media: Media,
    /// The camera as a vertex, with what it is in; of a lens its middle.
    eye: Vertex,
    /// What each punctual light is in.
    light_media: Vec<u32>,
}

impl Scene {
    /// Builds the scene for one view.
    ///
    /// # Errors
    ///
    /// No triangle, no light that emits anything, or geometry that is not finite.
    pub fn new(description: SceneDescription, view: &View) -> Result<Self, SceneError> {
        Self::searched_with(None, description, view)
    }

    /// The same, searched with other instructions than the best that there are; nothing else changes, to the bit.
    ///
    /// # Errors
    ///
    /// Those of [`Self::new`].
    pub fn searched_with(isa: Option<Isa>, description: SceneDescription, view: &View) -> Result<Self, SceneError> {
        let (low, high) = description.bounds().ok_or(SceneError::NoTriangles)?;
        let half_extent = ((high - low) * 0.5).max_element();
        if !half_extent.is_finite() || half_extent <= 0.0 {
            return Err(SceneError::NoExtent);
        }
        // A power of two: scaling by it rounds nothing.
        let scale = libm::exp2(-libm::log2(half_extent).floor() - 1.0);
        let centre = (low + high) * 0.5;
        let to_scene = DAffine3::from_scale(DVec3::splat(scale)) * DAffine3::from_translation(-centre);

        let effects = Census::of(&description, Some(&view.camera)).effects().with(description.ready_for);
        let SceneDescription {
            mut meshes,
            placements,
            mut materials,
            textures,
            lights,
            environment,
            medium,
            ready_for,
            ..
        } = description;
        let instances = placements
            .iter()
            .map(|p| Instance { mesh: p.mesh as u32, transform: to_scene * p.transform })
            .collect::<Vec<_>>();
        let offset = spawn_offset((low - centre) * scale, (high - centre) * scale);
        draw_solids_in(&mut meshes, &placements, &instances, &materials, offset);
        let material_of_instance: Vec<u32> = placements.iter().map(|p| p.material as u32).collect();
        let mut world = World::build(meshes, instances)?;
        if let Some(isa) = isa {
            world = world.with_isa(isa);
        }
        for material in &mut materials {
            material.absorption /= scale;
            material.scattering /= scale;
            material.general |= ready_for.has(Effect::Layers);
        }
        let mut radius = {
            let (low, high) = world.bounds();
            (high - low).length() * 0.5
        };

        let least = |(i, &material): (usize, &u32)| {
            let colors = world.mesh(world.instances()[i].mesh).colors.as_deref().unwrap_or_default();
            let color_alpha = colors.iter().map(|color| color.w).fold(1.0, f64::min);
            materials[material as usize].least_coverage(&textures, color_alpha)
        };
        let ask = ready_for.has(Effect::Masks) || ready_for.has(Effect::Blending);
        let mut is_partial: Vec<bool> =
            material_of_instance.iter().enumerate().map(|i| ask || least(i) < 1.0).collect();
        if !is_partial.contains(&true) {
            is_partial.clear();
        }

        let mut first_emitter = vec![NO_EMITTER; placements.len()];
        let mut triangles = Vec::new();
        for (instance, &material) in material_of_instance.iter().enumerate() {
            let material = &materials[material as usize];
            if luminance(material.emission) <= 0.0 {
                continue;
            }
            first_emitter[instance] = triangles.len() as u32;
            for triangle in 0..world.triangle_count(instance as u32) as u32 {
                let (area, power) = if world.can_be_hit(instance as u32, triangle) {
                    triangle_power(&world, &textures, material, instance as u32, triangle)
                } else {
                    // What no ray meets must not be chosen as a light either.
                    (0.0, 0.0)
                };
                triangles.push((Emitter::Triangle { instance: instance as u32, triangle }, area, power));
            }
        }
        let punctual: Vec<_> = lights.iter().map(|light| scaled_light(light, &to_scene, scale)).collect();
        let camera = camera(view, &to_scene, scale);
        let air = medium.scaled(scale);
        if !air.is_vacuum() {
            let (low, high) = world.bounds();
            let points = punctual.iter().filter_map(position_of).chain(camera.reach());
            radius = ball_around((low + high) * 0.5, radius, points);
        }
        // A black one is none.
        let lit = environment.filter(|environment| environment.total_luminance() > 0.0);
        let environment =
            lit.or_else(|| ready_for.has(Effect::Environment).then(|| Environment::constant(Rgb::ZERO))).map(Box::new);
        let disk = std::f64::consts::PI * radius * radius;
        let environment_power = environment.as_ref().map(|environment| environment.total_luminance() * disk);
        let lights = Lights::new(triangles, punctual, environment_power, radius);
        if lights.is_empty() {
            return Err(SceneError::NoLight);
        }

        let repertoire = Compiled::smallest(effects, &materials);
        let media = Media::new(&world, &materials, &material_of_instance, air, ready_for);
        let made_once = !(ready_for.has(Effect::Textures) || ready_for.has(Effect::VertexColors));
        let constant = materials.iter().map(|material| material.constant_bsdf().filter(|_| made_once)).collect();
        let eye = eye_vertex(&camera, media.around(&world, camera.position(), None));
        let medium_at = |light| position_of(light).map_or(AIR, |position| media.around(&world, position, None));
        let light_media = lights.punctual.iter().map(medium_at).collect();
        let parts = Parts {
            world,
            effects,
            repertoire,
            constant,
            materials,
            textures,
            material_of_instance,
            is_partial,
            disperses: effects.has(Effect::Dispersion),
            first_emitter,
            lights,
            environment,
            radius,
            scale,
            media,
            eye,
            light_media,
        };
        Ok(Self { parts: Arc::new(parts), camera })
    }
}

impl<R: Repertoire> Scene<R> {
    /// The effects that the scene has or is ready for.
    pub fn effects(&self) -> Effects {
        self.parts.effects
    }

    /// The geometry.
    pub fn world(&self) -> &World {
        &self.parts.world
    }

    /// The camera.
    #[inline]
    pub fn camera(&self) -> &Camera<R> {
        &self.camera
    }

    /// Materials, by [`Vertex`]'s own index.
    pub fn materials(&self) -> &[Material] {
        &self.parts.materials
    }

    /// The factor from the file's unit of length to the scene's own.
    pub fn scale(&self) -> f64 {
        self.parts.scale
    }

    /// Whether light of different wavelengths takes different paths. Without it paths have no wavelength.
    #[inline]
    pub fn disperses(&self) -> bool {
        R::DISPERSION && self.parts.disperses
    }

    /// A wavelength with density 1; [`Wavelength::NONE`], from no number, where nothing depends on it.
    #[inline]
    pub fn sample_wavelength(&self, rng: &mut impl RandomSource) -> Wavelength {
        if !self.disperses() {
            return Wavelength::NONE;
        }
        rng.enter(CHOICES, WAVELENGTH);
        Wavelength::at(rng.uniform())
    }

    /// The point of the surface that was hit, as if met in air.
    #[inline]
    pub fn vertex(&self, hit: &Hit) -> Vertex<R> {
        let mut vertex = self.camera_vertex();
        self.place(hit, Wavelength::NONE, &mut vertex);
        vertex
    }

    /// Makes `vertex` the point of the surface that was hit, as if met in air, for light of a wavelength.
    #[inline(always)]
    pub(crate) fn place(&self, hit: &Hit, wavelength: Wavelength, vertex: &mut Vertex<R>) {
        let _phase = phase::enter(Phase::Shading);
        let surface = self.parts.world.surface(hit);
        let index = self.parts.material_of_instance[hit.instance as usize];
        let material = &self.parts.materials[index as usize];
        vertex.kind = Kind::Surface;
        vertex.component = Component::Rough;
        vertex.material = index;
        vertex.medium = AIR;
        vertex.coverage = if self.has_partial_coverage() { self.coverage_at(&surface) } else { Coverage::WHOLE };
        vertex.position = surface.position;
        vertex.interaction = match &self.parts.constant[index as usize] {
            // Nothing of it depends on the point but the colour of the mesh.
            Some(bsdf) if !R::TEXTURES || surface.color == DVec4::ONE => Material::interaction_of(*bsdf, &surface),
            None if !R::TEXTURES => Material::interaction_of(Bsdf::BLACK, &surface),
            _ => material.interaction_at(&self.parts.textures, &surface, wavelength),
        };
        let first = self.parts.first_emitter[hit.instance as usize];
        if first == NO_EMITTER {
            (vertex.emitter, vertex.emission) = (NO_EMITTER, Rgb::ZERO);
        } else {
            vertex.emitter = first + hit.triangle;
            vertex.emission =
                if R::TEXTURES { material.emitted(&self.parts.textures, &surface) } else { material.emission };
        }
    }

    /// Whether anything but vacuum fills a solid or what lies around, or somebody wants to know.
    #[inline]
    pub(crate) fn has_media(&self) -> bool {
        R::MEDIA && !self.parts.media.is_empty()
    }

    /// Whether any surface covers a share only.
    #[inline]
    pub fn has_partial_coverage(&self) -> bool {
        R::COVERAGE && !self.parts.is_partial.is_empty()
    }

    fn coverage_at(&self, surface: &Surface) -> Coverage {
        if !self.parts.is_partial[surface.instance as usize] {
            return Coverage::WHOLE;
        }
        let material = &self.parts.materials[self.parts.material_of_instance[surface.instance as usize] as usize];
        Coverage::new(material.coverage(&self.parts.textures, surface))
    }

    /// The coverage where a ray meets a surface, in scenes where there is a partial one.
    fn coverage_of_hit(&self, hit: &Hit) -> Coverage {
        if self.parts.is_partial[hit.instance as usize] {
            self.coverage_at(&self.parts.world.surface(hit))
        } else {
            Coverage::WHOLE
        }
    }

    /// What a ray meets first. It stops at a surface with the probability of its coverage; numbers are drawn for surfaces only that
    /// are there but not whole.
    #[inline]
    pub(crate) fn meet(&self, ray: &Ray, rng: &mut impl RandomSource) -> Option<Hit> {
        record::closest(ray);
        if !self.has_partial_coverage() {
            return self.parts.world.intersect(ray);
        }
        self.parts.world.intersect_where(ray, |hit| {
            let share = self.coverage_of_hit(hit).share();
            share >= 1.0 || share > 0.0 && rng.uniform() < share
        })
    }

    /// The first point of a surface seen from `from` in direction `w`, or a point of a medium before it, for light of a wavelength.
    #[inline]
    pub fn trace(
        &self,
        from: &Vertex<R>,
        w: DVec3,
        wavelength: Wavelength,
        rng: &mut impl RandomSource,
    ) -> Option<Vertex<R>> {
        let mut vertex = self.camera_vertex();
        self.fly_to(from, w, wavelength, &mut vertex, rng).then_some(vertex)
    }

    /// Makes `to` the first point of a surface seen from `from` in direction `w`, for light of a wavelength; false if there is none.
    /// Media do not scatter.
    #[inline]
    pub fn trace_to(
        &self,
        from: &Vertex<R>,
        w: DVec3,
        wavelength: Wavelength,
        to: &mut Vertex<R>,
        rng: &mut impl RandomSource,
    ) -> bool {
        count_ray();
        let ray = self.parts.world.spawn(&from.anchor(), w);
        let Some(hit) = self.meet(&ray, rng) else { return false };
        self.place(&hit, wavelength, to);
        if self.has_media() {
            to.medium = self.medium_met(from, w, to, hit.instance);
        }
        true
    }

    /// What the eye sees from `from` in direction `w`: what [`Self::trace`] finds, or the environment where that is nothing.
    #[inline]
    pub fn look(
        &self,
        from: &Vertex<R>,
        w: DVec3,
        wavelength: Wavelength,
        rng: &mut impl RandomSource,
    ) -> Option<Vertex<R>> {
        let mut vertex = self.camera_vertex();
        self.fly_or_escape(from, w, wavelength, &mut vertex, rng).then_some(vertex)
    }

    /// Makes `to` the first point of a surface seen from `from` in direction `w`, or the environment where there is none; false if
    /// that is nothing. Media do not scatter.
    #[inline]
    pub fn look_to(
        &self,
        from: &Vertex<R>,
        w: DVec3,
        wavelength: Wavelength,
        to: &mut Vertex<R>,
        rng: &mut impl RandomSource,
    ) -> bool {
        self.trace_to(from, w, wavelength, to, rng) || self.escape_to(w, to)
    }

    /// Makes `to` the environment in direction `w`; false if that is black.
    #[inline]
    pub(crate) fn escape_to(&self, w: DVec3, to: &mut Vertex<R>) -> bool {
        let Some(environment) = self.parts.environment.as_ref().filter(|_| R::OTHER_LIGHTS) else { return false };
        let radiance = environment.radiance(w);
        *to = self.environment_vertex(-w, radiance);
        radiance.max_element() > 0.0
    }

    /// The environment's light that travels along `direction`.
    fn environment_vertex(&self, direction: DVec3, radiance: Rgb) -> Vertex<R> {
        Vertex {
            kind: Kind::Environment,
            component: Component::Rough,
            coverage: Coverage::WHOLE,
            emitter: ENVIRONMENT,
            material: 0,
            medium: AIR,
            position: DVec3::ZERO,
            interaction: Interaction::none().with_normal(direction),
            emission: radiance,
        }
    }

    /// What lies at the outer side of `to`, which a ray from `from` in direction `w` met.
    pub(crate) fn medium_met(&self, from: &Vertex<R>, w: DVec3, to: &Vertex<R>, instance: u32) -> u32 {
        if bounds_towards(to, -w) {
            // Met from within: what is around it has to be asked.
            self.parts.media.around(&self.parts.world, to.position, Some(instance))
        } else if bounds_towards(from, w) {
            from.material
        } else {
            from.medium
        }
    }

    /// Whether light passes the connection between two vertices, which is `edge`.
    #[inline]
    pub fn connects(&self, a: &Vertex<R>, b: &Vertex<R>, edge: &Edge) -> bool {
        // Where a surface is partial, edges have been asked already.
        if self.has_partial_coverage() { edge.geometry > 0.0 } else { self.mutually_visible(a, b) }
    }

    /// The share of light that passes between two vertices: the product of what the surfaces between them do not cover. Symmetric to
    /// the bit.
    pub fn visibility(&self, a: &Vertex<R>, b: &Vertex<R>) -> f64 {
        if !self.has_partial_coverage() {
            return f64::from(u8::from(self.mutually_visible(a, b)));
        }
        count_ray();
        let passes = |hit: &Hit| 1.0 - self.coverage_of_hit(hit).share();
        let on_film = |vertex: &Vertex<R>| Anchor { position: self.film_point(vertex), normal: DVec3::ZERO };
        match (a, b) {
            _ if a.is_distant() => self.parts.world.visibility_from_afar(&b.anchor(), -a.interaction.ng, passes),
            _ if b.is_distant() => self.parts.world.visibility_from_afar(&a.anchor(), -b.interaction.ng, passes),
            _ if a.is_on_film() => self.parts.world.visibility(&b.anchor(), &on_film(b), passes),
            _ if b.is_on_film() => self.parts.world.visibility(&a.anchor(), &on_film(a), passes),
            _ => self.parts.world.visibility(&a.anchor(), &b.anchor(), passes),
        }
    }

    /// Whether two vertices see each other. Symmetric to the bit.
    #[inline(always)]
    pub fn mutually_visible(&self, a: &Vertex<R>, b: &Vertex<R>) -> bool {
        if self.has_partial_coverage() {
            return self.visibility(a, b) > 0.0;
        }
        count_ray();
        record::visibility(a, b);
        match (a, b) {
            _ if a.is_distant() => self.parts.world.escapes(&b.anchor(), -a.interaction.ng),
            _ if b.is_distant() => self.parts.world.escapes(&a.anchor(), -b.interaction.ng),
            _ if a.is_on_film() => self.seen_from_film(b),
            _ if b.is_on_film() => self.seen_from_film(a),
            _ => self.parts.world.visible(&a.anchor(), &b.anchor()),
        }
    }

    /// Beer's transmittance between two neighbouring vertices.
    ///
    /// The medium is that of the solid whose inner side the segment leaves at its light side, else at its eye side, else
    /// that which its ends are met in.
    #[inline]
    pub(crate) fn transmittance(
        &self,
        light_side: &Vertex<R>,
        eye_side: &Vertex<R>,
        direction: DVec3,
        length: f64,
    ) -> Rgb {
        if !self.has_media() {
            return Rgb::ONE;
        }
        let medium = self.medium_between(light_side, eye_side, direction);
        if medium.is_vacuum() { Rgb::ONE } else { medium.transmittance(length) }
    }

    fn punctual_vertex(&self, index: u32) -> Vertex<R> {
        let light = &self.parts.lights.punctual[index as usize];
        let mut interaction = Interaction::none();
        let (kind, position) = match light {
            PunctualLight::Directional { direction, .. } => {
                interaction.ng = *direction;
                (Kind::DistantLight(index), DVec3::ZERO)
            }
            PunctualLight::Point { position, .. } | PunctualLight::Spot { position, .. } => {
                (Kind::PointLight(index), *position)
            }
        };
        let emission = Rgb::ZERO;
        let component = Component::Rough;
        let medium = self.parts.light_media[index as usize];
        Vertex {
            kind,
            component,
            coverage: Coverage::WHOLE,
            emitter: NO_EMITTER,
            material: 0,
            medium,
            position,
            interaction,
            emission,
        }
    }

    /// Makes `to` the first point of a surface that light from infinitely far away meets on the line along `direction` through `point`;
    /// false if there is none.
    #[inline]
    pub fn trace_parallel(
        &self,
        direction: DVec3,
        point: DVec3,
        wavelength: Wavelength,
        to: &mut Vertex<R>,
        rng: &mut impl RandomSource,
    ) -> bool {
        count_ray();
        let Some(hit) = self.meet(&self.ray_from_afar(direction, point), rng) else { return false };
        self.place(&hit, wavelength, to);
        true
    }

    /// The ray of light from infinitely far away on the line along `direction` through `point`.
    #[inline]
    pub(crate) fn ray_from_afar(&self, direction: DVec3, point: DVec3) -> Ray {
        // Any start before the scene will do; one radius before the bounding sphere's centre touches it.
        let along = direction.dot(point - self.centre());
        Ray { origin: point - direction * (along + 2.0 * self.parts.radius), direction }
    }

    /// The middle of the scene's bounding box.
    pub(crate) fn centre(&self) -> DVec3 {
        let (low, high) = self.parts.world.bounds();
        (low + high) * 0.5
    }
}

/// Whether a vertex bounds a solid and `w` points into it.
#[inline]
pub(crate) fn bounds_towards<R: Repertoire>(vertex: &Vertex<R>, w: DVec3) -> bool {
    vertex.is_surface() && vertex.interaction.medium_below() && vertex.interaction.ng.dot(w) < 0.0
}
