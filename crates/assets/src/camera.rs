//! Cameras: perspective and orthographic, and the lens that a perspective one may have in its extras.

use std::f64::consts::PI;

use ergodic_pathspace::Projection;
use ergodic_scattering::Lens;
use gltf::json::camera::{Camera, Type};
use gltf::json::validation::Checked;
use serde::Deserialize;
use serde_json::Value;

use crate::error::Flaw;
use crate::warnings::Warnings;

/// What a camera's `extras` may say of its lens; other keys are other programs' affair.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Extras {
    /// Radius of the aperture in metres; 0 for a pinhole.
    lens_radius: f64,
    /// Distance along the axis of the plane in focus, in metres.
    focus_distance: f64,
    /// Number of blades; 0 for a disk.
    #[serde(default)]
    lens_blades: u32,
    /// Angle of the polygon's first corner in radians, from right towards up.
    #[serde(default)]
    lens_rotation: f64,
}

/// How the camera at `place` sees.
pub(crate) fn projection(
    camera: &Camera,
    extras: Option<&Value>,
    place: &str,
    warnings: &mut Warnings,
) -> Result<Projection, Flaw> {
    match (camera.type_, &camera.perspective, &camera.orthographic) {
        (Checked::Valid(Type::Perspective), Some(perspective), _) => {
            let vertical_fov = f64::from(perspective.yfov);
            if !(vertical_fov > 0.0 && vertical_fov < PI) {
                let problem = format!("is {vertical_fov}; it must lie between 0 and pi");
                return Err(Flaw::malformed(format!("{place}.perspective.yfov"), problem));
            }
            Ok(Projection::Perspective { vertical_fov, lens: lens(extras, place)? })
        }
        (Checked::Valid(Type::Orthographic), _, Some(orthographic)) => {
            let (magnification, near) = (f64::from(orthographic.ymag), f64::from(orthographic.znear));
            if magnification == 0.0 || !magnification.is_finite() {
                let problem = format!("is {magnification}; half the height of the view must not be 0");
                return Err(Flaw::malformed(format!("{place}.orthographic.ymag"), problem));
            }
            if !(near >= 0.0 && near.is_finite()) {
                let problem = format!("is {near}; it must not be negative");
                return Err(Flaw::malformed(format!("{place}.orthographic.znear"), problem));
            }
            if magnification < 0.0 {
                warnings.note("Negative magnifications", place, "are taken as positive: the picture is not mirrored");
            }
            Ok(Projection::Orthographic { height: 2.0 * magnification.abs(), near })
        }
        (Checked::Valid(Type::Perspective), None, _) => {
            Err(Flaw::malformed(place, "is a perspective camera without perspective"))
        }
        (Checked::Valid(Type::Orthographic), _, None) => {
            Err(Flaw::malformed(place, "is an orthographic camera without orthographic"))
        }
        (Checked::Invalid, ..) => Err(Flaw::malformed(format!("{place}.type"), "is not perspective or orthographic")),
    }
}

/// The lens in a camera's extras; `None` if they say nothing of one, or that it is a pinhole.
fn lens(extras: Option<&Value>, place: &str) -> Result<Option<Lens>, Flaw> {
    let Some(extras) = extras.filter(|extras| extras.get("lensRadius").is_some()) else {
        return Ok(None);
    };
    let place = format!("{place}.extras");
    let Extras { lens_radius: radius, focus_distance, lens_blades: blades, lens_rotation: rotation } =
        Extras::deserialize(extras).map_err(|e| Flaw::malformed(&place, format!("states no lens: {e}")))?;
    let lens = Lens { radius, focus_distance, blades, rotation };
    lens.check().map_err(|(field, problem)| {
        let key = match field {
            "radius" => "lensRadius",
            "focus_distance" => "focusDistance",
            "blades" => "lensBlades",
            _ => "lensRotation",
        };
        Flaw::malformed(format!("{place}.{key}"), problem)
    })?;
    Ok((radius > 0.0).then_some(lens))
}
