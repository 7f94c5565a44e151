//! Which of many triangles lie in the same place, whichever corner comes first and whichever way they face.

use std::cmp::Ordering;

use glam::DVec3;
use rayon::prelude::*;

use crate::triangle::Triangle;

/// Splits triangles so that those in one place fall together; it may put others with them.
pub(crate) trait PlaceHash: Fn(&Triangle) -> u32 + Copy + Sync {}

impl<F: Fn(&Triangle) -> u32 + Copy + Sync> PlaceHash for F {}

/// The hash of a triangle's place.
pub(crate) fn place_hash(triangle: &Triangle) -> u32 {
    // The sum does not know the order of the corners, nor which way they turn.
    let sum = triangle.iter().fold(0u64, |sum, corner| sum.wrapping_add(corner_bits(*corner).into_iter().fold(0, mix)));
    (mix(sum, 0) >> 32) as u32
}

/// A multiplication carries bits upwards only, so the upper half is brought down after it. Each step is a bijection: corners
/// that differ in one coordinate never meet.
fn mix(state: u64, word: u64) -> u64 {
    // 2⁶⁴ over the golden ratio, odd.
    let product = (state ^ word).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    product ^ product >> 32
}

fn corner_bits(corner: DVec3) -> [u64; 3] {
    // An addition of 0 makes one zero of the two.
    (corner + DVec3::ZERO).to_array().map(f64::to_bits)
}

/// The place itself.
fn place(triangle: &Triangle) -> [[u64; 3]; 3] {
    let mut place = triangle.map(corner_bits);
    place.sort_unstable();
    place
}

/// Whether all of some triangles lie in the place of the first.
pub(crate) fn in_one_place(mut triangles: impl Iterator<Item = Triangle>) -> bool {
    let first = triangles.next().map(|triangle| place(&triangle));
    triangles.all(|triangle| Some(place(&triangle)) == first)
}

/// Hands to `report` each set of two or more of the triangles 0..`count` that lie in one place, in ascending order, and
/// returns all that it pushed, in no particular order.
///
/// It needs 8 bytes a triangle: a hash and a number. Places themselves are compared only where hashes are equal.
pub(crate) fn same_places<T: Send>(
    count: u32,
    triangle: impl Fn(u32) -> Triangle + Sync,
    hash: impl PlaceHash,
    report: impl Fn(&[u32], &mut Vec<T>) + Sync,
) -> Vec<T> {
    let place = |key: &u64| place(&triangle(number(*key)));
    let mut keys: Vec<u64> =
        (0..count).into_par_iter().map(|i| u64::from(hash(&triangle(i))) << 32 | u64::from(i)).collect();
    keys.par_sort_unstable();
    let report_run = |mut found: Vec<T>, run: &mut [u64]| {
        // Sorted rather than compared in pairs, so that a file made of collisions costs little more than another.
        run.par_sort_unstable_by(|a, b| match place(a).cmp(&place(b)) {
            Ordering::Equal => a.cmp(b),
            other => other,
        });
        for same in run.chunk_by(|a, b| place(a) == place(b)).filter(|same| same.len() > 1) {
            let numbers: Vec<u32> = same.iter().map(|key| number(*key)).collect();
            report(&numbers, &mut found);
        }
        found
    };
    keys.par_chunk_by_mut(|a, b| a >> 32 == b >> 32).filter(|run| run.len() > 1).fold(Vec::new, report_run).reduce(
        Vec::new,
        |mut all, mut more| {
            all.append(&mut more);
            all
        },
    )
}

fn number(key: u64) -> u32 {
    key as u32
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn a_place_knows_neither_the_order_of_corners_nor_the_sign_of_zero() {
        let [a, b, c] = [DVec3::new(1.0, 0.0, 2.0), DVec3::new(0.5, -1.0, 0.0), DVec3::new(0.0, 3.0, 0.25)];
        for same in [[b, c, a], [c, b, a], [DVec3::new(1.0, -0.0, 2.0), b, c]] {
            assert_eq!(place_hash(&same), place_hash(&[a, b, c]));
            assert!(in_one_place([[a, b, c], same].into_iter()));
        }
        let other = [a, b, c + DVec3::X * 1e-300];
        assert_ne!(place_hash(&other), place_hash(&[a, b, c]));
        assert!(!in_one_place([[a, b, c], other].into_iter()));
    }

    #[test]
    fn hashes_of_a_grid_collide_no_more_than_random_numbers() {
        // Short numbers, whose lower bits are all zero. Random hashes would collide twice.
        let corner = |i: u32| DVec3::new(f64::from(i % 64), f64::from(i / 64 % 64), f64::from(i / 4096)) / 32.0;
        let triangle = |i: u32| [corner(i), corner(i + 1), corner(i + 64)];
        let different = |hash: fn(&Triangle) -> u32| (0..131_072).map(|i| hash(&triangle(i))).collect::<HashSet<_>>();
        assert!(different(place_hash).len() > 131_072 - 16);
        // The planted fault: bits of the coordinates without any mixing.
        let unmixed =
            |t: &Triangle| t.iter().fold(0u64, |sum, p| p.to_array().iter().fold(sum, |s, x| s ^ x.to_bits())) as u32;
        assert!(different(unmixed).len() < 131_072 - 16);
    }

    #[test]
    fn sets_are_reported_once_and_in_order() {
        // 1000 triangles in 300 places, each with a hash that 100 places share.
        let triangle = |i: u32| [DVec3::X, DVec3::Y, DVec3::Z * f64::from(i % 300)];
        let hash = |t: &Triangle| t[2].z as u32 % 3;
        let mut sets = same_places(1000, triangle, hash, |same, sets| sets.push(same.to_vec()));
        sets.sort_unstable();
        let expected: Vec<Vec<u32>> = (0..300).map(|first| (first..1000).step_by(300).collect()).collect();
        assert_eq!(sets, expected);
    }
}
