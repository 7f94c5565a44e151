//! EXT_lights_image_based: light from infinitely far away, as a cube of images.
//!
//! Only the first level of `specularImages` is read, the radiance itself. The other levels are that of rough reflection and
//! `irradianceCoefficients` that of diffuse reflection, worked out beforehand for programs that do not trace light.
//!
//! The extension asks for images that are "flipped about the vertical axis" against the usual orientation of cube maps, which is
//! left-handed: so they are not mirrored in glTF's right-handed space, as [`CubeMap`] has it. What the numbers times
//! `intensity` mean is radiance, though the text speaks of lux.

use ergodic_scattering::{CubeMap, Environment};
use glam::DQuat;
use image::DynamicImage;
use serde::Deserialize;
use serde_json::Value;

use crate::document::Document;
use crate::error::{Flaw, Trouble};
use crate::warnings::Warnings;
use crate::{hierarchy, limits, texture};

pub(crate) const NAME: &str = "EXT_lights_image_based";

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Light {
    #[serde(default = "one")]
    intensity: f64,
    #[serde(default = "no_rotation")]
    rotation: [f64; 4],
    specular_images: Vec<Vec<usize>>,
    specular_image_size: Option<u32>,
}

fn one() -> f64 {
    1.0
}

fn no_rotation() -> [f64; 4] {
    DQuat::IDENTITY.to_array()
}

/// The light of the scene that is shown, if it has one.
pub(crate) fn read(document: &Document, warnings: &mut Warnings) -> Result<Option<Environment>, Flaw> {
    let root = &document.root;
    let Some(scene) = hierarchy::shown(document)? else { return Ok(None) };
    let reference = root.scenes[scene].extensions.as_ref().and_then(|e| e.others.get(NAME));
    let Some(reference) = reference else { return Ok(None) };
    let place = format!("scenes[{scene}].extensions.{NAME}.light");
    let index = reference.get("light").and_then(Value::as_u64).and_then(|index| usize::try_from(index).ok());
    let index = index.ok_or_else(|| Flaw::malformed(&place, "is not the index of a light"))?;
    let lights = root.extensions.as_ref().and_then(|e| e.others.get(NAME)?.get("lights")?.as_array());
    let lights = lights.map_or(&[][..], Vec::as_slice);
    let light = lights.get(index).ok_or_else(|| Flaw::dangling(place, "lights", index, lights.len()))?;

    let place = format!("extensions.{NAME}.lights[{index}]");
    let light: Light = serde_path_to_error::deserialize(light).map_err(|e| {
        let inner = e.path().to_string();
        let inner = if inner == "." { String::new() } else { format!(".{inner}") };
        Flaw::malformed(format!("{place}{inner}"), e.into_inner().to_string())
    })?;
    if !(light.intensity >= 0.0 && light.intensity.is_finite()) {
        return Err(Flaw::malformed(format!("{place}.intensity"), "is negative or not finite"));
    }
    let rotation = DQuat::from_array(light.rotation);
    if !(rotation.length() > 0.0 && rotation.length().is_finite()) {
        return Err(Flaw::malformed(format!("{place}.rotation"), "is a quaternion of length 0, or is not finite"));
    }
    let environment = cube(document, &light, &place, warnings)?.to_environment(rotation, light.intensity);
    if environment.total_luminance() <= 0.0 {
        warnings.note(NAME, place, "is black and lights nothing");
    }
    Ok(Some(environment))
}

/// The cube of the first level.
fn cube(document: &Document, light: &Light, place: &str, warnings: &mut Warnings) -> Result<CubeMap, Flaw> {
    let place = format!("{place}.specularImages");
    let faces = light.specular_images.first();
    let faces = faces.ok_or_else(|| Flaw::malformed(&place, "is empty; it must have at least one level"))?;
    let place = format!("{place}[0]");
    if faces.len() != 6 {
        return Err(Flaw::malformed(place, format!("has {} images; a cube has 6", faces.len())));
    }
    let (mut side, mut texels) = (0, Vec::new());
    for (i, &index) in faces.iter().enumerate() {
        let image = texture::image(document, index, &format!("{place}[{i}]"))?;
        let place = format!("images[{index}]");
        let (width, height) = (image.width(), image.height());
        if i == 0 {
            side = width;
            let pixels = u64::from(8 * side) * u64::from(side);
            if pixels * 3 * size_of::<f32>() as u64 > limits::IMAGE_BYTES {
                let problem = format!("has {width} x {height} pixels; a face of a cube may have 2048 x 2048 at most");
                return Err(Flaw::new(Trouble::TooLarge, place, problem, "Use smaller images"));
            }
        }
        if (width, height) != (side, side) {
            let problem = format!("has {width} x {height} pixels; all faces of a cube must be squares of one size");
            return Err(Flaw::malformed(place, format!("{problem}, here {side} x {side}")));
        }
        append(&image, &mut texels, &place, warnings);
    }
    if let Some(stated) = light.specular_image_size.filter(|stated| *stated != side) {
        let subject = format!("A specularImageSize of {stated} with images of {side} x {side} pixels");
        warnings.note(subject, &place, "is not used: the images are taken as they are");
    }
    CubeMap::new(side, texels).ok_or_else(|| Flaw::malformed(place, "has no pixels"))
}

/// Adds the radiance of an image: colours in sRGB, divided by alpha where the image has one (RGBD).
fn append(image: &DynamicImage, texels: &mut Vec<[f32; 3]>, place: &str, warnings: &mut Warnings) {
    let has_divisor = image.color().has_alpha();
    for pixel in image.to_rgba8().pixels() {
        let [r, g, b, divisor] = pixel.0;
        let mut divisor = if has_divisor { divisor } else { u8::MAX };
        if divisor == 0 {
            if [r, g, b] != [0; 3] {
                warnings.note("Images of RGBD that divide by 0", place, "are taken to divide by 1/255 there");
            }
            divisor = 1;
        }
        let scale = 255.0 / f64::from(divisor);
        texels.push([r, g, b].map(|byte| (ergodic_scattering::srgb_to_linear(byte) * scale) as f32));
    }
}
