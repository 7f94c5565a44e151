//! The file's unit of length and its origin do not matter.

use ergodic_pathspace::SceneDescription;
use ergodic_render::{Budget, Method, Settings, Unobserved, render};
use ergodic_scattering::{PunctualLight, Rgb};
use ergodic_tests::{description, view_of};
use glam::{DAffine3, DMat3, DVec3};

const SIZE: (u32, u32) = (32, 32);

/// The same scene in another unit of length, moved.
pub(super) fn in_units(mut scene: SceneDescription, scale: f64, offset: DVec3) -> SceneDescription {
    let change = DAffine3 { matrix3: DMat3::from_diagonal(DVec3::splat(scale)), translation: offset * scale };
    for placement in &mut scene.placements {
        placement.transform = change * placement.transform;
    }
    for camera in &mut scene.cameras {
        camera.transform.translation = change.transform_point3(camera.transform.translation);
    }
    for material in &mut scene.materials {
        material.absorption /= scale;
    }
    for light in &mut scene.lights {
        if let PunctualLight::Point { position, intensity } | PunctualLight::Spot { position, intensity, .. } = light {
            *position = change.transform_point3(*position);
            *intensity *= scale * scale;
        }
    }
    scene
}

/// A point light in a corner of the room, so that intensities are tested too.
fn with_point_light(name: &str) -> SceneDescription {
    let mut scene = description(name);
    let (low, high) = scene.bounds().expect("the scenes have triangles");
    let position = low + (high - low) * DVec3::new(0.3, 0.8, 0.6);
    scene.lights.push(PunctualLight::Point { position, intensity: Rgb::splat((high - low).length_squared()) });
    scene
}

fn picture(scene: SceneDescription, method: Method) -> Vec<Rgb> {
    let settings = Settings { method, size: SIZE, budget: Budget::SamplesPerPixel(16.0), ..Settings::default() };
    render(&view_of(scene, SIZE), &settings, &Unobserved).expect("valid settings").picture.pixels
}

/// The share of pixels that differ by more than `tolerance` of the picture's mean.
fn share_that_differs(a: &[Rgb], b: &[Rgb], tolerance: f64) -> f64 {
    let mean = a.iter().map(|p| p.element_sum()).sum::<f64>() / a.len() as f64;
    let differs = a.iter().zip(b).filter(|(a, b)| (**a - **b).abs().element_sum() > tolerance * mean);
    differs.count() as f64 / a.len() as f64
}

#[test]
fn the_unit_of_length_and_the_origin_do_not_matter() {
    for name in ["cornell", "glass", "pool"] {
        for method in [Method::Path, Method::Bidirectional] {
            let expected = picture(with_point_light(name), method);
            for (scale, offset) in [
                (1e-4, DVec3::ZERO),
                (1e-2, DVec3::new(30.0, -20.0, 10.0)),
                (1e2, DVec3::new(-50.0, 0.0, 70.0)),
                (1e4, DVec3::ZERO),
            ] {
                let found = picture(in_units(with_point_light(name), scale, offset), method);
                // A sample in many thousands takes another turn, where rounding decides at an edge.
                let share = share_that_differs(&expected, &found, 1e-6);
                println!("{name} {method:?}, scale {scale}, moved by {offset}: {share} of the pixels differ");
                assert!(share < 0.02, "{name} {method:?}, scale {scale}, moved by {offset}: {share}");
            }
            // The measure can fail: light that does not scale with the scene is another picture.
            let mut brighter = in_units(with_point_light(name), 1e2, DVec3::ZERO);
            if let Some(PunctualLight::Point { intensity, .. }) = brighter.lights.last_mut() {
                *intensity *= 1.001;
            }
            assert!(share_that_differs(&expected, &picture(brighter, method), 1e-6) > 0.2, "{name} {method:?}");
        }
    }
}

#[test]
fn metropolis_light_transport_does_not_depend_on_the_unit_either() {
    // A power of two rounds nothing, so even a chain takes the same steps.
    let expected = picture(with_point_light("glass"), Method::Mlt);
    for scale in [1.0 / 8192.0, 8192.0] {
        assert_eq!(picture(in_units(with_point_light("glass"), scale, DVec3::ZERO), Method::Mlt), expected, "{scale}");
    }
}
