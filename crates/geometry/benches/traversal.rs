//! Processor time of a ray, and wall time of building the trees, which uses all cores: `cargo bench -p ergodic-geometry`.
//!
//! Names are `QUERY/FORM/RAYS/TRIANGLES`, so that a filter picks a part: `cargo bench -p ergodic-geometry -- closest/flat`. The scene
//! of ten million triangles takes minutes and some gigabytes: it is measured too if `ERGODIC_BENCH_LARGE` is set.

mod generated;
mod processor_time;

use std::hint::black_box;
use std::time::Duration;

use criterion::measurement::Measurement;
use criterion::{
    BatchSize, BenchmarkGroup, BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main,
};
use ergodic_geometry::World;
use generated::Placed;
use processor_time::ProcessorTime;

/// Rays of one iteration: enough that a large scene does not stay in the caches from one to the next.
const RAYS: usize = 50_000;

/// About how many triangles the scenes have.
fn sizes() -> &'static [usize] {
    const SIZES: [usize; 4] = [10_000, 100_000, 1_000_000, 10_000_000];
    if std::env::var_os("ERGODIC_BENCH_LARGE").is_some() { &SIZES } else { &SIZES[..3] }
}

fn build((meshes, instances): Placed) -> World {
    World::build(meshes, instances).expect("the generated scene is sound")
}

fn group<'a, M: Measurement>(criterion: &'a mut Criterion<M>, name: &str) -> BenchmarkGroup<'a, M> {
    let mut group = criterion.benchmark_group(name);
    group.sampling_mode(SamplingMode::Flat).sample_size(10).warm_up_time(Duration::from_millis(200));
    group.measurement_time(Duration::from_secs(1));
    group
}

fn queries(criterion: &mut Criterion<ProcessorTime>) {
    for &size in sizes() {
        let flat = build(generated::flat(size));
        let instanced = build(generated::instanced(size));
        for kind in generated::KINDS {
            let rays = generated::rays(&flat, kind, RAYS);
            let segments = generated::segments(&flat, kind, RAYS);
            for (form, world) in [("flat", &flat), ("instanced", &instanced)] {
                let id = BenchmarkId::new(format!("{form}/{kind}"), size);
                let mut closest = group(criterion, "closest");
                closest.throughput(Throughput::Elements(RAYS as u64));
                closest.bench_function(id.clone(), |bencher| {
                    bencher.iter(|| rays.iter().filter(|ray| black_box(world.intersect(ray)).is_some()).count());
                });
                closest.finish();
                let mut any = group(criterion, "any");
                any.throughput(Throughput::Elements(RAYS as u64));
                any.bench_function(id, |bencher| {
                    bencher.iter(|| segments.iter().filter(|[a, b]| black_box(world.visible(a, b))).count());
                });
                any.finish();
            }
        }
    }
}

fn builds(criterion: &mut Criterion) {
    let mut group = group(criterion, "build");
    for &size in sizes() {
        for (form, make) in [("flat", generated::flat as fn(usize) -> Placed), ("instanced", generated::instanced)] {
            group.throughput(Throughput::Elements(size as u64));
            group.bench_function(BenchmarkId::new(form, size), |bencher| {
                let placed = make(size);
                bencher.iter_batched(|| placed.clone(), build, BatchSize::PerIteration);
            });
        }
    }
    group.finish();
}

criterion_group! {
    name = rays;
    config = processor_time::criterion();
    targets = queries
}
criterion_group!(trees, builds);
criterion_main!(rays, trees);
