//! KHR_materials_clearcoat: a dielectric coat of index 1.5 over everything else, with its own roughness and normal.
//!
//! The extension weighs the coat by Schlick's F at the cosine of the eye with the coat's normal, and the base by
//! 1 - weight F, which is not the same both ways. Here, with E the directional albedo of the coat,
//!
//! - the coat's facets reflect by F at their own half vector, as all specular lobes of glTF do;
//! - the base is weighed by 1 - weight max(E(light), E(eye)), as KHR_materials_sheen does it for its layer.
//!
//! For a smooth coat E is F, and where light and eye make the same angle with the normal both are the extension's formula.
//! A coat's lobe scatters by its own cosine with the light, whatever the normal of the base is.
//!
//! A coat lies on both sides of a thin or opaque surface and on the outside of a solid.

use ergodic_geometry::Frame;
use glam::DVec3;

use crate::fresnel::schlick_weight;
use crate::{SELECTION_FLOOR, SMOOTH_ALPHA, dirac, microfacet_reflection, specular_albedo};

/// Reflectance at normal incidence of index 1.5.
const F0: f64 = 0.04;

/// Schlick's reflectance.
#[inline]
fn reflectance(cos: f64) -> f64 {
    F0 + (1.0 - F0) * schlick_weight(cos)
}

/// The albedo E of a coat of weight 1.
#[inline]
fn albedo(cos: f64, alpha: f64) -> f64 {
    if alpha < SMOOTH_ALPHA {
        return reflectance(cos);
    }
    let [whole, grazing] = specular_albedo::schlick(cos, alpha);
    (F0 * whole + (1.0 - F0) * grazing).min(1.0)
}

/// A coat at one point, in the base's shading frame; of weight 0 for none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Coat {
    /// clearcoatFactor.
    weight: f64,
    /// GGX's alpha.
    alpha: f64,
    /// Its own frame; `None` if its normal is the base's.
    frame: Option<Frame>,
    /// Whether it lies on the lower side too.
    both_sides: bool,
}

impl Coat {
    /// A coat with clearcoatFactor, alpha and, where it is not the base's, a normal in the base's frame.
    #[inline]
    pub(crate) fn new(weight: f64, alpha: f64, normal: Option<DVec3>, both_sides: bool) -> Self {
        Self { weight, alpha, frame: normal.map(Frame::from_normal), both_sides }
    }

    /// Whether there is one.
    #[inline]
    pub(crate) fn is_present(&self) -> bool {
        self.weight > 0.0
    }

    /// Whether it is perfectly smooth.
    #[inline]
    pub(crate) fn is_smooth(&self) -> bool {
        self.is_present() && self.alpha < SMOOTH_ALPHA
    }

    /// Whether the side that `w` lies on is coated.
    #[inline]
    pub(crate) fn covers(&self, w: DVec3) -> bool {
        self.is_present() && (self.both_sides || w.z > 0.0)
    }

    /// `w` in the coat's frame; from below everything is turned over, the normal too.
    #[inline]
    fn local(&self, w: DVec3) -> DVec3 {
        let up = if w.z < 0.0 { -w } else { w };
        self.frame.as_ref().map_or(up, |frame| frame.to_local(up))
    }

    /// A direction of the coat's frame in the base's, on the side of `from`; `None` if that is the wrong side.
    #[inline]
    fn out_of(&self, local: DVec3, from: DVec3) -> Option<DVec3> {
        let up = self.frame.as_ref().map_or(local, |frame| frame.to_world(local));
        (up.z > 0.0).then(|| if from.z < 0.0 { -up } else { up })
    }

    /// The share of light along `w` that the coat takes from what is below.
    #[inline]
    pub(crate) fn shadow(&self, w: DVec3) -> f64 {
        if !self.covers(w) {
            return 0.0;
        }
        let cos = self.local(w).z.abs().min(1.0);
        self.weight * albedo(cos, self.alpha)
    }

    /// The weight of choosing the coat for light along `w`; 0 where it reflects nothing.
    #[inline]
    pub(crate) fn selection_weight(&self, w: DVec3) -> f64 {
        if self.covers(w) && self.local(w).z > 0.0 { self.shadow(w).max(SELECTION_FLOOR * self.weight) } else { 0.0 }
    }

    /// The scattering function in 1/sr of a rough coat, times |light·Nc| / |light·Ns|.
    #[inline]
    pub(crate) fn value(&self, light: DVec3, eye: DVec3) -> f64 {
        let (l, e) = (self.local(light), self.local(eye));
        if self.alpha < SMOOTH_ALPHA || !self.covers(eye) || l.z <= 0.0 || e.z <= 0.0 {
            return 0.0;
        }
        let sum = l + e;
        let length = sum.length();
        let lobe = microfacet_reflection::value(self.alpha, l, e, sum / length);
        self.weight * reflectance(0.5 * length) * lobe * (l.z / light.z.abs())
    }

    /// Density in 1/sr of [`Self::sample`] on one side.
    #[inline]
    pub(crate) fn pdf(&self, from: DVec3, to: DVec3) -> f64 {
        let (from, to) = (self.local(from), self.local(to));
        if self.alpha < SMOOTH_ALPHA || from.z <= 0.0 || to.z <= 0.0 {
            return 0.0;
        }
        microfacet_reflection::pdf(self.alpha, from, (from + to).normalize())
    }

    /// A direction that a rough coat reflects `from` to.
    #[inline]
    pub(crate) fn sample(&self, from: DVec3, u: [f64; 2]) -> Option<DVec3> {
        let to = microfacet_reflection::sample(self.alpha, self.local(from), u);
        if to.z > 0.0 { self.out_of(to, from) } else { None }
    }

    /// The share of power that a smooth coat reflects, times |light·Nc| / |light·Ns|.
    #[inline]
    pub(crate) fn mirror_value(&self, light: DVec3, eye: DVec3) -> f64 {
        let (l, e) = (self.local(light), self.local(eye));
        if !self.is_smooth() || !self.covers(eye) || l.z <= 0.0 || e.z <= 0.0 {
            return 0.0;
        }
        self.weight * reflectance(e.z) * (l.z / light.z.abs())
    }

    /// The direction that a smooth coat reflects `from` to.
    #[inline]
    pub(crate) fn mirror(&self, from: DVec3) -> Option<DVec3> {
        if !self.is_smooth() || !self.covers(from) {
            return None;
        }
        let local = self.local(from);
        if local.z > 0.0 { self.out_of(dirac::reflected(local), from) } else { None }
    }

    /// |w·Nc|.
    #[inline]
    pub(crate) fn cosine(&self, w: DVec3) -> f64 {
        self.local(w).z.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_coat_reflects_by_schlick() {
        let coat = Coat::new(0.5, 0.0, None, false);
        assert!((coat.shadow(DVec3::Z) - 0.02).abs() < 1e-12);
        let w = DVec3::new(0.8, 0.0, 0.6);
        assert!((coat.shadow(w) - 0.5 * (0.04 + 0.96 * 0.4_f64.powi(5))).abs() < 1e-12);
        assert_eq!(coat.shadow(-w), 0.0);
        assert_eq!(Coat::new(0.5, 0.0, None, true).shadow(-w), coat.shadow(w));
    }
}
