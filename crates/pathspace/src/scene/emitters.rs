//! The light ends of paths: points on emitters, their densities, and what leaves them.

use super::*;

impl<R: Repertoire> Scene<R> {
    /// Makes `light` a point on a light or a direction of the environment, with density [`Self::emitter_pdf_area`].
    #[inline]
    pub fn sample_emitter(&self, wavelength: Wavelength, light: &mut Vertex<R>, rng: &mut impl RandomSource) {
        match self.parts.lights.choose(rng) {
            Emitter::Punctual(index) if R::OTHER_LIGHTS => *light = self.punctual_vertex(index),
            Emitter::Environment if R::OTHER_LIGHTS => match &self.parts.environment {
                Some(environment) => {
                    let w = environment.sample([rng.uniform(), rng.uniform(), rng.uniform()]);
                    *light = self.environment_vertex(-w, environment.radiance(w));
                }
                None => unreachable!("an environment was chosen where there is none"),
            },
            Emitter::Triangle { instance, triangle } => {
                let (u, v) = warp::uniform_triangle([rng.uniform(), rng.uniform()]);
                self.place(&Hit { instance, triangle, u, v, t: 0.0 }, wavelength, light);
                if self.has_media() {
                    light.medium = self.parts.media.around(&self.parts.world, light.position, Some(instance));
                }
            }
            Emitter::Punctual(_) | Emitter::Environment => unreachable!("a light that the scene's repertoire lacks"),
        }
    }

    /// Area density of a light vertex; density per solid angle of the environment; the probability of the light for one without
    /// extent; 0 where nothing emits.
    #[inline]
    pub fn emitter_pdf_area(&self, vertex: &Vertex<R>) -> f64 {
        match vertex.kind {
            Kind::Surface if vertex.emits() => self.parts.lights.triangle_pdf_area(vertex.emitter),
            Kind::PointLight(index) | Kind::DistantLight(index) if R::OTHER_LIGHTS => {
                self.parts.lights.punctual_probability(index)
            }
            Kind::Environment if R::OTHER_LIGHTS => self.environment_pdf(vertex.emission),
            _ => 0.0,
        }
    }

    /// Emitted radiance (surface, environment), radiant intensity (point light) or irradiance (distant light) in direction `w`.
    #[inline]
    pub fn emitted(&self, vertex: &Vertex<R>, w: DVec3) -> Rgb {
        match vertex.kind {
            Kind::Surface if vertex.emits() => {
                let radiance = emission::emitted(vertex.emission, self.double_sided(vertex), vertex.interaction.ng, w);
                radiance * vertex.interaction.emission_factor(w)
            }
            Kind::PointLight(index) | Kind::DistantLight(index) if R::OTHER_LIGHTS => {
                self.parts.lights.punctual[index as usize].emitted(w)
            }
            Kind::Environment if R::OTHER_LIGHTS => vertex.emission,
            _ => Rgb::ZERO,
        }
    }

    /// Density per solid angle of a direction of the environment from which `radiance` comes, its choice among lights included.
    pub(super) fn environment_pdf(&self, radiance: Rgb) -> f64 {
        let pdf = self.parts.environment.as_ref().map_or(0.0, |environment| environment.pdf_solid_angle(radiance));
        self.parts.lights.environment_probability() * pdf
    }

    pub(super) fn double_sided(&self, vertex: &Vertex<R>) -> bool {
        self.parts.materials[vertex.material as usize].double_sided
    }

    /// Solid-angle density of the emitted direction `w`; for a distant light and the environment, whose direction is known
    /// already, the area density on their disk, which is perpendicular to it and as large as the scene's bounding sphere.
    #[inline]
    pub fn emission_pdf(&self, vertex: &Vertex<R>, w: DVec3) -> f64 {
        match vertex.kind {
            Kind::Surface if vertex.emits() => {
                emission::pdf_direction(self.double_sided(vertex), vertex.interaction.ng, w)
            }
            Kind::PointLight(index) if R::OTHER_LIGHTS => self.parts.lights.punctual[index as usize].pdf_direction(w),
            Kind::DistantLight(_) | Kind::Environment if R::OTHER_LIGHTS => {
                1.0 / (std::f64::consts::PI * self.parts.radius * self.parts.radius)
            }
            _ => 0.0,
        }
    }

    /// Makes `to` the next vertex of a light subpath that starts at `light`, with density [`Self::emission_pdf`]; false if there is
    /// none.
    #[inline]
    pub fn sample_emission(
        &self,
        light: &Vertex<R>,
        wavelength: Wavelength,
        to: &mut Vertex<R>,
        rng: &mut impl RandomSource,
    ) -> bool {
        let u = [rng.uniform(), rng.uniform()];
        let w = match light.kind {
            Kind::Surface => emission::sample_direction(self.double_sided(light), light.interaction.ng, u),
            Kind::PointLight(index) if R::OTHER_LIGHTS => {
                self.parts.lights.punctual[index as usize].sample_direction(u)
            }
            Kind::DistantLight(_) | Kind::Environment if R::OTHER_LIGHTS => {
                let direction = light.interaction.ng;
                let frame = ergodic_geometry::Frame::from_normal(direction);
                let DVec2 { x, y } = warp::concentric_disk(u) * self.parts.radius;
                let through = frame.t * x + frame.b * y + self.centre();
                return self.fly_parallel(direction, through, wavelength, to, rng);
            }
            _ => return false,
        };
        self.fly_to(light, w, wavelength, to, rng)
    }
}
