//! What some materials change in glTF's layered surface, as a type parameter: the others do not pay for it.

use crate::Rgb;
use crate::fresnel::{self, DielectricFresnel};
use crate::thin_film::ThinFilm;

/// What changes the lobes of a [`Layered`](crate::Layered) surface. The defaults change nothing.
pub trait Effects: Copy {
    /// Whether there can be diffuse transmission; without it no code for it is made.
    const TRANSLUCENT: bool = false;

    /// Whether the surface reflects even where its Fresnel reflectance is zero.
    #[inline]
    fn has_film(&self) -> bool {
        false
    }

    /// Reflectance of the dielectric for a ray at cosine `cos` with its facet.
    #[inline(always)]
    fn dielectric(&self, fresnel: &DielectricFresnel, cos: f64, inside: bool) -> Rgb {
        fresnel.at(cos, inside)
    }

    /// Reflectance of the dielectric for a ray that is refracted.
    #[inline]
    fn across(&self, fresnel: &DielectricFresnel, cos_outside: f64, cos_inside: f64) -> Rgb {
        fresnel.across(cos_outside, cos_inside)
    }

    /// Reflectance of the metal whose reflectance at normal incidence is `f0`.
    #[inline]
    fn conductor(&self, f0: Rgb, cos: f64) -> Rgb {
        f0.lerp(Rgb::ONE, fresnel::schlick_weight(cos))
    }

    /// The share of the diffuse light that is transmitted, and its colour (KHR_materials_diffuse_transmission).
    #[inline]
    fn diffuse_transmission(&self) -> (f64, Rgb) {
        (0.0, Rgb::ZERO)
    }
}

/// No effects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plain;

impl Effects for Plain {}

/// A thin film and diffuse transmission; either may be without effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FilmAndTranslucency {
    /// The film.
    pub film: ThinFilm,
    /// Share of the diffuse light that is transmitted.
    pub translucency: f64,
    /// Its colour.
    pub translucent_color: Rgb,
}

impl Effects for FilmAndTranslucency {
    const TRANSLUCENT: bool = true;

    #[inline]
    fn has_film(&self) -> bool {
        self.film.strength > 0.0
    }

    #[inline]
    fn dielectric(&self, fresnel: &DielectricFresnel, cos: f64, inside: bool) -> Rgb {
        let plain = fresnel.at(cos, inside);
        if !self.has_film() {
            return plain;
        }
        if !(inside && fresnel.exact) {
            return self.film.over(plain, fresnel.f0, cos);
        }
        // A film without absorption reflects the same share of the light that meets it from below along the same ray.
        let cos2 = fresnel::cos_refracted_squared(cos, fresnel.ior);
        if cos2 <= 0.0 { plain } else { self.film.over(plain, fresnel.f0, cos2.sqrt()) }
    }

    #[inline]
    fn across(&self, fresnel: &DielectricFresnel, cos_outside: f64, cos_inside: f64) -> Rgb {
        let plain = fresnel.across(cos_outside, cos_inside);
        if self.has_film() { self.film.over(plain, fresnel.f0, cos_outside) } else { plain }
    }

    #[inline]
    fn conductor(&self, f0: Rgb, cos: f64) -> Rgb {
        let plain = f0.lerp(Rgb::ONE, fresnel::schlick_weight(cos));
        if self.has_film() { self.film.over(plain, f0, cos) } else { plain }
    }

    #[inline]
    fn diffuse_transmission(&self) -> (f64, Rgb) {
        (self.translucency, self.translucent_color)
    }
}
