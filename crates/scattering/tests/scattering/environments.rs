//! Environments: orientation, sampler against density, and densities that are the radiance.

use std::f64::consts::PI;

use ergodic_scattering::{Environment, Rgb, luminance};
use glam::DVec3;

use crate::support::{Outcome, Random, Rings, chi_square_directions};

/// Texels that a function of row and column gives.
fn map(width: u32, height: u32, rotation: f64, texel: impl Fn(u32, u32) -> [f32; 3]) -> Environment {
    let texels = (0..height).flat_map(|j| (0..width).map(move |i| (j, i))).flat_map(|(j, i)| texel(j, i)).collect();
    Environment::map(width, height, texels, 1.0, rotation).expect("as many texels as it says")
}

/// A sky, dark ground, and some texels that are black or far brighter than others.
fn uneven(width: u32, height: u32, rotation: f64) -> Environment {
    map(width, height, rotation, |j, i| match (j * 31 + i * 17) % 11 {
        0 => [0.0; 3],
        1 => [40.0, 30.0, 20.0],
        k => [0.1 * k as f32, 0.2, 1.0 / (1.0 + j as f32)],
    })
}

fn all() -> Vec<Environment> {
    vec![
        Environment::constant(Rgb::new(0.5, 1.0, 2.0)),
        map(1, 1, 30.0, |_, _| [1.0, 2.0, 3.0]),
        uneven(2, 1, 0.0),
        uneven(1, 5, 0.0),
        uneven(8, 4, 0.0),
        uneven(37, 9, 67.0),
        // The bright row is at the pole, where directions are rare.
        map(16, 8, 0.0, |j, _| if j == 0 { [100.0; 3] } else { [1.0; 3] }),
        // All black but one texel.
        map(40, 20, 200.0, |j, i| if (j, i) == (13, 0) { [0.0, 0.0, 1.0] } else { [0.0; 3] }),
    ]
}

fn pdf(environment: &Environment, w: DVec3) -> f64 {
    environment.pdf_solid_angle(environment.radiance(w))
}

/// Rings about an axis along nothing, so that no cell is symmetric to the map.
fn rings() -> Rings {
    Rings::new(DVec3::new(0.48, -0.36, 0.8), 0.3, 16, 12)
}

#[test]
fn the_density_is_the_luminance_of_the_radiance_over_its_integral() {
    for environment in all() {
        // A midpoint rule in y and azimuth, whose product is solid angle.
        let n = 1500;
        let (mut integral, mut mean) = (0.0, Rgb::ZERO);
        for i in 0..n {
            let y = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(n);
            for j in 0..n {
                let phi = 2.0 * PI * (f64::from(j) + 0.5) / f64::from(n);
                let r = (1.0 - y * y).sqrt();
                let radiance = environment.radiance(DVec3::new(r * phi.cos(), y, r * phi.sin()));
                integral += environment.pdf_solid_angle(radiance);
                mean += radiance;
            }
        }
        let cells = f64::from(n) * f64::from(n);
        let integral = integral * 4.0 * PI / cells;
        assert!((integral - 1.0).abs() < 2e-3, "{:?}: {integral}", environment.size());
        let mean = mean / cells;
        assert!((mean - environment.mean()).abs().max_element() < 2e-3 * environment.mean().max_element());
        assert!((luminance(environment.mean()) * 4.0 * PI / environment.total_luminance() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn environments_sample_their_density() {
    for environment in all() {
        let mut random = Random::new(3);
        let mut sample = || Outcome::Direction(environment.sample(random.three()));
        let density = |w: DVec3| pdf(&environment, w);
        let missing = chi_square_directions(&rings(), 200_000, &density, &[], &mut sample);
        let missing = missing.unwrap_or_else(|e| panic!("{:?}: {e}", environment.size()));
        assert!(missing.abs() < 5e-3, "{:?}: {missing}", environment.size());
    }
}

/// The usual mistake: texels weighed by their luminance alone, as if those at the poles were as large as the others. The
/// density that belongs to it has sin θ below.
#[test]
fn a_forgotten_sine_is_caught() {
    for environment in [uneven(37, 9, 67.0), map(16, 8, 0.0, |_, _| [1.0; 3])] {
        let mut random = Random::new(4);
        let mut sample = || Outcome::Direction(environment.sample(random.three()));
        let faulty = |w: DVec3| pdf(&environment, w) * 2.0 / PI / (1.0 - w.y * w.y).sqrt();
        assert!(chi_square_directions(&rings(), 200_000, &faulty, &[], &mut sample).is_err());
        // Nor does a map that is turned the other way pass.
        let mirrored = |w: DVec3| pdf(&environment, DVec3::new(w.x, w.y, -w.z));
        let is_even = environment.size().0 == 16;
        assert_eq!(chi_square_directions(&rings(), 200_000, &mirrored, &[], &mut sample).is_ok(), is_even);
    }
}

#[test]
fn what_is_sampled_is_never_black() {
    for environment in all() {
        let mut random = Random::new(5);
        // The ends of the intervals too, where rounding is likeliest to lead off a tent.
        let ends = [0.0, 1.0 - f64::EPSILON / 2.0, 0.5, 0.5 - f64::EPSILON / 4.0];
        let corners = (0..64).map(|i| [ends[i & 3], ends[i >> 2 & 3], ends[i >> 4 & 3]]);
        let inner = (0..20_000).map(|_| random.three());
        for u in corners.chain(inner) {
            let w = environment.sample(u);
            assert!((w.length() - 1.0).abs() < 1e-14 && pdf(&environment, w) > 0.0, "{:?} {u:?}", environment.size());
        }
    }
}

#[test]
fn columns_and_rows_look_where_they_are_said_to() {
    // Red in the middle column, green a quarter to the right, blue at the edges, white above.
    let colours = |j: u32, i: u32| match (j, i) {
        (0, _) => [1.0, 1.0, 1.0],
        (_, 0 | 15) => [0.0, 0.0, 1.0],
        (_, 7 | 8) => [1.0, 0.0, 0.0],
        (_, 11 | 12) => [0.0, 1.0, 0.0],
        _ => [0.0; 3],
    };
    let plain = map(16, 8, 0.0, colours);
    assert_eq!(plain.radiance(DVec3::X), Rgb::X);
    assert_eq!(plain.radiance(DVec3::Z), Rgb::Y);
    assert_eq!(plain.radiance(DVec3::NEG_X), Rgb::Z);
    assert_eq!(plain.radiance(DVec3::NEG_Z), Rgb::ZERO);
    assert_eq!(plain.radiance(DVec3::Y), Rgb::ONE);
    let turned = map(16, 8, 90.0, colours);
    assert!((turned.radiance(DVec3::NEG_Z) - Rgb::X).abs().max_element() < 1e-12);
    assert!((turned.radiance(DVec3::X) - Rgb::Y).abs().max_element() < 1e-12);
    assert!((turned.radiance(DVec3::Z) - Rgb::Z).abs().max_element() < 1e-12);
}

#[test]
fn strength_multiplies_radiance_and_leaves_the_density() {
    let texels = vec![1.0, 2.0, 3.0, 0.5, 0.0, 0.25];
    let once = Environment::map(2, 1, texels.clone(), 1.0, 0.0).unwrap();
    let thrice = Environment::map(2, 1, texels.clone(), 3.0, 0.0).unwrap();
    let w = DVec3::new(0.6, 0.48, 0.64);
    assert!((thrice.radiance(w) - 3.0 * once.radiance(w)).abs().max_element() < 1e-15);
    assert!((pdf(&thrice, w) / pdf(&once, w) - 1.0).abs() < 1e-14);
    assert!((thrice.total_luminance() / once.total_luminance() - 3.0).abs() < 1e-14);
    assert!(Environment::map(3, 1, texels, 1.0, 0.0).is_none(), "the number of texels is wrong");
}
