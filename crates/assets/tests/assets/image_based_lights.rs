//! EXT_lights_image_based: cubes of images become environments, and what is wrong with them is named.

use std::f64::consts::FRAC_PI_2;

use ergodic_assets::Trouble;
use ergodic_scattering::Rgb;
use glam::DVec3;
use image::{DynamicImage, ImageFormat, Rgb as Pixel, RgbImage, Rgba, RgbaImage};
use serde_json::{Value, json};

use crate::support::{Buffer, TRIANGLE, load, try_load};

const NAME: &str = "EXT_lights_image_based";

fn encoded(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.into().write_to(&mut bytes, format).expect("an image into memory");
    bytes.into_inner()
}

/// A square of one colour with a divisor.
fn rgbd(side: u32, texel: [u8; 4]) -> Vec<u8> {
    encoded(RgbaImage::from_pixel(side, side, Rgba(texel)), ImageFormat::Png)
}

/// A square of one colour.
fn plain(side: u32, texel: [u8; 3], format: ImageFormat) -> Vec<u8> {
    encoded(RgbImage::from_pixel(side, side, Pixel(texel)), format)
}

/// A triangle under a cube of six images.
fn lit(faces: &[Vec<u8>]) -> Value {
    let mut buffer = Buffer::default();
    buffer.floats(&TRIANGLE);
    let views: Vec<usize> = faces.iter().map(|face| buffer.push(face)).collect();
    let images: Vec<Value> = views.iter().map(|view| json!({"bufferView": view, "mimeType": "image/png"})).collect();
    let all: Vec<usize> = (0..faces.len()).collect();
    buffer.finish(json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": [NAME],
        "extensionsRequired": [NAME],
        "extensions": {NAME: {"lights": [{
            "irradianceCoefficients": vec![[0.0; 3]; 9],
            "specularImageSize": 4,
            "specularImages": [all],
        }]}},
        "scene": 0,
        "scenes": [{"nodes": [0], "extensions": {NAME: {"light": 0}}}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "images": images,
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
    }))
}

fn grey() -> Value {
    lit(&vec![plain(4, [128; 3], ImageFormat::Png); 6])
}

/// The only light of a file.
fn light(file: &mut Value) -> &mut Value {
    &mut file["extensions"][NAME]["lights"][0]
}

#[test]
fn six_images_are_an_environment() {
    // 188 of sRGB is 0.5029 (IEC 61966-2-1).
    let half = ((188.0 / 255.0 + 0.055) / 1.055_f64).powf(2.4);
    let kinds = [
        (plain(4, [188; 3], ImageFormat::Png), half, 1e-6),
        (plain(4, [188; 3], ImageFormat::Jpeg), half, 0.01),
        (rgbd(4, [188, 188, 188, 255]), half, 1e-6),
        (rgbd(4, [188, 188, 188, 17]), 15.0 * half, 1e-5),
    ];
    for (i, (image, radiance, tolerance)) in kinds.into_iter().enumerate() {
        let mut file = lit(&vec![image; 6]);
        light(&mut file)["intensity"] = json!(2.0);
        let asset = load(&file);
        assert!(asset.warnings.is_empty() && asset.notes.is_empty(), "{:?}", asset.warnings);
        let mean = asset.description.environment.expect("an environment").mean();
        assert!((mean - Rgb::splat(2.0 * radiance)).abs().max_element() < 2.0 * tolerance, "{i}: {mean}");
    }
}

#[test]
fn faces_have_their_order_and_turn() {
    let mut faces = vec![plain(8, [0; 3], ImageFormat::Png); 6];
    faces[0] = plain(8, [255, 0, 0], ImageFormat::Png);
    faces[3] = plain(8, [0, 255, 0], ImageFormat::Png);
    let mut file = lit(&faces);
    light(&mut file)["specularImageSize"] = json!(8);
    let sky = load(&file).description.environment.expect("an environment");
    let close = |a: Rgb, b: Rgb| (a - b).abs().max_element() < 0.02;
    assert!(close(sky.radiance(DVec3::X), Rgb::X) && close(sky.radiance(DVec3::NEG_Y), Rgb::Y));
    assert!(close(sky.radiance(DVec3::NEG_Z), Rgb::ZERO));
    // A quarter about +y; the quaternion need not have length 1.
    let (sin, cos) = (FRAC_PI_2 / 2.0).sin_cos();
    light(&mut file)["rotation"] = json!([0.0, 3.0 * sin, 0.0, 3.0 * cos]);
    let turned = load(&file).description.environment.expect("an environment");
    assert!(close(turned.radiance(DVec3::NEG_Z), Rgb::X) && close(turned.radiance(DVec3::NEG_Y), Rgb::Y));
    assert!(close(turned.radiance(DVec3::X), Rgb::ZERO));
}

#[test]
fn a_light_that_no_scene_has_lights_nothing() {
    let mut file = grey();
    file["scenes"][0] = json!({"nodes": [0]});
    assert!(load(&file).description.environment.is_none());
    // Nor has that of another scene than the one that is shown.
    let mut file = grey();
    let lit = file["scenes"][0].clone();
    file["scenes"] = json!([{"nodes": [0]}, lit]);
    assert!(load(&file).description.environment.is_none());
    file["scene"] = json!(1);
    assert!(load(&file).description.environment.is_some());
}

#[test]
fn oddities_are_warned_of() {
    let mut file = grey();
    light(&mut file)["specularImageSize"] = json!(256);
    let warnings = load(&file).warnings;
    assert!(warnings.len() == 1 && warnings[0].contains("specularImageSize of 256"), "{warnings:?}");
    let asset = load(&lit(&vec![rgbd(4, [255, 255, 255, 0]); 6]));
    let mean = asset.description.environment.expect("an environment").mean();
    assert!(asset.warnings.len() == 1 && asset.warnings[0].contains("RGBD"), "{:?}", asset.warnings);
    assert!((mean / 255.0 - 1.0).abs().max_element() < 1e-5, "{mean}");
    let black = load(&lit(&vec![plain(4, [0; 3], ImageFormat::Png); 6]));
    assert!(black.warnings.iter().any(|warning| warning.contains("lights nothing")), "{:?}", black.warnings);
}

#[test]
fn what_is_wrong_is_named() {
    let place = "extensions.EXT_lights_image_based.lights[0]";
    type Change = fn(&mut Value);
    let cases: [(Change, &str, &str); 14] = [
        (|f| f["scenes"][0]["extensions"][NAME]["light"] = json!(7), "scenes[0].extensions", "lights[7]"),
        (|f| f["scenes"][0]["extensions"][NAME]["light"] = json!(-1), "scenes[0].extensions", "index of a light"),
        (|f| f["scenes"][0]["extensions"][NAME] = json!({}), "scenes[0].extensions", "index of a light"),
        (|f| f["extensions"][NAME] = json!({}), "scenes[0].extensions", "has 0 lights"),
        (|f| light(f)["intensity"] = json!(-1), ".intensity", "negative"),
        (|f| light(f)["intensity"] = json!("bright"), ".intensity", "string"),
        (|f| light(f)["rotation"] = json!([0, 0, 0, 0]), ".rotation", "length 0"),
        (|f| light(f)["rotation"] = json!([0, 0, 1]), ".rotation", "length"),
        (|f| light(f)["specularImages"] = json!([]), ".specularImages", "at least one level"),
        (|f| light(f)["specularImages"] = json!([[0, 1, 2, 3, 4]]), ".specularImages[0]", "5 images"),
        (|f| light(f)["specularImages"] = json!([[0, 1, 2, 3, 4, 99]]), ".specularImages[0][5]", "images[99]"),
        (|f| light(f)["specularImages"] = json!([[0, 1, 2, 3, 4, -5]]), ".specularImages[0][5]", "-5"),
        (|f| drop(light(f).as_object_mut().expect("an object").remove("specularImages")), "", "specularImages"),
        (|f| f["images"][2] = json!({"uri": "data:image/png;base64,AAAA"}), "images[2]", "cannot be decoded"),
    ];
    for (i, (change, where_, what)) in cases.into_iter().enumerate() {
        let mut file = grey();
        change(&mut file);
        let error = try_load(&file).expect_err("a broken light");
        assert!(error.trouble == Trouble::Malformed && !error.mend.is_empty(), "{i}: {error}");
        assert!(error.place.contains(where_) && error.problem.contains(what), "{i}: {error}");
        let at_light = where_.starts_with('.') || where_.is_empty();
        assert!(!at_light || error.place.starts_with(place), "{i}: {error}");
    }
    // Faces of several sizes, or not square.
    let mut faces = vec![plain(4, [128; 3], ImageFormat::Png); 6];
    faces[4] = plain(2, [128; 3], ImageFormat::Png);
    let error = try_load(&lit(&faces)).expect_err("faces of two sizes");
    assert!(error.place == "images[4]" && error.problem.contains("2 x 2"), "{error}");
    faces[0] = encoded(RgbImage::from_pixel(4, 3, Pixel([9; 3])), ImageFormat::Png);
    let error = try_load(&lit(&faces)).expect_err("a face that is no square");
    assert!(error.place == "images[0]" && error.problem.contains("4 x 3"), "{error}");
    // More than a map may have.
    let wide = plain(2400, [1; 3], ImageFormat::Png);
    let error = try_load(&lit(&vec![wide; 6])).expect_err("a face that is too large");
    assert!(error.trouble == Trouble::TooLarge && error.place == "images[0]", "{error}");
}
