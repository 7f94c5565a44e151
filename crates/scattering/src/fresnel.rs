//! Fresnel reflectance: Schlick's form for opaque surfaces as glTF has it, the exact one for dielectrics that transmit.

use crate::Rgb;

/// (1 - cos)^5 (Schlick 1994).
#[inline]
pub(crate) fn schlick_weight(cos: f64) -> f64 {
    let m = (1.0 - cos).clamp(0.0, 1.0);
    let m2 = m * m;
    m2 * m2 * m
}

/// Reflectance at normal incidence between media of index ratio `eta`.
#[inline]
pub(crate) fn normal_incidence(eta: f64) -> f64 {
    let r = (1.0 - eta) / (1.0 + eta);
    r * r
}

/// Square of the refracted ray's cosine, negative under total internal reflection; `eta` = n_from / n_to.
///
/// The same as 1 - eta^2 sin^2, but exact near the critical angle, where that cancels.
#[inline]
pub(crate) fn cos_refracted_squared(cos: f64, eta: f64) -> f64 {
    (1.0 - eta) * (1.0 + eta) + eta * eta * cos * cos
}

/// Unpolarised reflectance between media with indices `n_a` and `n_b`, from the cosines of the ray in each. Symmetric.
#[inline]
pub(crate) fn dielectric(cos_a: f64, n_a: f64, cos_b: f64, n_b: f64) -> f64 {
    if n_a == n_b {
        return 0.0;
    }
    let perpendicular = (n_a * cos_a - n_b * cos_b) / (n_a * cos_a + n_b * cos_b);
    let parallel = (n_b * cos_a - n_a * cos_b) / (n_b * cos_a + n_a * cos_b);
    0.5 * (perpendicular * perpendicular + parallel * parallel)
}

/// Reflectance of a dielectric interface with the tints of KHR_materials_specular.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DielectricFresnel {
    /// Reflectance at normal incidence.
    pub f0: Rgb,
    /// Reflectance at grazing incidence.
    pub f90: f64,
    /// Index of refraction of the inside relative to the outside.
    pub ior: f64,
    /// Whether the exact equations shape the curve; otherwise Schlick's.
    pub exact: bool,
}

impl DielectricFresnel {
    /// With KHR_materials_ior and KHR_materials_specular's parameters.
    pub fn new(ior: f64, specular: f64, specular_color: Rgb, exact: bool) -> Self {
        let f0 = (normal_incidence(ior) * specular_color).min(Rgb::ONE) * specular;
        Self { f0, f90: specular, ior, exact }
    }

    /// Whether nothing is ever reflected.
    pub fn is_zero(&self) -> bool {
        (self.f0 == Rgb::ZERO && self.f90 == 0.0) || (self.exact && self.ior == 1.0)
    }

    /// Reflectance for a ray at cosine `cos` > 0 with the facet's normal, inside or outside the dielectric.
    #[inline(always)]
    pub fn at(&self, cos: f64, inside: bool) -> Rgb {
        if !self.exact {
            return self.blend(schlick_weight(cos));
        }
        let (n_from, n_to) = if inside { (self.ior, 1.0) } else { (1.0, self.ior) };
        let cos2 = cos_refracted_squared(cos, n_from / n_to);
        self.remap(if cos2 <= 0.0 { 1.0 } else { dielectric(cos, n_from, cos2.sqrt(), n_to) })
    }

    /// Reflectance for a ray that is refracted, from its cosines outside and inside.
    #[inline]
    pub fn across(&self, cos_outside: f64, cos_inside: f64) -> Rgb {
        self.remap(dielectric(cos_outside, 1.0, cos_inside, self.ior))
    }

    /// Carries the exact reflectance over to [f0, f90].
    #[inline]
    fn remap(&self, exact: f64) -> Rgb {
        if self.ior == 1.0 {
            return Rgb::ZERO;
        }
        let at_normal = normal_incidence(self.ior);
        self.blend((exact - at_normal) / (1.0 - at_normal))
    }

    /// Integral of Schlick's reflectance over a lobe, from that of 1 and that of (1 - cos)^5.
    #[inline]
    pub(crate) fn integrated(&self, [whole, grazing]: [f64; 2]) -> Rgb {
        self.f0 * whole + (self.f90 - self.f0) * grazing
    }

    /// f0 for 0, f90 for 1. An index above 3.7 dips below its value at normal incidence, hence the bound.
    #[inline]
    fn blend(&self, weight: f64) -> Rgb {
        (self.f0 + (self.f90 - self.f0) * weight).max(Rgb::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_give_the_exact_reflectance_and_total_internal_reflection_gives_f90() {
        let glass = DielectricFresnel::new(1.5, 1.0, Rgb::ONE, true);
        assert!((glass.at(1.0, false) - 0.04).abs().max_element() < 1e-12);
        // 60 degrees: r_s = -0.42044, r_p = -0.04243 with n = 1.5 (Hecht, Optics, section 4.6).
        assert!((glass.at(0.5, false).x - 0.089_186).abs() < 1e-5);
        assert_eq!(glass.at(0.5, true), Rgb::ONE);
        let tinted = DielectricFresnel::new(1.5, 0.5, Rgb::new(1.0, 0.5, 0.0), true);
        assert!((tinted.at(1.0, false) - Rgb::new(0.02, 0.01, 0.0)).abs().max_element() < 1e-12);
        assert!((tinted.at(0.1, true) - 0.5).abs().max_element() < 1e-12);
    }

    #[test]
    fn both_sides_agree_and_nothing_breaks_near_the_critical_angle() {
        let glass = DielectricFresnel::new(1.5, 1.0, Rgb::ONE, true);
        for i in 1..=1000 {
            let cos_outside = (f64::from(i) / 1000.0).powi(8);
            let cos_inside = cos_refracted_squared(cos_outside, 1.0 / 1.5).sqrt();
            let outside = glass.at(cos_outside, false).x;
            // The way back from the rounded cosine is ill-conditioned by 1/cos_outside^2.
            let tolerance = 1e-6_f64.min(1e-14 / (cos_outside * cos_outside)).max(1e-12) + 4.0 * 1e-8;
            assert!((glass.at(cos_inside, true).x - outside).abs() < tolerance, "{cos_outside}");
            assert!((glass.across(cos_outside, cos_inside).x - outside).abs() < 1e-12);
        }
        // On the boundary itself.
        let critical = (1.0_f64 - 1.0 / 2.25).sqrt();
        for cos in [critical.next_down(), critical, critical.next_up()] {
            assert!((glass.at(cos, true).x - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn equal_indices_reflect_nothing() {
        let nothing = DielectricFresnel::new(1.0, 1.0, Rgb::ONE, true);
        assert!(nothing.is_zero());
        for cos in [0.0, 1e-9, 0.5, 1.0] {
            assert_eq!(nothing.at(cos, false), Rgb::ZERO);
            assert_eq!(nothing.at(cos, true), Rgb::ZERO);
            assert_eq!(nothing.across(cos, cos), Rgb::ZERO);
        }
    }
}
