//! Normal maps: the shading normal from a texture in tangent space (glTF 2.0, section 3.9.3).

use ergodic_geometry::Surface;
use glam::{DVec3, DVec4};

/// Cosine that a mapped normal keeps with the geometric normal at least.
const LEAST_COSINE: f64 = 0.01;

/// The shading normal that `texel` asks for at `surface`, on the geometric normal's side. Without tangents the
/// interpolated normal stays.
pub(crate) fn apply(surface: &Surface, texel: DVec4, scale: f64) -> DVec3 {
    let n = surface.ns;
    if surface.bitangent_sign == 0.0 {
        return keep_above(n, surface.ng);
    }
    let t = surface.tangent;
    let b = n.cross(t) * surface.bitangent_sign;
    let tangent_space = texel.truncate() * 2.0 - 1.0;
    let mapped = t * (tangent_space.x * scale) + b * (tangent_space.y * scale) + n * tangent_space.z;
    keep_above(mapped.normalize_or(n), surface.ng)
}

/// Bends a unit normal just far enough to lie above the surface.
pub(crate) fn keep_above(n: DVec3, ng: DVec3) -> DVec3 {
    let cos = n.dot(ng);
    if cos >= LEAST_COSINE { n } else { (n + ng * (LEAST_COSINE - cos)).normalize_or(ng) }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    fn surface(ns: DVec3) -> Surface {
        Surface {
            position: DVec3::ZERO,
            ng: DVec3::Z,
            ns,
            tangent: DVec3::X,
            bitangent_sign: -1.0,
            texcoords: [DVec2::ZERO; 2],
            color: DVec4::ONE,
            instance: 0,
            triangle: 0,
        }
    }

    #[test]
    fn the_flat_texel_leaves_the_normal_and_the_axes_lean_it() {
        let at = |x: f64, y: f64, z: f64, scale| apply(&surface(DVec3::Z), DVec4::new(x, y, z, 1.0), scale);
        assert!((at(0.5, 0.5, 1.0, 1.0) - DVec3::Z).length() < 1e-12);
        assert!((at(0.8, 0.5, 0.9, 1.0) - DVec3::new(0.6, 0.0, 0.8)).length() < 1e-12);
        // The bitangent's sign is -1: +y of the texture is -y here.
        assert!((at(0.5, 0.8, 0.9, 1.0) - DVec3::new(0.0, -0.6, 0.8)).length() < 1e-12);
        assert!(at(0.8, 0.5, 0.9, 0.5).x < 0.6);
    }

    #[test]
    fn a_normal_that_points_below_is_bent_to_just_above() {
        let down = apply(&surface(DVec3::Z), DVec4::new(1.0, 0.5, 0.3, 1.0), 1.0);
        assert!((down.dot(DVec3::Z) - LEAST_COSINE).abs() < 1e-3 && down.x > 0.9 && down.is_normalized());
        assert_eq!(keep_above(DVec3::NEG_Z, DVec3::Z), DVec3::Z);
    }

    #[test]
    fn without_tangents_the_normal_stays() {
        let ns = DVec3::new(0.6, 0.0, 0.8);
        let flat = Surface { bitangent_sign: 0.0, ..surface(ns) };
        assert_eq!(apply(&flat, DVec4::new(1.0, 0.5, 0.7, 1.0), 1.0), ns);
    }
}
