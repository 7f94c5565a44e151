//! Processor time of `eval`, `pdf` and `sample` for the common materials, and of a material's interaction at a point:
//! `cargo bench -p ergodic-scattering`.

#[path = "../../geometry/benches/processor_time/mod.rs"]
mod processor_time;

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use ergodic_geometry::Surface;
use ergodic_scattering::{Component, Material, Rgb};
use glam::{DVec2, DVec3, DVec4};
use processor_time::ProcessorTime;

/// Directions and numbers of one iteration, so many that no call can be predicted or hoisted.
const INPUTS: usize = 1024;

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

fn interactions(criterion: &mut Criterion<ProcessorTime>) {
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
        // So bright that the diffuse lobe's cap is asked for at every angle.
        ("white coated", Material { base_color: Rgb::ONE, ..dielectric.clone() }),
        ("rough glass", Material { transmission: 1.0, solid: true, ..dielectric.clone() }),
        ("smooth glass", Material { transmission: 1.0, solid: true, roughness: 0.0, ..dielectric }),
    ];
    let inputs = inputs();
    let mut group = criterion.benchmark_group("interaction");
    group.warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(500)).sample_size(20);
    group.throughput(Throughput::Elements(INPUTS as u64));
    for (name, material) in &materials {
        let at = material.interaction(&[], &surface);
        group.bench_function(BenchmarkId::new("eval", name), |bencher| {
            let at = black_box(&at);
            bencher.iter(|| {
                for i in &inputs {
                    black_box(at.eval(i.to, i.from, Component::Rough));
                }
            });
        });
        group.bench_function(BenchmarkId::new("pdf", name), |bencher| {
            let at = black_box(&at);
            bencher.iter(|| {
                for i in &inputs {
                    black_box(at.pdf(i.from, i.to, Component::Rough));
                }
            });
        });
        group.bench_function(BenchmarkId::new("sample", name), |bencher| {
            let at = black_box(&at);
            bencher.iter(|| {
                for i in &inputs {
                    black_box(at.sample(i.from, i.u));
                }
            });
        });
        group.bench_function(BenchmarkId::new("of material", name), |bencher| {
            let material = black_box(material);
            let at = |i: &Input| material.interaction(&[], &Surface { ns: i.from, ng: i.from, ..surface });
            bencher.iter(|| {
                for i in &inputs {
                    black_box(at(i));
                }
            });
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = processor_time::criterion();
    targets = interactions
}
criterion_main!(benches);
