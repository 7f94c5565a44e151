//! Nanoseconds per call of `eval`, `pdf` and `sample` for the common materials: `cargo bench -p ergodic-scattering`.

use std::hint::black_box;
use std::time::Instant;

use ergodic_geometry::Surface;
use ergodic_scattering::{Component, Interaction, Material, Rgb};
use glam::{DVec2, DVec3, DVec4};

/// Directions and numbers to go through, so that no call can be predicted or hoisted.
const INPUTS: usize = 1024;
const ROUNDS: usize = 2000;

struct Input {
    from: DVec3,
    to: DVec3,
    u: [f64; 3],
}

/// Points of the additive recurrence with the plastic number (Roberts 2018), as directions over the upper hemisphere.
fn inputs() -> Vec<Input> {
    let u = |i: usize, k: i32| (0.5 + i as f64 * 1.220_744_084_605_759_5_f64.powi(-k)).fract();
    let direction = |x: f64, y: f64| {
        let (sin, cos) = (std::f64::consts::TAU * x).sin_cos();
        let radius = (1.0 - y * y).sqrt();
        DVec3::new(radius * cos, radius * sin, y)
    };
    (1..=INPUTS)
        .map(|i| Input {
            from: direction(u(i, 1), u(i, 2)),
            to: direction(u(i, 3), u(i, 4)),
            u: [u(i, 5), u(i, 6), u(i, 7)],
        })
        .collect()
}

/// Least time per call over several batches.
fn nanoseconds(inputs: &[Input], mut call: impl FnMut(&Input)) -> f64 {
    let batch = |call: &mut dyn FnMut(&Input)| {
        let start = Instant::now();
        for _ in 0..ROUNDS / 10 {
            inputs.iter().for_each(&mut *call);
        }
        start.elapsed().as_secs_f64() * 1e9 / (inputs.len() * ROUNDS / 10) as f64
    };
    (0..10).map(|_| batch(&mut call)).fold(f64::INFINITY, f64::min)
}

fn report(name: &str, at: Interaction) {
    let inputs = inputs();
    let at = black_box(at);
    let eval = nanoseconds(&inputs, |i| {
        black_box(at.eval(i.to, i.from, Component::Rough));
    });
    let pdf = nanoseconds(&inputs, |i| {
        black_box(at.pdf(i.from, i.to, Component::Rough));
    });
    let sample = nanoseconds(&inputs, |i| {
        black_box(at.sample(i.from, i.u));
    });
    println!("{name:16} eval {eval:6.1} ns   pdf {pdf:6.1} ns   sample {sample:6.1} ns");
}

fn main() {
    let surface = Surface {
        position: DVec3::ZERO,
        ng: DVec3::Z,
        ns: DVec3::new(0.01, 0.0, 1.0).normalize(),
        tangent: DVec3::ZERO,
        bitangent_sign: 0.0,
        texcoords: [DVec2::ZERO; 2],
        color: DVec4::ONE,
        instance: 0,
        triangle: 0,
    };
    let dielectric = Material { base_color: Rgb::splat(0.5), metallic: 0.0, roughness: 0.5, ..Material::default() };
    let materials = [
        ("lambert", Material { specular: 0.0, ..dielectric.clone() }),
        ("metal", Material { metallic: 1.0, ..dielectric.clone() }),
        ("coated", dielectric.clone()),
        ("rough glass", Material { transmission: 1.0, solid: true, ..dielectric.clone() }),
        ("smooth glass", Material { transmission: 1.0, solid: true, roughness: 0.0, ..dielectric.clone() }),
    ];
    println!("Interaction: {} bytes", size_of::<Interaction>());
    for (name, material) in materials {
        report(name, material.interaction(&[], &surface));
    }
    let inputs = inputs();
    let point = nanoseconds(&inputs, |i| {
        black_box(dielectric.interaction(&[], &Surface { ns: i.from, ng: i.from, ..surface }));
    });
    println!("Material::interaction without textures: {point:.1} ns");
}
