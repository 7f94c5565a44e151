//! What rough specular reflection takes of the light along a direction: the directional albedo of a GGX lobe with a
//! reflectance F of its facets,
//!
//! E(w) = integral of F(w·h) D V |cos| over all other directions.
//!
//! - Schlick's F is linear in f0 and f90, so that E = f0 A + (f90 - f0) B with A that of F = 1, and B that of
//!   F = (1 - cos)^5: a table of two numbers over cosine and roughness, for every index and colour. The table has the
//!   largest A and B from each cosine on, so that the E of the more grazing of two directions stands for both. A dips by
//!   about 0.1 where masking sets in, and is that much too large there; B hardly does.
//! - For any other F a bound: the table has cosines w·h that cut the lobe into parts of known share, and each part counts as
//!   much as the larger F at its two ends. That is never less than E for an F that only falls with the cosine, as Fresnel's
//!   does.
//!
//! Local directions, one roughness for all azimuths.

use std::sync::LazyLock;

use glam::DVec3;

use crate::albedo_table::AlbedoTable;
use crate::fresnel::schlick_weight;
use crate::{Rgb, SMOOTH_ALPHA, ggx};

/// What the tables' albedos are multiplied by: their integration and interpolation err by less.
const MARGIN: f64 = 1.002;

/// Points along each side of the unit square that an entry is integrated over.
const STEPS: u32 = 48;

/// By how much B can exceed (1 - cos)^5 at one cosine, for all roughnesses.
const EXCESS: f64 = 3e-3;

/// B is at most 1 / (1 + this times alpha) at all cosines.
const FALL: f64 = 15.0;

/// Cosines of an entry of [`CUTS`].
const CUT: usize = 9;

/// The lobe's shares up to which [`CUTS`] has its cosines, from the most grazing: F varies fastest there. Total reflection can
/// end anywhere.
const SHARES: [f64; CUT] = [0.0, 0.05, 0.14, 0.27, 0.41, 0.56, 0.71, 0.86, 1.0];

/// A and B, the largest from each cosine on.
static SCHLICK: LazyLock<AlbedoTable<2>> = LazyLock::new(|| {
    AlbedoTable::new(SMOOTH_ALPHA.sqrt(), |cos, roughness| {
        let mut sums = [0.0; 2];
        for_each_facet(cos, roughness * roughness, STEPS, |cos, share| {
            sums[0] += share;
            sums[1] += share * schlick_weight(cos);
        });
        sums
    })
    .falling()
});

/// Cosines of directions with the facets that reflect them, at [`SHARES`] of the lobe.
static CUTS: LazyLock<AlbedoTable<CUT>> = LazyLock::new(|| {
    AlbedoTable::new(SMOOTH_ALPHA.sqrt(), |cos, roughness| {
        let mut facets = Vec::new();
        for_each_facet(cos, roughness * roughness, STEPS, |cos, share| facets.push((cos, share)));
        cuts(facets)
    })
});

/// Goes through facets that reflect light along a direction, by the midpoint rule over the unit square from which visible
/// normals are drawn: the direction's cosine with each, and the share of the light that leaves by it where F = 1.
fn for_each_facet(cos: f64, alpha: f64, steps: u32, mut visit: impl FnMut(f64, f64)) {
    let eye = DVec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
    let half_steps = steps / 2;
    let area = 1.0 / f64::from(steps * half_steps);
    for i in 0..steps {
        for j in 0..half_steps {
            // The other half of the circle is its mirror image.
            let u = [(f64::from(i) + 0.5) / f64::from(steps), (0.5 * f64::from(j) + 0.25) / f64::from(half_steps)];
            let h = ggx::sample_visible(alpha, eye, u);
            let cos = eye.dot(h);
            let light = h * (2.0 * cos) - eye;
            if light.z > 0.0 {
                let shadowing =
                    4.0 * light.z * ggx::visibility(alpha, light, eye) / ggx::masking_over_cosine(alpha, eye);
                visit(cos, area * shadowing);
            }
        }
    }
}

/// The cosines at which a lobe of facets with their shares is cut.
fn cuts(mut facets: Vec<(f64, f64)>) -> [f64; CUT] {
    facets.sort_by(|a, b| a.0.total_cmp(&b.0));
    let whole: f64 = facets.iter().map(|facet| facet.1).sum();
    SHARES.map(|share| {
        let mut below = 0.0;
        let cut = facets.iter().find(|facet| {
            below += facet.1;
            below >= share * whole
        });
        cut.or(facets.last()).map_or(0.0, |facet| facet.0)
    })
}

/// A and B at cosine `cos`, at least those at every larger cosine.
#[inline]
pub(crate) fn schlick(cos: f64, alpha: f64) -> [f64; 2] {
    SCHLICK.at(cos, alpha.sqrt()).map(|value| MARGIN * value)
}

/// At least B at all cosines from `cos` on and for all roughnesses from alpha on, the smooth surface's too; A is at most 1.
#[inline]
pub(crate) fn schlick_at_most(cos: f64, alpha: f64) -> f64 {
    (schlick_weight(cos) + EXCESS).min(1.0 / (1.0 + FALL * alpha))
}

/// At least E at cosine `cos` for facets with a `reflectance` that depends on the cosine with them.
pub(crate) fn at_most(reflectance: impl Fn(f64) -> Rgb, cos: f64, alpha: f64) -> Rgb {
    let roughness = alpha.sqrt();
    let values = CUTS.at(cos, roughness).map(|cut| reflectance(cut.clamp(0.0, 1.0)));
    let mut mean = Rgb::ZERO;
    for (values, shares) in values.windows(2).zip(SHARES.windows(2)) {
        mean += values[0].max(values[1]) * (shares[1] - shares[0]);
    }
    mean * (MARGIN * SCHLICK.at(cos, roughness)[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROUGHNESSES: [f64; 9] = [0.032, 0.05, 0.1, 0.17, 0.23, 0.41, 0.6, 0.8, 1.0];

    fn cosines() -> impl Iterator<Item = f64> {
        (0..=20).map(|i| (f64::from(i) / 20.0 * 0.999 + 0.0007).powi(2))
    }

    /// E by a finer integration.
    fn integral(cos: f64, alpha: f64, reflectance: impl Fn(f64) -> f64) -> f64 {
        let mut sum = 0.0;
        for_each_facet(cos, alpha, 256, |cos, share| sum += share * reflectance(cos));
        sum
    }

    #[test]
    fn the_table_is_the_integral_and_its_margin_is_enough() {
        let (mut largest, mut most) = (0.0_f64, f64::NEG_INFINITY);
        for roughness in ROUGHNESSES {
            let alpha = roughness * roughness;
            let mut before = [f64::INFINITY; 2];
            for cos in cosines() {
                let [a, b] = schlick(cos, alpha);
                assert!(a <= before[0] && b <= before[1], "{cos} {roughness}");
                before = [a, b];
                for f0 in [0.0, 0.04, 0.2] {
                    let exact = integral(cos, alpha, |cos| f0 + (1.0 - f0) * schlick_weight(cos));
                    let table = f0 * a + (1.0 - f0) * b;
                    // Within a degree of the surface masking sets in on the smoothest, and B dips with A.
                    let tolerance = if cos < 2e-2 { 7e-2 } else { 4e-3 };
                    assert!((table - exact).abs() < tolerance + 0.12 * f0, "{f0} {cos} {roughness}: {table} {exact}");
                    largest = largest.max(exact - table);
                }
                most = most.max(b - schlick_at_most(cos, alpha));
            }
        }
        println!("{largest} {most}");
        assert!(largest < 2e-4, "{largest}");
        assert!(most < 0.0, "{most}");
    }

    #[test]
    fn the_bound_holds_and_is_near() {
        // Fresnel's for an index of 1.5 from both sides; from within all light is reflected beyond 41.8 degrees.
        let glass = crate::fresnel::DielectricFresnel::new(1.5, 1.0, Rgb::ONE, true);
        for inside in [false, true] {
            let (mut least, mut sum, mut n) = (1.0_f64, 0.0, 0.0);
            let mut largest = 0.0_f64;
            for cos in cosines() {
                for roughness in ROUGHNESSES {
                    let alpha = roughness * roughness;
                    let exact = integral(cos, alpha, |cos| glass.at(cos, inside).x);
                    let bound = at_most(|cos| glass.at(cos, inside), cos, alpha).x;
                    least = least.min(bound - exact);
                    largest = largest.max(bound - exact);
                    sum += bound - exact;
                    n += 1.0;
                }
            }
            println!("{inside}: {least} {largest} {}", sum / n);
            assert!(least > -2e-4, "{inside}: {least}");
            assert!(largest < 0.16 && sum / n < 0.05, "{inside}: {largest} {}", sum / n);
        }
    }
}
