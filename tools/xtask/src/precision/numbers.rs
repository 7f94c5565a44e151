//! f64 against f32: time of the hot functions, and the error that f32 makes.

use std::hint::black_box;

use ergodic_assess::accuracy::{Interval, ratio, resampled};
use glam::DVec3;

use super::Effort;
use super::page::{Section, cell, table};
use super::work::{Inputs, in_turns};

/// Inputs of a round; they stay in the caches.
const INPUTS: usize = 2048;
/// Times that a round goes through them.
const PASSES: usize = 100;

/// What a kernel may need.
struct Input {
    /// A ray and a triangle in its way, more or less.
    origin: DVec3,
    direction: DVec3,
    triangle: [DVec3; 3],
    /// Two points with normals.
    x: DVec3,
    y: DVec3,
    normals: [DVec3; 2],
    /// Directions on the side z > 0.
    wi: DVec3,
    wo: DVec3,
    numbers: [f64; 2],
}

fn upper(direction: DVec3) -> DVec3 {
    DVec3::new(direction.x, direction.y, direction.z.abs().max(1e-3)).normalize()
}

/// Inputs in a room of side 10, where edges have the given length and half vectors lie within some alphas of the normal.
fn inputs(edge: f64, alpha: f64) -> Vec<Input> {
    let mut random = Inputs::new(1);
    let mut input = || {
        let origin = random.point(5.0);
        let direction = random.direction();
        let middle = origin + direction * edge;
        let side = |random: &mut Inputs| middle + random.direction() * (0.7 * edge);
        let triangle = [side(&mut random), side(&mut random), side(&mut random)];
        let normals = [random.direction(), random.direction()];
        let wi = upper(random.direction());
        // Within the lobe, where f32 has the least digits and the most weight.
        let h = upper(DVec3::Z + random.direction() * alpha);
        let wo = upper(h * (2.0 * wi.dot(h)) - wi);
        let numbers = [random.uniform(), random.uniform()];
        Input { origin, direction, triangle, x: origin, y: middle, normals, wi, wo, numbers }
    };
    (0..INPUTS).map(|_| input()).collect()
}

/// The kernels on one input, with numbers of one kind; all give one number.
macro_rules! on_inputs {
    ($name:ident, $kind:ident) => {
        mod $name {
            use super::super::kernels::$kind::*;
            use super::{Input, KERNELS};

            pub struct Prepared {
                origin: V,
                direction: V,
                triangle: [V; 3],
                x: V,
                y: V,
                normals: [V; 2],
                wi: V,
                wo: V,
                numbers: [R; 2],
            }

            /// The input as a core with such numbers has it.
            pub fn prepare(input: &Input) -> Prepared {
                Prepared {
                    origin: vector(input.origin),
                    direction: vector(input.direction),
                    triangle: input.triangle.map(vector),
                    x: vector(input.x),
                    y: vector(input.y),
                    normals: input.normals.map(vector),
                    wi: vector(input.wi),
                    wo: vector(input.wo),
                    numbers: input.numbers.map(number),
                }
            }

            /// What kernel number `K` makes of an input. What is no number says that there is no answer.
            #[inline(always)]
            fn kernel<const K: usize>(i: &Prepared, alpha: R) -> R {
                match K {
                    0 => Sheared::new(i.origin, i.direction).cross(&i.triangle).unwrap_or(R::NAN),
                    1 => plain(i.origin, i.direction, &i.triangle).unwrap_or(R::NAN),
                    2 => geometry_term(i.x, i.normals[0], i.y, i.normals[1]),
                    3 => to_world(i.normals[0], i.wi).x,
                    4 => ggx_eval(alpha, i.wi, i.wo),
                    5 => ggx_pdf(alpha, i.wi, i.wo),
                    _ => ggx_sample(alpha, i.wi, i.numbers).x,
                }
            }

            /// Goes through all inputs some times. The sum makes every result needed.
            fn pass<const K: usize>(inputs: &[Prepared], alpha: f64, times: usize) -> f64 {
                let mut sum = 0.0;
                for _ in 0..times {
                    for input in std::hint::black_box(inputs) {
                        sum += kernel::<K>(input, number(alpha));
                    }
                }
                sum.into()
            }

            /// All results.
            fn values<const K: usize>(inputs: &[Prepared], alpha: f64) -> Vec<f64> {
                inputs.iter().map(|input| kernel::<K>(input, number(alpha)).into()).collect()
            }

            /// By the number of the kernel.
            pub const PASSES: [fn(&[Prepared], f64, usize) -> f64; KERNELS] =
                [pass::<0>, pass::<1>, pass::<2>, pass::<3>, pass::<4>, pass::<5>, pass::<6>];
            /// By the number of the kernel.
            pub const VALUES: [fn(&[Prepared], f64) -> Vec<f64>; KERNELS] =
                [values::<0>, values::<1>, values::<2>, values::<3>, values::<4>, values::<5>, values::<6>];
        }
    };
}

on_inputs!(in_double, double);
on_inputs!(in_single, single);

const KERNELS: usize = 7;

/// Names of the kernels by their numbers.
const NAMES: [&str; KERNELS] = [
    "triangle test, watertight",
    "triangle test, Möller and Trumbore",
    "geometry term",
    "frame and transform",
    "GGX eval",
    "GGX pdf",
    "GGX sample",
];

/// Length of edges in the room, and alpha, where times are measured.
const USUAL: (f64, f64) = (1.0, 0.3);

/// Errors that are told: the kernel, what is special, the length of edges, alpha.
const ERRORS: [(usize, &str, f64, f64); 10] = [
    (0, "distances of 1", 1.0, 0.3),
    (0, "distances of 1e-3", 1e-3, 0.3),
    (2, "edges of 1", 1.0, 0.3),
    (2, "edges of 1e-3", 1e-3, 0.3),
    (2, "edges of 1e-5", 1e-5, 0.3),
    (3, "unit vectors", 1.0, 0.3),
    (5, "alpha 0.3", 1.0, 0.3),
    (5, "alpha 0.01", 1.0, 0.01),
    (5, "alpha 0.001", 1.0, 0.001),
    (6, "alpha 0.01", 1.0, 0.01),
];

/// A value that a share of others does not exceed.
fn quantile(values: &[f64], indices: &[usize], share: f64) -> Option<f64> {
    let mut drawn: Vec<f64> = indices.iter().map(|i| values[*i]).collect();
    let at = (drawn.len().checked_sub(1)? as f64 * share) as usize;
    Some(*drawn.select_nth_unstable_by(at, f64::total_cmp).1)
}

/// Relative errors of f32 where both kinds of number have an answer, and for which share of inputs only one has.
fn errors(kernel: usize, edge: f64, alpha: f64) -> (Vec<f64>, f64) {
    let inputs = inputs(edge, alpha);
    let exact = in_double::VALUES[kernel](&inputs.iter().map(in_double::prepare).collect::<Vec<_>>(), alpha);
    let rounded = in_single::VALUES[kernel](&inputs.iter().map(in_single::prepare).collect::<Vec<_>>(), alpha);
    let pairs = || exact.iter().zip(&rounded);
    let both = pairs().filter(|(a, b)| a.is_finite() && b.is_finite() && **a != 0.0);
    let one = pairs().filter(|(a, b)| a.is_finite() != b.is_finite()).count();
    (both.map(|(a, b)| ((b - a) / a).abs()).collect(), one as f64 / INPUTS as f64)
}

/// Measures times and errors.
pub fn measure(effort: &Effort) -> Result<Section, String> {
    let (edge, alpha) = USUAL;
    let inputs = inputs(edge, alpha);
    let double: Vec<_> = inputs.iter().map(in_double::prepare).collect();
    let single: Vec<_> = inputs.iter().map(in_single::prepare).collect();
    let nanoseconds = |times: &[f64]| -> Option<Interval> {
        let each: Vec<f64> = times.iter().map(|time| time * 1e9 / (INPUTS * PASSES) as f64).collect();
        ergodic_assess::accuracy::mean(&each)
    };
    let times = (0..KERNELS).map(|kernel| {
        let [f64s, f32s] = in_turns(
            effort.rounds,
            || {
                black_box(in_double::PASSES[kernel](&double, alpha, PASSES));
            },
            || {
                black_box(in_single::PASSES[kernel](&single, alpha, PASSES));
            },
        );
        vec![NAMES[kernel].into(), cell(nanoseconds(&f64s)), cell(nanoseconds(&f32s)), cell(ratio(&f64s, &f32s))]
    });
    let times = table(&["function", "f64, ns", "f32, ns", "f64 over f32"], &times.collect::<Vec<_>>());
    let errors = ERRORS.iter().map(|(kernel, what, edge, alpha)| {
        let (errors, one) = errors(*kernel, *edge, *alpha);
        let at = |share: f64| cell(resampled(errors.len(), |indices| quantile(&errors, indices, share)));
        vec![NAMES[*kernel].into(), (*what).into(), at(0.5), at(0.99), format!("{:.2} %", one * 100.0)]
    });
    let errors = table(
        &["function", "inputs", "relative error of f32, median", "99 of 100 are below", "only one has an answer"],
        &errors.collect::<Vec<_>>(),
    );
    Ok(Section {
        title: "f64 against f32",
        parts: vec![
            format!(
                "The core computes in f64. Here the same text of the hot functions is compiled for both kinds of number, without \
                 SIMD, and goes\nthrough {INPUTS} inputs that stay in the caches. A wider search, or twice the numbers in a cache \
                 line, would be a further gain of f32\nthat this does not see; boxes of the search trees are f32 here too."
            ),
            times,
            "What f32 loses, in a room of side 10. Its inputs are rounded to f32 too, as they would be stored; f64 stands for the \
             exact value. The\nerror of a geometry term is that of the difference of two positions, so it grows as edges get short, \
             and the term enters every density\nand every acceptance. f64 makes the same errors 5e8 times smaller."
                .into(),
            errors,
        ],
    })
}
