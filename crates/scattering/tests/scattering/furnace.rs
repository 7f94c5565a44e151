//! White furnaces over a grid of roughness, index and angle: which surfaces conserve energy, and how much the others gain.

use std::f64::consts::PI;

use ergodic_scattering::{Material, Rgb};
use glam::DVec3;

use crate::energy::albedo_by_quadrature;
use crate::support::{ALL, EXTENDED, Kind, inclined, surface, textures};

const ROUGHNESSES: [f64; 5] = [0.0, 0.2, 0.45, 0.7, 1.0];
const INDICES: [f64; 5] = [1.05, 1.33, 1.5, 1.8, 2.4];
const COSINES: [f64; 9] = [1.0, 0.7, 0.4, 0.2, 0.1, 0.03, -0.05, -0.3, -0.9];

/// Whether a kind has a diffuse lobe under a specular one, which gains energy by glTF's own formula.
fn is_coupled(kind: Kind) -> bool {
    matches!(
        kind,
        Kind::Coated
            | Kind::HalfMetal
            | Kind::MixedSolid
            | Kind::MixedThin
            | Kind::Leaf
            | Kind::Wax
            | Kind::Murky
            | Kind::MurkyBubble
            | Kind::Everything
            | Kind::EverythingSolid
    )
}

/// The kind with white instead of its colours, and the index where it is one that refracts.
fn white(kind: Kind, roughness: f64, ior: f64) -> Material {
    let mut material =
        Material { base_color: Rgb::ONE, specular_color: Rgb::ONE, ..kind.material(roughness * roughness) };
    if let Some(layers) = &mut material.layers {
        layers.diffuse_transmission_color = Rgb::ONE;
        layers.sheen_color = Rgb::splat(layers.sheen_color.max_element());
    }
    match kind {
        // Their index is what they are.
        Kind::Invisible | Kind::SoapFilm => {}
        Kind::Bubble | Kind::MurkyBubble => material.ior = 1.0 / ior,
        _ => material.ior = ior,
    }
    material
}

fn albedo(kind: Kind, roughness: f64, ior: f64, cos: f64) -> f64 {
    let at = white(kind, roughness, ior).interaction(&textures(), &surface(DVec3::Z));
    albedo_by_quadrature(&at, inclined(cos, 0.4), kind, roughness * roughness)
}

/// The largest albedo of a kind on the grid, with roughness, index and cosine.
fn largest(kind: Kind) -> (f64, [f64; 3]) {
    let mut worst = (0.0, [0.0; 3]);
    let has_index = !matches!(kind, Kind::Lambert | Kind::Metal | Kind::Invisible | Kind::SoapFilm);
    // Surfaces of many lobes take the longest; they have a coarser grid with the same ends.
    let coarse = EXTENDED.contains(&kind);
    let kept = |i: usize| !coarse || i.is_multiple_of(2);
    for (_, roughness) in ROUGHNESSES.into_iter().enumerate().filter(|(i, _)| kept(*i)) {
        if kind.is_anisotropic() && roughness < 0.3 {
            continue;
        }
        for (_, ior) in INDICES.into_iter().enumerate().filter(|(i, ior)| kept(*i) && (has_index || *ior == 1.5)) {
            for (i, cos) in COSINES.into_iter().enumerate() {
                // Below the horizon an opaque surface is what it is above.
                if cos < 0.0 && kind.is_opaque() || coarse && i % 3 == 0 {
                    continue;
                }
                let found = albedo(kind, roughness, ior, cos);
                if found > worst.0 {
                    worst = (found, [roughness, ior, cos]);
                }
            }
        }
    }
    worst
}

#[test]
fn nothing_but_a_diffuse_lobe_under_a_specular_one_gains_energy() {
    for kind in ALL.into_iter().filter(|kind| !is_coupled(*kind)) {
        let (albedo, at) = largest(kind);
        println!("{kind:?}: {albedo:.4} at {at:?}");
        assert!(albedo <= 1.001, "{kind:?} at {at:?}: {albedo}");
        let least = if EXTENDED.contains(&kind) { 0.5 } else { 0.99 };
        assert!(albedo > least, "{kind:?} is nowhere near white: {albedo}");
    }
}

/// What a smooth dielectric over white reflects by the formula alone: F(eye) and the mean of 1 - F(H) over the cosine-weighted
/// hemisphere, with Schlick's F.
fn smooth_by_formula(ior: f64, cos: f64) -> f64 {
    let f0 = ((ior - 1.0) / (ior + 1.0)).powi(2);
    let fresnel = |cos: f64| f0 + (1.0 - f0) * (1.0 - cos).powi(5);
    let eye = inclined(cos, 0.0);
    let n = 400;
    let mut kept = 0.0;
    for i in 0..n {
        let z = ((f64::from(i) + 0.5) / f64::from(n)).sqrt();
        for j in 0..n {
            let light = inclined(z, 2.0 * PI * (f64::from(j) + 0.5) / f64::from(n));
            kept += 1.0 - fresnel(0.5 * (light + eye).length());
        }
    }
    fresnel(cos) + kept / f64::from(n * n)
}

#[test]
fn what_a_diffuse_lobe_under_a_specular_one_gains_is_the_formulas_own() {
    for ior in INDICES {
        for cos in COSINES.into_iter().filter(|cos| *cos > 0.0) {
            let (found, expected) = (albedo(Kind::Coated, 0.0, ior, cos), smooth_by_formula(ior, cos));
            assert!((found - expected).abs() < 1e-3, "ior {ior} cos {cos}: {found} {expected}");
        }
    }
    // The mean over the hemisphere, which is what a room of such walls would gain at each bounce.
    for (i, roughness) in ROUGHNESSES.into_iter().enumerate() {
        let row: Vec<f64> = [1.0, 0.7, 0.4, 0.2, 0.1, 0.03].map(|cos| albedo(Kind::Coated, roughness, 1.5, cos)).into();
        let n = 40;
        let mean = (0..n).map(|k| albedo(Kind::Coated, roughness, 1.5, ((f64::from(k) + 0.5) / f64::from(n)).sqrt()));
        let mean = mean.sum::<f64>() / f64::from(n);
        println!("roughness {roughness}: {row:.3?}, mean {mean:.4}");
        assert!((mean - MEANS[i]).abs() < 2e-3, "roughness {roughness}: {mean}");
    }
    for kind in ALL.into_iter().filter(|kind| is_coupled(*kind)) {
        let (albedo, at) = largest(kind);
        println!("{kind:?}: {albedo:.4} at {at:?}");
        // At grazing angles F and the diffuse lobe come near 1 each. Coats and sheens take some of it away.
        let least = if EXTENDED.contains(&kind) { 0.5 } else { 1.1 };
        assert!((least..2.0).contains(&albedo), "{kind:?} at {at:?}: {albedo}");
    }
}

/// What docs/materials.md says of white under index 1.5, by roughness: the mean over directions, cosine-weighted.
const MEANS: [f64; 5] = [1.041, 1.037, 1.014, 0.993, 0.975];
