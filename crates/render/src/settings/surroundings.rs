//! What surrounds a scene, and the units of its lights.

use ergodic_scattering::{Medium, Rgb};
use serde::{Deserialize, Serialize};

/// Light from infinitely far away.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub enum EnvironmentSettings {
    /// The same radiance from every direction: red, green and blue.
    Constant(f64, f64, f64),
    /// A latitude-longitude map.
    Map(EnvironmentMap),
}

/// A latitude-longitude map in a file.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct EnvironmentMap {
    /// A .hdr or .exr file.
    pub file: String,
    /// Degrees by which the map is turned about +y, counter-clockwise as seen from above. Without rotation its middle column shows +x.
    pub rotation: f64,
    /// Factor of its radiance.
    pub strength: f64,
}

impl Default for EnvironmentMap {
    fn default() -> Self {
        Self { file: String::new(), rotation: 0.0, strength: 1.0 }
    }
}

impl EnvironmentSettings {
    pub(super) fn validate(&self) -> Result<(), String> {
        match self {
            Self::Constant(r, g, b) if [r, g, b].iter().any(|c| !(0.0..f64::from(f32::MAX)).contains(*c)) => {
                Err(format!("environment: Constant is ({r}, {g}, {b}); radiance is finite and not negative"))
            }
            Self::Map(map) if map.file.is_empty() => {
                Err("environment: Map has no file; give a .hdr or .exr file".into())
            }
            Self::Map(map) if !(map.strength > 0.0 && map.strength.is_finite()) => {
                Err(format!("environment.strength is {}; it must be a finite number greater than 0", map.strength))
            }
            Self::Map(map) if !map.rotation.is_finite() => {
                Err(format!("environment.rotation is {}; it must be a finite number of degrees", map.rotation))
            }
            _ => Ok(()),
        }
    }
}

/// A homogeneous medium. Coefficients are per unit of length of the file, which in glTF is the metre.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MediumSettings {
    /// Scattering coefficient: red, green and blue.
    pub scattering: (f64, f64, f64),
    /// Absorption coefficient.
    pub absorption: (f64, f64, f64),
    /// Mean cosine of the turn of scattered light, in (-1, 1): 0 to all sides alike, near 1 forward.
    pub anisotropy: f64,
}

impl Default for MediumSettings {
    fn default() -> Self {
        Self { scattering: (0.0, 0.0, 0.0), absorption: (0.0, 0.0, 0.0), anisotropy: 0.0 }
    }
}

impl MediumSettings {
    /// The medium itself.
    pub fn medium(&self) -> Medium {
        let rgb = |(r, g, b): (f64, f64, f64)| Rgb::new(r, g, b);
        let (scattering, absorption) = (rgb(self.scattering), rgb(self.absorption));
        Medium { scattering, absorption, anisotropy: self.anisotropy }
    }

    pub(super) fn validate(&self) -> Result<(), String> {
        for (name, (r, g, b)) in [("scattering", self.scattering), ("absorption", self.absorption)] {
            if [r, g, b].iter().any(|c| !(0.0..f64::from(f32::MAX)).contains(c)) {
                return Err(format!("medium.{name} is ({r}, {g}, {b}); coefficients are finite and not negative"));
            }
        }
        // Nearer to 1 the phase function is a needle that no sampler of lights ever meets.
        if !(-0.999..=0.999).contains(&self.anisotropy) {
            return Err(format!("medium.anisotropy is {}; it must be from -0.999 to 0.999", self.anisotropy));
        }
        Ok(())
    }
}

/// Units of the lights of KHR_lights_punctual. The specification asks for photometric ones, and leaves open how they go with
/// emitting surfaces; most programs that render take the numbers for radiometric ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LightUnits {
    /// Radiant intensity in W/sr and irradiance in W/m²: the units of everything else here.
    Radiometric,
    /// Candela and lux, at 683 lm/W: what Blender's exporter writes in its standard mode.
    Photometric,
    /// The power of point and spot lights in watts, over the whole sphere for spot lights too, and irradiance in W/m²: what
    /// Blender's exporter writes in its raw mode.
    Watts,
}

/// Luminous efficacy of light at 555 nm, in lm/W, which programs use for light of any colour.
const LUMENS_PER_WATT: f64 = 683.0;

impl LightUnits {
    /// What to multiply the intensity of point and spot lights with to get W/sr, and the irradiance of directional lights to
    /// get W/m².
    pub fn to_radiometric(self) -> (f64, f64) {
        match self {
            Self::Radiometric => (1.0, 1.0),
            Self::Photometric => (1.0 / LUMENS_PER_WATT, 1.0 / LUMENS_PER_WATT),
            Self::Watts => (1.0 / (4.0 * std::f64::consts::PI), 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_units_of_blender_agree() {
        // Lights of 40 W, 200 W and 0.5 W/m2 as the exporter of Blender 4.5 writes them in its three modes.
        let modes = [
            (LightUnits::Photometric, [2_174.056_522_635_290_5, 10_870.282_613_176_45, 341.5]),
            (LightUnits::Radiometric, [3.183_098_861_837_907, 15.915_494_309_189_533, 0.5]),
            (LightUnits::Watts, [40.0, 200.0, 0.5]),
        ];
        let pi = std::f64::consts::PI;
        for (units, [point, spot, sun]) in modes {
            let (intensity, irradiance) = units.to_radiometric();
            assert!((point * intensity - 10.0 / pi).abs() < 1e-12, "{units:?}");
            assert!((spot * intensity - 50.0 / pi).abs() < 1e-12, "{units:?}");
            assert!((sun * irradiance - 0.5).abs() < 1e-15, "{units:?}");
        }
    }
}
