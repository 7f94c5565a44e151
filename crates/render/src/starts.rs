//! Which samples of the seeding become the starts of the chains: in proportion to their weight, by systematic resampling in an order in
//! which like samples are neighbours.
//!
//! Systematic resampling (Kitagawa 1996) gives every sample as many copies on average as its share of the weight asks for,
//! whatever the order, so that nothing becomes biased. But the copies of any run of neighbours are as many as the run's share asks for,
//! to within one. The order is by length, then by class, then along Hilbert's curve through the image: so each class has its share of the
//! chains, and those of a class are spread over the image as its light is. Chains that hardly ever change from one class, or
//! from one part of a caustic, to another keep these shares, and their picture is as good as the starts were.

use ergodic_pathspace::PathClass;
use glam::DVec2;
use rayon::prelude::*;

/// Bits of either coordinate along Hilbert's curve.
const IMAGE_BITS: u32 = 16;
/// Bits that classes of one length are told apart by, and those of the length.
const CLASS_BITS: u32 = 21;
const LENGTH_BITS: u32 = u64::BITS - CLASS_BITS - 2 * IMAGE_BITS;

/// The golden section, whose multiples are spread evenly between whole numbers.
pub(crate) const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// A sample that carries light, as far as it is kept: 24 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seed {
    /// Its weight: its luminance, or what thinning has made of that.
    pub(crate) weight: f64,
    /// Where it stands in the order.
    pub(crate) place: u64,
    /// Its number among all samples.
    pub(crate) index: u32,
    /// Which of its paths stands for it.
    pub(crate) strategy: Strategy,
}

/// How the path that stands for a sample was made, where a sample is many paths: by so many vertices from the light and from the eye.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Strategy {
    /// Vertices from the light.
    pub s: u16,
    /// Vertices from the eye.
    pub t: u16,
}

/// The place in the order of a path of a class that arrives at `raster` of an image of `size` pixels.
pub(crate) fn place(class: PathClass, raster: DVec2, size: DVec2) -> u64 {
    let length = u64::from(class.length).min((1 << LENGTH_BITS) - 1);
    // Paths of more inner vertices than there are bits are told apart as well as the bits allow.
    let folded = class.specular ^ class.specular >> CLASS_BITS ^ class.specular >> (2 * CLASS_BITS);
    let specular = folded & ((1 << CLASS_BITS) - 1);
    let side = f64::from(1u32 << IMAGE_BITS);
    // One scale for both axes, so that runs of the curve are as wide as they are tall. Filters reach over the edge.
    let at = (raster / size.max_element() * side).clamp(DVec2::ZERO, DVec2::splat(side - 1.0));
    (length << CLASS_BITS | specular) << (2 * IMAGE_BITS) | hilbert(at.x as u32, at.y as u32)
}

/// How far along Hilbert's curve the cell lies, counted in cells.
fn hilbert(mut x: u32, mut y: u32) -> u64 {
    let mut along = 0;
    for bit in (0..IMAGE_BITS).rev() {
        let (right, up) = (x >> bit & 1, y >> bit & 1);
        along = along << 2 | u64::from((3 * right) ^ up);
        // The curve of each quarter is turned so that its ends meet those of its neighbours.
        if up == 0 {
            if right == 1 {
                (x, y) = (!x, !y);
            }
            (x, y) = (y, x);
        }
    }
    along
}

/// Puts the seeds in order. Ties go by number, so that the order does not depend on how it was found.
pub(crate) fn sort(seeds: &mut [Seed]) {
    seeds.par_sort_unstable_by_key(|seed| (seed.place, seed.index));
}

/// Where each seed's part of the running sum of weights ends.
pub(crate) fn ends(seeds: &[Seed]) -> Vec<f64> {
    let mut sum = 0.0;
    let end = |seed: &Seed| {
        sum += seed.weight;
        sum
    };
    seeds.iter().map(end).collect()
}

/// The positions in the list of the seeds that `count` equally spaced points along the running sum of weights fall on, in order, given
/// the `ends` of the seeds' parts; `offset`, in [0, 1), shifts the points. None if there is no weight.
///
/// The time goes with `count` and hardly with the number of seeds, since chains begin anew many times.
pub(crate) fn resample(ends: &[f64], count: usize, offset: f64) -> Vec<usize> {
    let Some(total) = ends.last().copied().filter(|total| *total > 0.0) else { return Vec::new() };
    let choose = |i: usize| {
        let point = (i as f64 + offset) / count as f64 * total;
        // Rounding may put the last point at the end of all.
        ends.partition_point(|end| *end <= point).min(ends.len() - 1)
    };
    (0..count).map(choose).collect()
}

/// Makes about `count` seeds of many without a change of their sum: each has as many times the mean weight as it has copies among
/// `count`, so that on average its weight is what it was. The seeds are in order, before and after.
pub(crate) fn thin(seeds: &mut Vec<Seed>, count: usize, offset: f64) {
    let ends = ends(seeds);
    let share = ends.last().copied().unwrap_or(0.0) / count as f64;
    let kept = resample(&ends, count, offset);
    let thinned =
        kept.chunk_by(|a, b| a == b).map(|copies| Seed { weight: share * copies.len() as f64, ..seeds[copies[0]] });
    *seeds = thinned.collect();
}

/// The numbers from 0 to `count` in an order of which every part is spread evenly, and every choice of each n-th as well: that of the
/// multiples of the golden section between whole numbers. It turns by one from generation to generation, so that those that one
/// chain has one after the other are spread evenly too.
pub(crate) fn spread(count: usize, generation: u64) -> Vec<usize> {
    let mut by_multiple: Vec<(f64, usize)> = (0..count).map(|i| ((i as f64 * GOLDEN).fract(), i)).collect();
    by_multiple.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let mut spread = vec![0; count];
    by_multiple.into_iter().enumerate().for_each(|(rank, (_, i))| spread[i] = rank);
    spread.rotate_left(generation.checked_rem(count as u64).unwrap_or(0) as usize);
    spread
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::streams::{Purpose, stream};
    use ergodic_metropolis::RandomSource;

    /// Seeds of a few classes, of which some are rare; weights over four powers of ten.
    fn seeds(count: u32) -> Vec<Seed> {
        let mut rng = stream(5, Purpose::Seeding, 0);
        (0..count)
            .map(|index| {
                let class = (rng.uniform().powi(3) * 12.0) as u64;
                let image = (rng.uniform() * 2.0f64.powi(32)) as u64;
                let (weight, place) = (10.0f64.powf(-4.0 * rng.uniform()), class << 32 | image);
                Seed { weight, place, index, strategy: Strategy::default() }
            })
            .collect()
    }

    fn class(seed: &Seed) -> usize {
        (seed.place >> 32) as usize
    }

    /// The largest difference, over classes, between the copies that a class has and those that its weight asks for.
    fn worst_class(seeds: &[Seed], starts: &[usize]) -> f64 {
        let mut differences = [0.0; 12];
        let total: f64 = seeds.iter().map(|seed| seed.weight).sum();
        seeds.iter().for_each(|seed| differences[class(seed)] -= seed.weight / total * starts.len() as f64);
        starts.iter().for_each(|start| differences[class(&seeds[*start])] += 1.0);
        differences.into_iter().map(f64::abs).fold(0.0, f64::max)
    }

    /// How far, in standard deviations, the mean copies of the worst of all seeds are from what its weight asks for, over `rounds`.
    fn worst_bias(
        seeds: &[Seed],
        count: usize,
        rounds: u64,
        choose: impl Fn(&[Seed], usize, &mut dyn FnMut() -> f64) -> Vec<usize>,
    ) -> f64 {
        let mut copies = vec![(0.0, 0.0); seeds.len()];
        for round in 0..rounds {
            let mut rng = stream(round, Purpose::Starts, 1);
            let mut of_round = vec![0.0; seeds.len()];
            choose(seeds, count, &mut || rng.uniform()).into_iter().for_each(|start| of_round[start] += 1.0);
            copies.iter_mut().zip(of_round).for_each(|(sums, c)| *sums = (sums.0 + c, sums.1 + c * c));
        }
        let (n, total) = (rounds as f64, seeds.iter().map(|seed| seed.weight).sum::<f64>());
        let deviations = seeds.iter().zip(copies).map(|(seed, (sum, _))| {
            let expected = seed.weight / total * count as f64;
            // Copies are one of two neighbouring numbers.
            let part = expected.fract();
            (sum / n - expected).abs() / (part * (1.0 - part) / n).sqrt().max(1e-9)
        });
        deviations.fold(0.0, f64::max)
    }

    #[test]
    fn expected_copies_are_in_proportion_to_weight_in_any_order() {
        let systematic =
            |seeds: &[Seed], count: usize, uniform: &mut dyn FnMut() -> f64| resample(&ends(seeds), count, uniform());
        let mut seeds = seeds(300);
        for ordered in [false, true] {
            if ordered {
                sort(&mut seeds);
            }
            let worst = worst_bias(&seeds, 64, 20_000, systematic);
            println!("in order {ordered}: the worst of {} seeds is {worst:.2} deviations off", seeds.len());
            assert!(worst < 5.0, "{worst}");
        }
        // Planted faults: weights that are ignored, and points that are always at the start of their interval, which favours what
        // stands there.
        let ignored = |seeds: &[Seed], count: usize, uniform: &mut dyn FnMut() -> f64| {
            let alike: Vec<Seed> = seeds.iter().map(|seed| Seed { weight: 1.0, ..*seed }).collect();
            resample(&ends(&alike), count, uniform())
        };
        let fixed = |seeds: &[Seed], count: usize, uniform: &mut dyn FnMut() -> f64| {
            resample(&ends(seeds), count, 0.5 * uniform())
        };
        assert!(worst_bias(&seeds, 64, 20_000, ignored) > 20.0);
        assert!(worst_bias(&seeds, 64, 20_000, fixed) > 20.0);
    }

    #[test]
    fn every_class_has_its_share_of_the_starts_to_within_one() {
        let mut seeds = seeds(20_000);
        let worst = |seeds: &[Seed], count| {
            (0..40).map(|i| worst_class(seeds, &resample(&ends(seeds), count, f64::from(i) / 40.0))).fold(0.0, f64::max)
        };
        let by_number: Vec<f64> = [64, 512, 4096].map(|count| worst(&seeds, count)).to_vec();
        sort(&mut seeds);
        let by_class: Vec<f64> = [64, 512, 4096].map(|count| worst(&seeds, count)).to_vec();
        println!("starts too many or too few: {by_class:.2?}, by number {by_number:.2?}");
        assert!(by_class.iter().all(|worst| *worst < 1.0 + 1e-6));
        // In the order in which they were drawn the shares are those of independent draws.
        assert!(by_number.iter().all(|worst| *worst > 2.0), "{by_number:?}");
    }

    #[test]
    fn thinning_keeps_the_sum_and_on_average_every_weight() {
        let mut seeds = seeds(400);
        sort(&mut seeds);
        let total: f64 = seeds.iter().map(|seed| seed.weight).sum();
        let rounds = 20_000;
        let mut sums = vec![0.0; seeds.len()];
        for round in 0..rounds {
            let mut thinned = seeds.clone();
            thin(&mut thinned, 100, stream(round, Purpose::Starts, 2).uniform());
            assert!(thinned.len() <= 100 && thinned.is_sorted_by_key(|seed| (seed.place, seed.index)));
            assert!((thinned.iter().map(|seed| seed.weight).sum::<f64>() / total - 1.0).abs() < 1e-12);
            thinned.iter().for_each(|seed| sums[seed.index as usize] += seed.weight);
        }
        let share = total / 100.0;
        let worst = seeds.iter().map(|seed| {
            let part = (seed.weight / share).fract();
            let deviation = share * (part * (1.0 - part) / rounds as f64).sqrt();
            (sums[seed.index as usize] / rounds as f64 - seed.weight).abs() / deviation
        });
        let worst = worst.fold(0.0, f64::max);
        println!("the worst weight is {worst:.2} deviations off");
        assert!(worst < 5.0, "{worst}");
    }

    #[test]
    fn neighbours_along_the_curve_are_neighbours_in_the_image() {
        let bits = 5;
        let shift = IMAGE_BITS - bits;
        let mut cells: Vec<(u64, i32, i32)> = (0..1 << bits)
            .flat_map(|y| (0..1 << bits).map(move |x| (x, y)))
            .map(|(x, y)| (hilbert(x << shift, y << shift), x as i32, y as i32))
            .collect();
        cells.sort_unstable();
        for pair in cells.windows(2) {
            assert_eq!((pair[1].1 - pair[0].1).abs() + (pair[1].2 - pair[0].2).abs(), 1, "{pair:?}");
        }
    }

    #[test]
    fn places_go_by_length_then_class_then_image() {
        let size = DVec2::new(64.0, 32.0);
        let at = |length, specular, x: f64, y: f64| place(PathClass { length, specular }, DVec2::new(x, y), size);
        assert!(at(3, 0b01, 60.0, 30.0) < at(3, 0b10, 0.0, 0.0));
        assert!(at(3, 0b11, 60.0, 30.0) < at(4, 0, 0.0, 0.0));
        assert_ne!(at(3, 0, 10.0, 10.0), at(3, 0, 10.01, 10.0));
        // Beyond the image, and more vertices and edges than there are bits.
        assert_eq!(at(3, 0, -1.0, -1.0), at(3, 0, 0.0, 0.0));
        assert!(at(1024, u64::MAX, 64.0, 32.0) > at(1023, u64::MAX, 64.0, 32.0));
        assert_ne!(at(70, 1 << 40, 1.0, 1.0), at(70, 1 << 41, 1.0, 1.0));
    }

    #[test]
    fn chains_of_any_batch_have_starts_from_everywhere() {
        for count in [1usize, 2, 3, 64, 511, 512, 4096, 10_000] {
            let order = spread(count, 0);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert!(sorted.iter().enumerate().all(|(i, n)| i == *n), "each once, of {count}");
            let gap = |mut part: Vec<usize>| {
                part.sort_unstable();
                let ends = std::iter::once(part[0] + count - part[part.len() - 1]);
                let widest = part.windows(2).map(|pair| pair[1] - pair[0]).chain(ends).max().unwrap_or(0);
                widest as f64 * part.len() as f64 / count as f64
            };
            if count >= 512 {
                for n in 0..8 {
                    assert!(gap(order.iter().copied().skip(n).step_by(8).collect()) < 4.0, "each 8th of {count}");
                }
                assert!(gap(order[..count / 4].to_vec()) < 4.0, "the first quarter of {count}");
                // In order of place the first chains would all begin in one corner.
                assert!(gap((0..count / 4).collect()) > 90.0);
                for chain in [0, 1, count - 1] {
                    let of_chain =
                        |turns: u64| (0..64).map(|generation| spread(count, generation * turns)[chain]).collect();
                    assert!(gap(of_chain(1)) < 4.0, "chain {chain} of {count}");
                    // Without a turn it begins in one place again and again.
                    assert!(gap(of_chain(0)) > 60.0);
                }
            }
        }
    }
}
