//! The volume law through mirrors: the density of a perturbation is that of its sampler, carried to the surfaces by a
//! Jacobian that is known in closed form.
//!
//! A flat mirror unfolds: seen through it, a point at distances d₁ to the mirror and d₂ behind it is one at d₁ + d₂. So the
//! area density of a point reached through the mirror is p_ω cos θ / (d₁ + d₂)², whatever the code says. The code's own
//! density counts the mirror as a vertex with its delta divided out in projected solid angle; the ratio of the two is
//! (cos θₛ / d₁²) cos θₛ (1 / d₂²) (d₁ + d₂)².

use ergodic_metropolis::Mutation;
use ergodic_mutations::{AnyMutation, Caustic, Lens, LensSubpath, MultiChain, Splice};
use ergodic_pathspace::{CameraDescription, Lengths, Path, PathSpace, Placement, SceneDescription};
use ergodic_render::{Purpose, stream};
use ergodic_scattering::{Component, Material, Rgb};
use ergodic_tests::{PathSource, quad, view_of};
use glam::{DAffine3, DMat3, DVec3};

const SIZE: (u32, u32) = (64, 64);

/// A diffuse floor under a mirror, lit from the side; the camera looks up to the mirror or down to the floor.
fn hall(length: usize, up: bool) -> PathSpace {
    let diffuse = Material { metallic: 0.0, specular: 0.0, base_color: Rgb::splat(0.7), ..Material::default() };
    let mirror = Material { metallic: 1.0, roughness: 0.0, ..Material::default() };
    let lamp = Material { emission: Rgb::splat(5.0), base_color: Rgb::ZERO, ..diffuse.clone() };
    let meshes = vec![
        quad(DVec3::new(-4.0, 0.0, -4.0), DVec3::Z * 8.0, DVec3::X * 8.0),
        quad(DVec3::new(-4.0, 1.0, -4.0), DVec3::X * 8.0, DVec3::Z * 8.0),
        quad(DVec3::new(-4.0, 0.1, -4.0), DVec3::Y * 0.8, DVec3::Z * 8.0),
    ];
    let placements = (0..3).map(|i| Placement { mesh: i, material: i, transform: DAffine3::IDENTITY }).collect();
    let z = DVec3::new(0.0, if up { -0.5 } else { 0.2 }, 1.0).normalize();
    let matrix3 = DMat3::from_cols(DVec3::X, z.cross(DVec3::X), z);
    let transform = DAffine3 { matrix3, translation: DVec3::new(0.0, 0.4, 2.5) };
    let cameras = vec![CameraDescription::pinhole(transform, 0.6)];
    let materials = vec![diffuse, mirror, lamp];
    let description = SceneDescription { meshes, placements, materials, cameras, ..SceneDescription::default() };
    PathSpace { scene: view_of(description, SIZE), lengths: Lengths { min_edges: length, max_edges: length } }
}

/// The ratio of the code's density of a vertex, reached through the mirror at vertex `mirror`, to its area density.
fn unfolding(y: &Path, reached: usize, mirror: usize) -> f64 {
    let from = 2 * mirror - reached;
    let [reached, mirror, from] = [reached, mirror, from].map(|i| y.vertices[i].position);
    let (d1, d2) = (mirror.distance(from), mirror.distance(reached));
    let cos = (mirror - from).normalize().y.abs();
    (cos / (d1 * d1)) * cos * (1.0 / (d2 * d2)) * (d1 + d2).powi(2)
}

/// A square patch of the floor beside a vertex that is reached through a mirror.
#[derive(Clone, Copy)]
struct Patch {
    /// The vertex.
    reached: usize,
    /// The vertex on the mirror.
    mirror: usize,
    middle: DVec3,
    half: f64,
}

impl Patch {
    /// With its middle `shift` metres beside the vertex, and 2 `half` metres wide.
    fn beside(space: &PathSpace, x: &Path, (reached, mirror): (usize, usize), shift: f64, half: f64) -> Self {
        let scale = space.scene.scale();
        let middle = x.vertices[reached].position + DVec3::X * (shift * scale);
        Self { reached, mirror, middle, half: half * scale }
    }

    fn holds(&self, y: &Path) -> bool {
        let d = y.vertices[self.reached].position - self.middle;
        d.x.abs() < self.half && d.z.abs() < self.half && d.y.abs() < 1e-9
    }

    fn area(&self) -> f64 {
        4.0 * self.half * self.half
    }
}

/// E[1 / T, y in the patches] times `jacobian`, which must be the area of the patches; with its standard error.
fn measured(
    space: &PathSpace,
    mutation: &AnyMutation,
    x: &Path,
    plan: Splice,
    patches: &[Patch],
    proposals: u32,
    jacobian: impl Fn(&Path) -> f64,
) -> (f64, f64) {
    let mut rng = stream(53, Purpose::Chain, 6);
    let mut y = Path::default();
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..proposals {
        if mutation.propose(space, x, &mut y, &mut rng) == Ok(plan) && patches.iter().all(|patch| patch.holds(&y)) {
            let weight = (-mutation.ln_density(space, x, &y, plan)).exp() * jacobian(&y);
            sum += weight;
            squares += weight * weight;
        }
    }
    let n = f64::from(proposals);
    let mean = sum / n;
    (mean, ((squares / n - mean * mean) / n).sqrt())
}

/// The first drawn path of a class whose floor vertices lie well inside the hall.
fn path_of(space: &PathSpace, class: &str) -> Path {
    let mut source = PathSource::new(space);
    let mut rng = stream(59, Purpose::Chain, 7);
    let mut x = Path::default();
    let found = (0..1_000_000).any(|_| {
        source.draw(&mut x, &mut rng).is_some()
            && x.class().to_string() == class
            && x.vertices[1..x.length()].iter().all(|v| {
                // The file's origin is the middle of the hall along x and z.
                let p = v.position / space.scene.scale();
                v.component != Component::Rough || p.x.abs() < 0.6 && p.z.abs() < 2.0
            })
    });
    assert!(found, "no path {class}");
    x
}

fn check(space: &PathSpace, mutation: AnyMutation, x: &Path, plan: Splice, patches: &[Patch], proposals: u32) {
    let jacobian = |y: &Path| patches.iter().map(|p| unfolding(y, p.reached, p.mirror)).product::<f64>();
    let area: f64 = patches.iter().map(Patch::area).product();
    let (found, error) = measured(space, &mutation, x, plan, patches, proposals, jacobian);
    println!("{} on {}: {found:.4e} +- {error:.1e}, area {area:.4e}", mutation.name(), x.class());
    assert!(error < 0.06 * area, "{}: too few samples, {error}", mutation.name());
    assert!((found - area).abs() < 5.0 * error, "{}: {found} +- {error}, want {area}", mutation.name());
    // Without the mirror's own factor the law fails.
    let faulty = |y: &Path| {
        let into_mirror = &y.edges[patches[0].mirror];
        jacobian(y) / into_mirror.direction.y.abs()
    };
    let (found, error) = measured(space, &mutation, x, plan, patches, proposals, faulty);
    assert!((found - area).abs() > 5.0 * error, "{}: the planted fault passes", mutation.name());
}

#[test]
fn a_lens_perturbation_through_a_mirror_has_the_density_of_its_sampler() {
    let space = hall(3, true);
    let x = path_of(&space, "LDSE");
    let plan = Splice { prefix: 1, suffix: 1 };
    let patches = [Patch::beside(&space, &x, (1, 2), 0.05, 0.03)];
    check(&space, AnyMutation::Lens(Lens::default()), &x, plan, &patches, 300_000);
}

#[test]
fn a_lens_subpath_through_a_mirror_has_the_density_of_its_sampler() {
    let space = hall(3, true);
    let x = path_of(&space, "LDSE");
    let plan = Splice { prefix: 1, suffix: 1 };
    // Anywhere on the image, so that a larger patch is met often enough.
    let patches = [Patch::beside(&space, &x, (1, 2), 0.15, 0.12)];
    check(&space, AnyMutation::LensSubpath(LensSubpath {}), &x, plan, &patches, 600_000);
}

#[test]
fn a_caustic_perturbation_through_a_mirror_has_the_density_of_its_sampler() {
    let space = hall(3, false);
    let x = path_of(&space, "LSDE");
    let plan = Splice { prefix: 1, suffix: 1 };
    let patches = [Patch::beside(&space, &x, (2, 1), 0.05, 0.03)];
    check(&space, AnyMutation::Caustic(Caustic::default()), &x, plan, &patches, 300_000);
}

#[test]
fn a_multi_chain_perturbation_has_the_density_of_its_sampler() {
    let space = hall(5, true);
    let x = path_of(&space, "LDSDSE");
    let plan = Splice { prefix: 1, suffix: 1 };
    let patches = [Patch::beside(&space, &x, (3, 4), 0.04, 0.025), Patch::beside(&space, &x, (1, 2), 0.08, 0.025)];
    check(&space, AnyMutation::MultiChain(MultiChain::default()), &x, plan, &patches, 4_000_000);
}
