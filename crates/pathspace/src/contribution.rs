//! The measurement contribution f of a complete path (Veach 8.3), one formula whichever end the path was built from.

use ergodic_geometry::phase::{self, Phase};
use ergodic_scattering::{Rgb, luminance};
use glam::DVec2;

use crate::{Path, Scene};

/// f(x) = `rgb` · exp(`ln_scale`) for the mean over the image: with the responsivity of [`ergodic_scattering::Camera`].
///
/// The scale is split off so that the product of many geometry terms neither overflows nor underflows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contribution {
    /// f up to the scale.
    pub rgb: Rgb,
    /// Natural logarithm of the scale.
    pub ln_scale: f64,
}

impl Contribution {
    /// f as a plain number per channel. May overflow to infinity or underflow to 0 for extreme paths.
    pub fn value(&self) -> Rgb {
        self.rgb * self.ln_scale.exp()
    }

    /// ln of the luminance of f; -inf for 0.
    pub fn ln_luminance(&self) -> f64 {
        luminance(self.rgb).ln() + self.ln_scale
    }
}

/// Running products are renormalised when they leave this range, far inside that of f64.
const RENORMALISE: f64 = 1e100;

/// f(x) = Le(x₀→x₁) G(x₀,x₁) Π fs(x_{i-1}→x_i→x_{i+1}) G(x_i,x_{i+1}) · We(x_{k-1}→x_k), visibility taken as given.
#[inline]
pub fn contribution(scene: &Scene, path: &Path) -> Contribution {
    let _phase = phase::enter(Phase::Shading);
    let k = path.length();
    let first = &path.edges[0];
    let last = &path.edges[k - 1];
    let mut rgb = scene.emitted(&path.vertices[0], first.direction)
        * (scene.camera().responsivity(-last.direction) * first.geometry)
        * first.transmittance;
    let mut ln_scale = 0.0;
    for i in 1..k {
        let vertex = &path.vertices[i];
        let edge = &path.edges[i];
        let scattering = vertex.interaction.eval(-path.edges[i - 1].direction, edge.direction, vertex.component);
        rgb *= scattering * edge.transmittance * edge.geometry;
        let size = rgb.max_element();
        if !(1.0 / RENORMALISE..=RENORMALISE).contains(&size) {
            if size <= 0.0 || !size.is_finite() {
                break;
            }
            rgb /= size;
            ln_scale += size.ln();
        }
    }
    Contribution { rgb, ln_scale }
}

/// Where a path meets the image: the raster point of its last edge, if it lies in the camera's domain.
#[inline]
pub fn raster(scene: &Scene, path: &Path) -> Option<DVec2> {
    scene.camera().raster(-path.edges[path.length() - 1].direction)
}
