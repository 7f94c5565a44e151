//! Cube maps: which way the faces look, and what becomes of their radiance in a latitude-longitude map.

use std::f64::consts::{FRAC_PI_2, PI};

use ergodic_scattering::{CubeMap, Environment, Rgb};
use glam::{DQuat, DVec3};

use crate::support::Random;

/// Texels that a function of face, row and column gives.
fn cube(side: usize, texel: impl Fn(usize, usize, usize) -> [f32; 3]) -> CubeMap {
    let place = |i: usize| (i / (side * side), i / side % side, i % side);
    let texels = (0..6 * side * side).map(place).map(|(face, row, column)| texel(face, row, column)).collect();
    CubeMap::new(side as u32, texels).expect("as many texels as it says")
}

/// The directions of the faces in their order.
const AXES: [DVec3; 6] = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];

fn some_turn() -> DQuat {
    DQuat::from_axis_angle(DVec3::new(0.6, -0.48, 0.64), 1.1)
}

#[test]
fn a_constant_cube_is_a_constant_sky() {
    let color = Rgb::new(0.25, 3.0, 17.5);
    let constant = cube(4, |_, _, _| [0.25, 3.0, 17.5]);
    assert!((constant.mean() - color).abs().max_element() < 1e-13);
    let sky = constant.to_environment(some_turn(), 2.0);
    assert_eq!(sky.size(), (16, 8));
    assert!((sky.mean() - 2.0 * color).abs().max_element() < 1e-5);
    let mut random = Random::new(1);
    for _ in 0..1000 {
        let radiance = sky.radiance(random.direction());
        assert!((radiance - 2.0 * color).abs().max_element() < 1e-5, "{radiance}");
    }
}

#[test]
fn a_bright_face_shines_from_its_direction_however_it_is_turned() {
    for turn in [DQuat::IDENTITY, DQuat::from_rotation_y(FRAC_PI_2), some_turn()] {
        for (bright, axis) in AXES.into_iter().enumerate() {
            let lit = cube(8, |face, _, _| if face == bright { [6.0, 3.0, 1.0] } else { [0.0; 3] });
            // A face is a sixth of the sphere.
            assert!((lit.mean() - Rgb::new(1.0, 0.5, 1.0 / 6.0)).abs().max_element() < 1e-13);
            let sky = lit.to_environment(turn, 1.0);
            assert!((sky.mean() - lit.mean()).abs().max_element() < 1e-6, "{}", sky.mean());
            for (other, direction) in AXES.into_iter().enumerate() {
                let expected = if other == bright { Rgb::new(6.0, 3.0, 1.0) } else { Rgb::ZERO };
                let found = sky.radiance(turn * direction);
                assert!((found - expected).abs().max_element() < 0.02 * 6.0, "{axis} {direction}: {found}");
            }
        }
    }
    // Turned by a quarter about +y, counter-clockwise from above, +x becomes -z.
    let lit = cube(8, |face, _, _| [if face == 0 { 1.0 } else { 0.0 }; 3]);
    let sky = lit.to_environment(DQuat::from_rotation_y(FRAC_PI_2), 1.0);
    assert!(sky.radiance(DVec3::NEG_Z).x > 0.98 && sky.radiance(DVec3::X).x < 0.02);
}

#[test]
fn images_are_upright_and_not_mirrored() {
    // Red grows to the right and green downwards, as a camera at the centre sees the image.
    let graded = cube(16, |_, row, column| [(column as f32 + 0.5) / 16.0, (row as f32 + 0.5) / 16.0, 0.0]);
    for (forward, up) in AXES.into_iter().zip([DVec3::Y, DVec3::Y, DVec3::NEG_Z, DVec3::Z, DVec3::Y, DVec3::Y]) {
        let right = forward.cross(up);
        let sky = graded.to_environment(DQuat::IDENTITY, 1.0);
        for (x, y) in [(0.5, 0.0), (-0.5, 0.25), (0.0, -0.5), (0.7, 0.6)] {
            let w = (forward + x * right + y * up).normalize();
            let expected = Rgb::new(0.5 + 0.5 * x, 0.5 - 0.5 * y, 0.0);
            for found in [graded.radiance(w), sky.radiance(w)] {
                assert!((found - expected).abs().max_element() < 0.06, "{forward} {x} {y}: {found}");
            }
        }
    }
}

/// A single bright texel, in the middle of a face and in the corner of one, keeps its power and its direction: against the mean by
/// another rule, a grid over the sphere.
#[test]
fn a_lone_bright_texel_keeps_its_power() {
    for (row, column) in [(3, 3), (0, 7)] {
        let sun = cube(8, |face, r, c| if (face, r, c) == (5, row, column) { [1000.0; 3] } else { [0.0; 3] });
        let sky = sun.to_environment(some_turn(), 1.0);
        assert!((sky.mean().x / sun.mean().x - 1.0).abs() < 1e-6);
        let vector = |radiance: &dyn Fn(DVec3) -> Rgb| {
            // Even in the polar angle, so that cells near a pole are as small as the others.
            let n = 600;
            let (mut sum, mut total) = (DVec3::ZERO, 0.0);
            for i in 0..n {
                let (radius, y) = (PI * (f64::from(i) + 0.5) / f64::from(n)).sin_cos();
                for j in 0..2 * n {
                    let (sin, cos) = (PI * (f64::from(j) + 0.5) / f64::from(n)).sin_cos();
                    let w = DVec3::new(radius * cos, y, radius * sin);
                    sum += radiance(w).x * radius * w;
                    total += radius;
                }
            }
            sum / total
        };
        let (exact, found) = (vector(&|w| sun.radiance(some_turn().inverse() * w)), vector(&|w| sky.radiance(w)));
        assert!((exact.length() / sun.mean().x - 1.0).abs() < 0.03, "{exact}");
        assert!((found - exact).length() < 0.04 * exact.length(), "{row} {column}: {found} {exact}");
        // One turned the wrong way does not pass.
        let wrong = vector(&|w| sun.radiance(some_turn() * w));
        assert!((found - wrong).length() > 0.3 * exact.length());
    }
}

#[test]
fn what_is_no_cube_is_none() {
    assert!(CubeMap::new(2, vec![[1.0; 3]; 23]).is_none());
    assert!(CubeMap::new(0, Vec::new()).is_none());
    assert!(Environment::resampled(0, 4, 2, |_| Rgb::ONE).is_none());
}
