//! The measurement contribution f of a complete path (Veach 8.3), one formula whichever end the path was built from.

use ergodic_geometry::phase::{self, Phase};
use ergodic_metropolis::{Density, renormalisation};
use ergodic_scattering::{Repertoire, Rgb, luminance};

use crate::Path;

/// f(x) = `rgb` · 2^`exponent` for the mean over the image: with the responsivity of [`ergodic_scattering::Camera`].
///
/// The scale is split off so that the product of many geometry terms neither overflows nor underflows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contribution {
    /// f up to the scale.
    pub rgb: Rgb,
    /// Power of two that `rgb` is to be multiplied by.
    pub exponent: i64,
}

impl Contribution {
    /// f as a plain number per channel. May overflow to infinity or underflow to 0 for extreme paths.
    pub fn value(&self) -> Rgb {
        Rgb::from_array(self.rgb.to_array().map(|channel| Density::new(channel).scaled(self.exponent).value()))
    }

    /// The luminance of f.
    pub fn luminance(&self) -> Density {
        Density::new(luminance(self.rgb)).scaled(self.exponent)
    }

    /// ln of the luminance of f; -inf for 0.
    pub fn ln_luminance(&self) -> f64 {
        self.luminance().ln()
    }
}

/// f(x) = R(λ) Le(x₀→x₁) G(x₀,x₁) Π fs(x_{i-1}→x_i→x_{i+1}) G(x_i,x_{i+1}) · We(x_{k-1}→x_k), visibility taken as given: the product of
/// what the path has in [`Path::scattering`] and [`Path::edges`]. R is [`Path::response`], 1 for paths without dispersive interfaces.
#[inline]
pub fn contribution<R: Repertoire>(path: &Path<R>) -> Contribution {
    let _phase = phase::enter(Phase::Shading);
    let k = path.length();
    let mut rgb = path.scattering[k];
    if let Some(response) = path.response() {
        rgb *= response;
    }
    let mut exponent = 0;
    for (scattering, edge) in path.scattering[..k].iter().zip(&path.edges) {
        rgb *= *scattering * edge.transmittance * edge.geometry;
        let size = rgb.max_element();
        if !(size > 0.0 && size.is_finite()) {
            break;
        }
        if let Some((factor, power)) = renormalisation(size) {
            rgb *= factor;
            exponent += power;
        }
    }
    Contribution { rgb, exponent }
}
