//! The light ends of paths: points on emitters, their densities, and what leaves them.

use super::*;

impl Scene {
    /// Makes `light` a point on a light or a direction of the environment, with density [`Self::emitter_pdf_area`].
    #[inline]
    pub fn sample_emitter(&self, wavelength: Wavelength, light: &mut Vertex, rng: &mut impl RandomSource) {
        match self.lights.choose(rng) {
            Emitter::Punctual(index) => *light = self.punctual_vertex(index),
            Emitter::Environment => match &self.environment {
                Some(environment) => {
                    let w = environment.sample([rng.uniform(), rng.uniform(), rng.uniform()]);
                    *light = self.environment_vertex(-w, environment.radiance(w));
                }
                None => unreachable!("an environment was chosen where there is none"),
            },
            Emitter::Triangle { instance, triangle } => {
                let (u, v) = warp::uniform_triangle([rng.uniform(), rng.uniform()]);
                self.place(&Hit { instance, triangle, u, v, t: 0.0 }, wavelength, light);
                if !self.media.is_empty() {
                    light.medium = self.media.around(&self.world, light.position, Some(instance));
                }
            }
        }
    }

    /// Area density of a light vertex; density per solid angle of the environment; the probability of the light for one without
    /// extent; 0 where nothing emits.
    #[inline]
    pub fn emitter_pdf_area(&self, vertex: &Vertex) -> f64 {
        match vertex.kind {
            Kind::Surface if vertex.emits() => self.lights.triangle_pdf_area(vertex.emitter),
            Kind::Surface | Kind::Volume | Kind::Camera | Kind::Aperture | Kind::DistantCamera => 0.0,
            Kind::PointLight(index) | Kind::DistantLight(index) => self.lights.punctual_probability(index),
            Kind::Environment => self.environment_pdf(vertex.emission),
        }
    }

    /// Emitted radiance (surface, environment), radiant intensity (point light) or irradiance (distant light) in direction `w`.
    #[inline]
    pub fn emitted(&self, vertex: &Vertex, w: DVec3) -> Rgb {
        match vertex.kind {
            Kind::Surface if vertex.emits() => {
                let radiance = emission::emitted(vertex.emission, self.double_sided(vertex), vertex.interaction.ng, w);
                radiance * vertex.interaction.emission_factor(w)
            }
            Kind::Surface | Kind::Volume | Kind::Camera | Kind::Aperture | Kind::DistantCamera => Rgb::ZERO,
            Kind::PointLight(index) | Kind::DistantLight(index) => self.lights.punctual[index as usize].emitted(w),
            Kind::Environment => vertex.emission,
        }
    }

    /// Density per solid angle of a direction of the environment from which `radiance` comes, its choice among lights included.
    pub(super) fn environment_pdf(&self, radiance: Rgb) -> f64 {
        let pdf = self.environment.as_ref().map_or(0.0, |environment| environment.pdf_solid_angle(radiance));
        self.lights.environment_probability() * pdf
    }

    pub(super) fn double_sided(&self, vertex: &Vertex) -> bool {
        self.materials[vertex.material as usize].double_sided
    }

    /// Solid-angle density of the emitted direction `w`; for a distant light and the environment, whose direction is known
    /// already, the area density on their disk, which is perpendicular to it and as large as the scene's bounding sphere.
    #[inline]
    pub fn emission_pdf(&self, vertex: &Vertex, w: DVec3) -> f64 {
        match vertex.kind {
            Kind::Surface if vertex.emits() => {
                emission::pdf_direction(self.double_sided(vertex), vertex.interaction.ng, w)
            }
            Kind::Surface | Kind::Volume | Kind::Camera | Kind::Aperture | Kind::DistantCamera => 0.0,
            Kind::PointLight(index) => self.lights.punctual[index as usize].pdf_direction(w),
            Kind::DistantLight(_) | Kind::Environment => 1.0 / (std::f64::consts::PI * self.radius * self.radius),
        }
    }

    /// Makes `to` the next vertex of a light subpath that starts at `light`, with density [`Self::emission_pdf`]; false if there is
    /// none.
    #[inline]
    pub fn sample_emission(
        &self,
        light: &Vertex,
        wavelength: Wavelength,
        to: &mut Vertex,
        rng: &mut impl RandomSource,
    ) -> bool {
        let u = [rng.uniform(), rng.uniform()];
        let w = match light.kind {
            Kind::Surface => emission::sample_direction(self.double_sided(light), light.interaction.ng, u),
            Kind::PointLight(index) => self.lights.punctual[index as usize].sample_direction(u),
            Kind::DistantLight(_) | Kind::Environment => {
                let direction = light.interaction.ng;
                let frame = ergodic_geometry::Frame::from_normal(direction);
                let DVec2 { x, y } = warp::concentric_disk(u) * self.radius;
                let through = frame.t * x + frame.b * y + self.centre();
                return self.fly_parallel(direction, through, wavelength, to, rng);
            }
            Kind::Volume | Kind::Camera | Kind::Aperture | Kind::DistantCamera => return false,
        };
        self.fly_to(light, w, wavelength, to, rng)
    }
}
