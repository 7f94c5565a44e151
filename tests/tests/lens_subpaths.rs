//! Planted faults of the lens subpath mutation; `mutation_laws` and `volume_laws` have its laws.

use ergodic_metropolis::{Mixture, Mutation, RandomSource};
use ergodic_mutations::{AnyMutation, LensSubpath, Rejection, Splice};
use ergodic_pathspace::{Lengths, Path, PathSpace};
use ergodic_scattering::{Component, Material, Rgb};
use ergodic_tests::{Eye, cuboid, description_of, diffuse, nightly, quad, space, view_of};
use glam::DVec3;

use crate::mutation_laws::{ALPHA, CAUGHT, SIZE, check_kernels, drift_of, drifts};

/// Short paths only: longer ones come with weights so uneven that they hide what these show.
const SHORT: Lengths = Lengths { min_edges: 1, max_edges: 5 };

fn lens_subpath() -> Vec<AnyMutation> {
    vec![AnyMutation::LensSubpath(LensSubpath {})]
}

/// The probability that a lens subpath of `path` is left through vertex `i` as it is.
fn probability_at(path: &Path, i: usize) -> f64 {
    let [reflection, transmission] = path.vertices[i].interaction.dirac_probabilities(path.edges[i].direction);
    match path.vertices[i].component {
        Component::DiracReflection => reflection,
        Component::DiracTransmission => transmission,
        Component::Rough => 1.0 - reflection - transmission,
    }
}

#[test]
fn a_forgotten_probability_of_a_dirac_component_is_caught() {
    let forgotten = |_: &Path, to: &Path, (_, plan): (usize, Splice)| {
        -(plan.prefix + 1..to.length()).map(|i| probability_at(to, i).ln()).sum::<f64>()
    };
    let t = drift_of(&space("glass", SIZE, SHORT), lens_subpath(), nightly(200_000, 2_000_000), &forgotten);
    assert!(t > CAUGHT, "{t}");
}

/// A room with a floor of polished grit, half of it a mirror, which ends some of the subpaths and mirrors the others.
fn polished_room() -> PathSpace {
    let grit = Material { metallic: 0.5, roughness: 0.0, base_color: Rgb::splat(0.8), ..Material::default() };
    let things = vec![
        (cuboid(DVec3::ONE, true), diffuse(0.6, 0.0)),
        (quad(DVec3::new(-0.4, -0.4, 0.98), DVec3::Y * 0.8, DVec3::X * 0.8), diffuse(0.0, 6.0)),
        (quad(DVec3::new(-1.0, -1.0, -0.9), DVec3::X * 2.0, DVec3::Y * 2.0), grit),
    ];
    let eye = Eye { from: DVec3::new(0.0, -0.9, 0.0), at: DVec3::new(0.0, 0.3, -0.3), up: DVec3::Z, fov: 1.4 };
    PathSpace { scene: view_of(description_of(things, Vec::new(), &eye), SIZE), lengths: SHORT }
}

#[test]
fn a_forgotten_probability_of_ending_is_caught() {
    let space = polished_room();
    let samples = nightly(50_000, 500_000);
    check_kernels("polished", &space, samples);
    let forgotten = |_: &Path, to: &Path, (_, plan): (usize, Splice)| -probability_at(to, plan.prefix).ln();
    let t = drift_of(&space, lens_subpath(), samples, &forgotten);
    assert!(t > CAUGHT, "{t}");
}

/// Image points of one stratum only, wherever the path is. The density is that of the stratum, the same for both paths; that nothing leads
/// back out of it is forgotten.
#[derive(Clone, Copy)]
struct OneStratum;

impl Mutation for OneStratum {
    type Space = PathSpace;
    type State = Path;
    type Plan = Splice;
    type Failure = Rejection;

    fn suitability(&self, space: &PathSpace, x: &Path) -> f64 {
        LensSubpath {}.suitability(space, x)
    }

    fn propose(
        &self,
        space: &PathSpace,
        x: &Path,
        y: &mut Path,
        rng: &mut impl RandomSource,
    ) -> Result<Splice, Rejection> {
        let plan = LensSubpath {}.propose(space, x, y, rng)?;
        let in_stratum = y.raster.is_some_and(|raster| raster.x < 0.5 * f64::from(SIZE.0));
        if in_stratum { Ok(plan) } else { Err(Rejection::OffFilm) }
    }

    fn ln_density(&self, space: &PathSpace, from: &Path, to: &Path, plan: Splice) -> f64 {
        LensSubpath {}.ln_density(space, from, to, plan)
    }
}

#[test]
fn a_stratum_without_a_way_back_is_caught() {
    let space = space("cornell", SIZE, SHORT);
    let kernel = Mixture::new(vec![(1.0, OneStratum)]).expect("a positive weight");
    let (law, flow) = &drifts(&space, &[kernel], nightly(50_000, 500_000), 29)[0];
    let (t, balance) = (law.verdict(ALPHA).max_t, flow.verdict());
    println!("one stratum: max |t| = {t:.1}, Q = {:.0} of {:.0}", balance.q, balance.limit);
    assert!(t > CAUGHT && !balance.holds, "{t}, {balance:?}");
}
