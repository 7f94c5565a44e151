//! The units that lights are stated in.

use ergodic_assets::Asset;
use ergodic_scattering::{PunctualLight, Rgb};
use serde_json::json;

use crate::support::{load, triangle};

/// A file as a program writes it, with a point light, a spot light and a directional light.
fn lit(generator: &str, [point, spot, sun]: [f64; 3]) -> Asset {
    let mut file = triangle();
    file["asset"]["generator"] = generator.into();
    file["extensions"]["KHR_lights_punctual"]["lights"] = json!([
        {"type": "point", "intensity": point},
        {"type": "spot", "intensity": spot, "spot": {}},
        {"type": "directional", "intensity": sun, "color": [1, 0.5, 0]},
    ]);
    let node = |light: usize| json!({"extensions": {"KHR_lights_punctual": {"light": light}}});
    file["nodes"] = json!([node(0), node(1), node(2), {"mesh": 0}]);
    file["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    load(&file)
}

const BLENDER: &str = "Khronos glTF Blender I/O v4.5.51";
/// Lights of 40 W, 200 W and 0.5 W/m2 as Blender 4.5 exports them in its standard mode and without units.
const STANDARD: [f64; 3] = [2_174.056_522_635_290_5, 10_870.282_613_176_45, 341.5];
const UNITLESS: [f64; 3] = [3.183_098_861_837_907, 15.915_494_309_189_533, 0.5];

#[test]
fn lights_are_scaled_by_kind() {
    let mut asset = lit(BLENDER, STANDARD);
    asset.scale_lights(0.5, 0.25);
    let [
        PunctualLight::Point { intensity: point, .. },
        PunctualLight::Spot { intensity: spot, .. },
        PunctualLight::Directional { irradiance, .. },
    ] = asset.description.lights[..]
    else {
        panic!("{:?}", asset.description.lights)
    };
    let close = |a: Rgb, b: Rgb| assert!((a - b).length() <= 1e-6 * b.length(), "{a} is not {b}");
    close(point, Rgb::splat(0.5 * STANDARD[0]));
    close(spot, Rgb::splat(0.5 * STANDARD[1]));
    close(irradiance, 0.25 * STANDARD[2] * Rgb::new(1.0, 0.5, 0.0));
}

#[test]
fn a_hint_comes_with_what_looks_like_photometric_units_of_blender() {
    let hint = |generator: &str, lights: [f64; 3]| lit(generator, lights).light_units_hint();
    let said = hint(BLENDER, STANDARD).unwrap();
    assert!(said.contains("light_units"), "{said}");
    assert!(hint(BLENDER, [1.0, 1.0, STANDARD[2]]).is_some());
    assert_eq!(hint(BLENDER, UNITLESS), None);
    assert_eq!(hint("another program", STANDARD), None);
}
