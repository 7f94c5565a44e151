//! Room between solids that touch.
//!
//! Rays leave a surface a little way out (see `ergodic_geometry::spawn_offset`). Where two faces lie in one plane, as those of a
//! glass that stands on a table or of water in it, the ray would start beyond the second: it would leave one medium and never
//! enter the other, and every such pass would be wrong by the square of an index. So the surfaces of refracting solids are drawn
//! in by some thousand of these offsets, 1e-8 of the scene, and solids that touch have a gap of air instead. Nothing at that scale is
//! visible, but a ray finds both faces.

use std::collections::HashMap;

use ergodic_geometry::Mesh;
use glam::DVec3;

/// How far a solid is drawn in, in units of the offset of rays, by its rank among the solids.
///
/// The offset is an error in the direction of a ray, twice its share of the distance in every density: across the gap it is
/// less than 1e-3. Each solid is drawn in by another amount, so that solids that overlap have no face in common either.
pub(crate) fn drawn_in(rank: usize) -> f64 {
    4096.0 + 2048.0 * (rank % 32) as f64
}

/// A corner is moved by at most this many times the distance of its faces; only needles would want more.
const FARTHEST: f64 = 16.0;

/// Rounds of projection onto the moved planes. Where three planes meet they give the corner to a part in a hundred.
const ROUNDS: usize = 32;

/// Moves every face of the mesh towards its back by what `distance` says of its unit normal. Corners in one place stay in one
/// place, so a closed mesh stays closed.
pub(crate) fn draw_in(mesh: &mut Mesh, distance: impl Fn(DVec3) -> f64) {
    let place = |p: DVec3| (p + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut planes: HashMap<[u64; 3], Vec<(DVec3, f64)>> = HashMap::new();
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
        for corner in [a, b, c] {
            let known = planes.entry(place(corner)).or_default();
            // The triangles of one plane count once.
            if known.iter().all(|(n, _)| n.dot(normal) < 1.0 - 1e-9) {
                known.push((normal, distance(normal)));
            }
        }
    }
    for position in &mut mesh.positions {
        let Some(planes) = planes.get(&place(*position)) else { continue };
        // The nearest point of all moved planes, by projection onto one after the other (Kaczmarz 1937).
        let mut move_by = DVec3::ZERO;
        for _ in 0..ROUNDS {
            for (normal, distance) in planes {
                move_by -= *normal * (distance + move_by.dot(*normal));
            }
        }
        let most = planes.iter().map(|(_, distance)| *distance).fold(0.0, f64::max);
        *position += move_by.clamp_length_max(FARTHEST * most);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_face_of_a_cube_moves_in_by_the_distance() {
        let corner = |i: u32| DVec3::from_array(std::array::from_fn(|axis| f64::from(i >> axis & 1)));
        // Every face with corners of its own, as files have them, and one of them cut into two the other way.
        let mut mesh = Mesh::default();
        for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
            let quad = [0, u, u | v, v].map(|i| corner(i | side << axis));
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(quad);
            let [a, b, c, d] = [0, 1, 2, 3].map(|i| first + i);
            mesh.triangles.extend(if side == 1 { [[a, b, c], [a, c, d]] } else { [[a, d, b], [b, d, c]] });
        }
        let before = mesh.positions.clone();
        draw_in(&mut mesh, |_| 1e-3);
        for (before, after) in before.iter().zip(&mesh.positions) {
            let expected = *before + (DVec3::splat(0.5) - *before) * 2e-3;
            assert!(after.distance(expected) < 1e-5, "{after} {expected}");
        }
    }
}
