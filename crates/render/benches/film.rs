//! Nanoseconds per splat: into a buffer, from 128 full buffers into the film on all cores, and straight into the film.
//! `cargo bench -p ergodic-render`.

use std::hint::black_box;
use std::time::Instant;

use ergodic_render::{Film, SplatBuffer};
use ergodic_scattering::{Filter, Rgb};
use glam::DVec2;

const BUFFERS: usize = 128;

/// Image points of a walk with small steps and now and then a large one, as chains make them.
fn points(count: usize, (width, height): (u32, u32)) -> Vec<DVec2> {
    let u = |i: usize, k: i32| (0.5 + i as f64 * 1.220_744_084_605_759_5_f64.powi(-k)).fract();
    let size = DVec2::new(f64::from(width), f64::from(height));
    let mut at = size / 2.0;
    (0..count)
        .map(|i| {
            let step = DVec2::new(u(i, 1), u(i, 2));
            at = if i % 8 == 0 { step * size } else { at + (step - 0.5) * 0.02 * size };
            at = at.rem_euclid(size);
            at
        })
        .collect()
}

/// Time of a call over the number of splats.
fn nanoseconds(splats: usize, call: impl FnOnce()) -> f64 {
    let start = Instant::now();
    call();
    start.elapsed().as_secs_f64() * 1e9 / splats as f64
}

fn main() {
    for (name, filter) in [("box", Filter::Box), ("gaussian", Filter::Gaussian { radius: 2.0, sigma: 0.5 })] {
        for size in [(256, 256), (3840, 2160)] {
            let mut buffers = vec![SplatBuffer::new(); BUFFERS];
            let mut film = Film::new(size.0, size.1, filter);
            let splats = BUFFERS * buffers[0].room();
            let points = points(splats, size);
            let [mut append, mut merge, mut direct] = [f64::INFINITY; 3];
            for _ in 0..8 {
                append = append.min(nanoseconds(splats, || {
                    for (buffer, points) in buffers.iter_mut().zip(points.chunks(splats / BUFFERS)) {
                        points.iter().for_each(|&at| buffer.splat(at, black_box(Rgb::ONE)));
                    }
                }));
                merge = merge.min(nanoseconds(splats, || film.merge(&mut buffers.iter_mut().collect::<Vec<_>>())));
                direct = direct
                    .min(nanoseconds(splats, || points.iter().for_each(|&at| film.splat(at, black_box(Rgb::ONE)))));
            }
            black_box(&film);
            let (width, height) = size;
            println!(
                "{name:8} {width}x{height}: append {append:5.1} ns   merge {merge:5.1} ns   direct {direct:5.1} ns"
            );
        }
    }
}
