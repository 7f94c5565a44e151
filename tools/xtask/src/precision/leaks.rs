//! The watertight test against a plain one: time, and rays that slip between the triangles of a closed mesh.

use std::collections::HashMap;
use std::hint::black_box;

use ergodic_assess::accuracy::{mean, ratio};
use ergodic_geometry::{Instance, Isa, Mesh, Ray, World};
use glam::{DAffine3, DVec3};

use super::Effort;
use super::kernels::{double, single};
use super::page::{Section, cell, short, table};
use super::work::{Inputs, in_turns};

/// Times that each triangle of the octahedron is cut into four.
const SUBDIVISIONS: usize = 3;
/// Tests of a round for times.
const TESTS: usize = 4096;
const PASSES: usize = 40;
/// Size of their triangles, at distances of 1.
const SIZE: f64 = 0.8;
/// Rays that the whole search is asked, of those that the tests are.
const SEARCHED: usize = 10;

/// A closed mesh with the triangles around each vertex.
struct Ball {
    vertices: Vec<DVec3>,
    triangles: Vec<[usize; 3]>,
    around: Vec<Vec<usize>>,
    edges: Vec<[usize; 2]>,
}

impl Ball {
    /// A unit sphere about `centre`, from an octahedron that is turned so that no edge lies along an axis.
    fn new(centre: DVec3) -> Self {
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 0.7, 1.1);
        let mut vertices: Vec<DVec3> = [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z].into();
        let mut triangles: Vec<[usize; 3]> =
            [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]].into();
        for _ in 0..SUBDIVISIONS {
            let mut middles: HashMap<[usize; 2], usize> = HashMap::new();
            let mut finer = Vec::new();
            for [a, b, c] in triangles {
                let mut middle = |i: usize, j: usize| {
                    *middles.entry([i.min(j), i.max(j)]).or_insert_with(|| {
                        vertices.push((vertices[i] + vertices[j]).normalize());
                        vertices.len() - 1
                    })
                };
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
            }
            triangles = finer;
        }
        let vertices: Vec<DVec3> = vertices.into_iter().map(|vertex| centre + turn * vertex).collect();
        let mut around = vec![Vec::new(); vertices.len()];
        let mut edges = Vec::new();
        for (index, triangle) in triangles.iter().enumerate() {
            for i in 0..3 {
                around[triangle[i]].push(index);
                let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
                if a < b {
                    edges.push([a, b]);
                }
            }
        }
        Self { vertices, triangles, around, edges }
    }

    /// The triangles around both ends of an edge, those at the edge first.
    fn near(&self, [a, b]: [usize; 2]) -> Vec<usize> {
        let mut near: Vec<usize> = self.around[a].iter().filter(|t| self.around[b].contains(t)).copied().collect();
        for triangle in self.around[a].iter().chain(&self.around[b]) {
            if !near.contains(triangle) {
                near.push(*triangle);
            }
        }
        near
    }

    fn corners(&self, triangles: &[usize]) -> Vec<[DVec3; 3]> {
        triangles.iter().map(|triangle| self.triangles[*triangle].map(|vertex| self.vertices[vertex])).collect()
    }

    fn mesh(&self) -> Mesh {
        let triangles = self.triangles.iter().map(|t| t.map(|i| i as u32)).collect();
        Mesh { positions: self.vertices.clone(), triangles, ..Mesh::default() }
    }
}

/// Rays through points of edges; every tenth through a vertex.
struct Aim {
    ball: Ball,
    /// From inside, or from this far away.
    distance: Option<f64>,
    centre: DVec3,
}

/// Rays that meet none of the triangles around the edge at which they are aimed, by test.
#[derive(Default)]
struct Leaks {
    plain_single: u64,
    plain_double: u64,
    watertight_single: u64,
    watertight_double: u64,
    /// Of fewer rays, through the search of whole scenes.
    search: u64,
}

impl Aim {
    fn leaks(&self, rays: usize) -> Result<Leaks, String> {
        let mut random = Inputs::new(2);
        let instance = Instance { mesh: 0, transform: DAffine3::IDENTITY };
        let world = World::build(vec![self.ball.mesh()], vec![instance]).map_err(|e| e.to_string())?;
        let near: Vec<Vec<usize>> = self.ball.edges.iter().map(|edge| self.ball.near(*edge)).collect();
        let doubles: Vec<Vec<[double::V; 3]>> = near.iter().map(|near| self.ball.corners(near)).collect();
        let singles: Vec<Vec<[single::V; 3]>> =
            doubles.iter().map(|near| near.iter().map(|corner| corner.map(single::vector)).collect()).collect();
        let mut leaks = Leaks::default();
        for i in 0..rays {
            let (edge, origin) = self.edge_and_origin(&mut random);
            let [a, b] = self.ball.edges[edge].map(|vertex| self.ball.vertices[vertex]);
            let share = if i % 10 == 0 { 0.0 } else { random.uniform() };
            let direction = (a + (b - a) * share - origin).normalize();
            let (triangles, rounded) = (&doubles[edge], &singles[edge]);
            let sheared = double::Sheared::new(origin, direction);
            leaks.plain_double += u64::from(triangles.iter().all(|t| double::plain(origin, direction, t).is_none()));
            leaks.watertight_double += u64::from(triangles.iter().all(|t| sheared.cross(t).is_none()));
            // The same with everything rounded to f32, the direction from rounded points.
            let (from, [a, b]) = (single::vector(origin), [a, b].map(single::vector));
            let towards = (a + (b - a) * single::number(share) - from).normalize();
            let sheared = single::Sheared::new(from, towards);
            leaks.plain_single += u64::from(rounded.iter().all(|t| single::plain(from, towards, t).is_none()));
            leaks.watertight_single += u64::from(rounded.iter().all(|t| sheared.cross(t).is_none()));
            if i % SEARCHED == 0 {
                leaks.search += u64::from(world.intersect(&Ray { origin, direction }).is_none());
            }
        }
        Ok(leaks)
    }

    /// An edge, and from where a ray that is aimed at it must hit the mesh there.
    fn edge_and_origin(&self, random: &mut Inputs) -> (usize, DVec3) {
        loop {
            let edge = ((random.uniform() * self.ball.edges.len() as f64) as usize).min(self.ball.edges.len() - 1);
            let Some(distance) = self.distance else {
                return (edge, self.centre + random.point(0.4));
            };
            // From the side that the edge faces, as the silhouette may be missed with good reason.
            let outward = random.direction();
            let middle = self.ball.edges[edge].map(|vertex| self.ball.vertices[vertex] - self.centre);
            if (middle[0] + middle[1]).dot(outward) > 1.0 {
                return (edge, self.centre + outward * distance);
            }
        }
    }
}

/// The interval of 95 % of a share of which none, or some, of `n` were seen: Wilson's.
fn wilson(seen: u64, n: usize) -> (f64, f64) {
    let (n, z) = (n as f64, 1.96);
    let share = seen as f64 / n;
    let centre = (share + z * z / (2.0 * n)) / (1.0 + z * z / n);
    let half = z / (1.0 + z * z / n) * (share * (1.0 - share) / n + z * z / (4.0 * n * n)).sqrt();
    (if seen == 0 { 0.0 } else { (centre - half).max(0.0) }, centre + half)
}

fn leak_cell(seen: u64, n: usize) -> String {
    let (low, high) = wilson(seen, n);
    format!("{} ({} to {})", short(seen as f64 / n as f64), short(low), short(high))
}

fn times(effort: &Effort) -> Vec<Vec<String>> {
    let mut random = Inputs::new(3);
    let tests: Vec<(DVec3, DVec3, [DVec3; 3])> = (0..TESTS)
        .map(|_| {
            let (origin, direction) = (random.point(1.0), random.direction());
            let middle = origin + direction;
            (origin, direction, std::array::from_fn(|_| middle + random.direction() * SIZE))
        })
        .collect();
    let watertight_all = |new_ray: bool| {
        let mut hits = 0;
        for _ in 0..PASSES {
            let mut sheared = double::Sheared::new(tests[0].0, tests[0].1);
            for (i, (origin, direction, triangle)) in black_box(&tests[..]).iter().enumerate() {
                // A ray is made ready once and asks some triangles.
                if new_ray || i % 8 == 0 {
                    sheared = double::Sheared::new(*origin, *direction);
                }
                hits += usize::from(sheared.cross(triangle).is_some());
            }
        }
        black_box(hits);
    };
    let plain_all = |new_ray: bool| {
        let mut hits = 0;
        for _ in 0..PASSES {
            let mut ray = (tests[0].0, tests[0].1);
            for (i, (origin, direction, triangle)) in black_box(&tests[..]).iter().enumerate() {
                if new_ray || i % 8 == 0 {
                    ray = (*origin, *direction);
                }
                hits += usize::from(double::plain(ray.0, ray.1, triangle).is_some());
            }
        }
        black_box(hits);
    };
    [("a new ray for each triangle", true), ("8 triangles a ray", false)]
        .into_iter()
        .map(|(name, new_ray)| {
            let [one, other] = in_turns(effort.rounds, || watertight_all(new_ray), || plain_all(new_ray));
            let each = |times: &[f64]| {
                mean(&times.iter().map(|time| time * 1e9 / (TESTS * PASSES) as f64).collect::<Vec<_>>())
            };
            vec![name.into(), cell(each(&one)), cell(each(&other)), cell(ratio(&one, &other))]
        })
        .collect()
}

/// Measures times and leaks.
pub fn measure(effort: &Effort) -> Result<Section, String> {
    let away = DVec3::new(1000.0, -700.0, 400.0);
    let aims = [
        ("from inside", DVec3::ZERO, None),
        ("from 1e4 radii away", DVec3::ZERO, Some(1e4)),
        ("from inside, 1e3 radii from the origin", away, None),
    ];
    let mut rows = Vec::new();
    for (name, centre, distance) in aims {
        let leaks = Aim { ball: Ball::new(centre), distance, centre }.leaks(effort.rays)?;
        let cell = |seen: u64| leak_cell(seen, effort.rays);
        rows.push(vec![
            name.into(),
            cell(leaks.plain_single),
            cell(leaks.plain_double),
            cell(leaks.watertight_single),
            cell(leaks.watertight_double),
            leak_cell(leaks.search, effort.rays.div_ceil(SEARCHED)),
        ]);
    }
    let heads = [
        "rays",
        "plain f32",
        "plain f64",
        "watertight f32",
        "watertight f64",
        "search of a scene, a tenth of the rays",
    ];
    Ok(Section {
        title: "Watertight against plain intersection",
        parts: vec![
            "*Watertight*: Woop, Benthin and Wald (2013), as the search does it. *Plain*: Möller and Trumbore (1997). Both in f64, one \
             triangle at a\ntime, of rays of which some hit and most do not."
                .into(),
            table(&["time of a test, ns", "watertight", "plain", "watertight over plain"], &times(effort)),
            format!(
                "{} rays through points of the edges of a closed ball of {} triangles, every tenth through a vertex, against the \
                 triangles around\nthe edge: the share that met none, with Wilson's interval. In f32 the mesh is rounded too. The search\nhas the wide boxes of the tree in front of the test, by the instructions {}.",
                effort.rays,
                Ball::new(DVec3::ZERO).triangles.len(),
                Isa::best().name(),
            ),
            table(&heads, &rows),
            "Rays that are aimed at edges are the worst case. One that is drawn at random comes as near to an edge as rounding is \
             large: about once\nin 1e6 for f32 and once in 1e15 for f64. But perturbations keep paths where they are, edges of a mesh \
             are where its vertices are, and\na chain that found a leak to a bright light would stay. So the search is watertight, \
             and tests four triangles at once, which makes up for\nsome of the price."
                .into(),
        ],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hole_is_seen_as_leaks() {
        let mut ball = Ball::new(DVec3::ZERO);
        assert_eq!(ball.triangles.len(), 8 << (2 * SUBDIVISIONS));
        assert_eq!(ball.edges.len(), ball.triangles.len() * 3 / 2);
        assert_eq!(ball.vertices.len(), ball.edges.len() - ball.triangles.len() + 2, "Euler's formula");
        let closed = Aim { ball: Ball::new(DVec3::ZERO), distance: None, centre: DVec3::ZERO }.leaks(5000).unwrap();
        assert_eq!((closed.watertight_double, closed.watertight_single, closed.search), (0, 0, 0));
        // Triangles drawn in by a little leave their edges open.
        let open = ball.triangles.clone();
        let corners: Vec<DVec3> = open
            .iter()
            .flat_map(|t| {
                let corner = t.map(|i| ball.vertices[i]);
                let middle = (corner[0] + corner[1] + corner[2]) / 3.0;
                corner.map(|c| c + (middle - c) * 1e-6)
            })
            .collect();
        // The same fans, but each triangle with corners of its own.
        let world = Mesh {
            positions: corners,
            triangles: (0..open.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            ..Mesh::default()
        };
        let instance = Instance { mesh: 0, transform: DAffine3::IDENTITY };
        let world = World::build(vec![world], vec![instance]).unwrap();
        let [a, b] = ball.edges.pop().unwrap().map(|vertex| ball.vertices[vertex]);
        let direction = (a + (b - a) * 0.4).normalize();
        assert!(world.intersect(&Ray { origin: DVec3::ZERO, direction }).is_none());
    }

    #[test]
    fn intervals_of_shares_hold_them() {
        let (low, high) = wilson(0, 1_000_000);
        assert!(low == 0.0 && (3e-6..5e-6).contains(&high));
        let (low, high) = wilson(100, 10_000);
        assert!((low - 0.0082).abs() < 2e-4 && (high - 0.0121).abs() < 2e-4, "{low} {high}");
    }
}
