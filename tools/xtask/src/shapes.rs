//! Closed shapes and quads, wound counter-clockwise seen from outside.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DVec2, DVec3};

/// Triangles with one normal a vertex; faces that should look flat do not share vertices.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    /// Positions in metres.
    pub positions: Vec<DVec3>,
    /// Unit normals.
    pub normals: Vec<DVec3>,
    /// Counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
}

impl Shape {
    /// Adds another shape.
    pub fn add(&mut self, other: &Self) {
        let first = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        self.normals.extend(&other.normals);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + first)));
    }

    /// The shape moved by a rigid transform.
    pub fn moved(mut self, transform: DAffine3) -> Self {
        for p in &mut self.positions {
            *p = transform.transform_point3(*p);
        }
        for n in &mut self.normals {
            *n = transform.transform_vector3(*n).normalize();
        }
        self
    }
}

/// The parallelogram with corner `origin` and sides `u` and `v`; its front is on the side of u x v.
pub fn quad(origin: DVec3, u: DVec3, v: DVec3) -> Shape {
    let normal = u.cross(v).normalize();
    Shape {
        positions: vec![origin, origin + u, origin + u + v, origin + v],
        normals: vec![normal; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// The box between two corners, faces outwards.
pub fn cuboid(low: DVec3, high: DVec3) -> Shape {
    let d = high - low;
    let (x, y, z) = (DVec3::X * d.x, DVec3::Y * d.y, DVec3::Z * d.z);
    let mut shape = Shape::default();
    for face in
        [quad(low, y, x), quad(low, x, z), quad(low, z, y), quad(high, -x, -y), quad(high, -z, -x), quad(high, -y, -z)]
    {
        shape.add(&face);
    }
    shape
}

/// How neighbouring segments of a profile meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// As one curve: normals are averaged.
    Smooth,
    /// With an edge between segments.
    Edged,
}

/// The solid swept by a profile about the y axis. Points of the profile are (radius, height), listed so that the outside
/// lies to the right; it starts and ends on the axis, or closes on itself if its ends coincide.
pub fn revolve(profile: &[DVec2], kind: Profile, steps: u32) -> Shape {
    let segments = profile.len() - 1;
    let segment_normal = |i: usize| {
        let d = profile[i + 1] - profile[i];
        DVec2::new(d.y, -d.x).normalize()
    };
    let closed = profile[0].distance(profile[segments]) < 1e-9;
    // The normal at either end of a segment.
    let normal_at = |i: usize, end: usize| {
        let here = segment_normal(i);
        if kind == Profile::Edged {
            return here;
        }
        let point = i + end;
        if profile[point].x < 1e-9 {
            return DVec2::new(0.0, here.y.signum());
        }
        let before = if point == 0 { if closed { segments - 1 } else { 0 } } else { point - 1 };
        let after = if point == segments { if closed { 0 } else { segments - 1 } } else { point };
        (segment_normal(before) + segment_normal(after)).normalize()
    };
    let mut shape = Shape::default();
    for i in 0..segments {
        let first = shape.positions.len() as u32;
        for step in 0..=steps {
            // The last column repeats the first exactly, so that the seam is watertight.
            let (sin, cos) = (TAU * f64::from(step % steps) / f64::from(steps)).sin_cos();
            for end in 0..2 {
                let p = profile[i + end];
                let n = normal_at(i, end);
                shape.positions.push(DVec3::new(p.x * cos, p.y, -p.x * sin));
                shape.normals.push(DVec3::new(n.x * cos, n.y, -n.x * sin));
            }
        }
        for step in 0..steps {
            let at = |column: u32, end: u32| first + 2 * (step + column) + end;
            if profile[i].x > 1e-9 {
                shape.triangles.push([at(0, 0), at(1, 0), at(1, 1)]);
            }
            if profile[i + 1].x > 1e-9 {
                shape.triangles.push([at(0, 0), at(1, 1), at(0, 1)]);
            }
        }
    }
    shape
}

/// A sphere of the given radius, resting on y = 0.
pub fn resting_sphere(radius: f64, rings: u32) -> Shape {
    let profile: Vec<DVec2> = (0..=rings)
        .map(|i| {
            let angle = PI * f64::from(i) / f64::from(rings);
            // Exactly on the axis at both ends.
            let x = if i == 0 || i == rings { 0.0 } else { radius * angle.sin() };
            DVec2::new(x, radius - radius * angle.cos())
        })
        .collect();
    revolve(&profile, Profile::Smooth, 2 * rings)
}

/// A torus about the y axis, resting on y = 0.
pub fn resting_torus(major: f64, minor: f64, steps: u32) -> Shape {
    let profile: Vec<DVec2> = (0..=steps)
        .map(|i| {
            let angle = TAU * f64::from(i % steps) / f64::from(steps);
            DVec2::new(major + minor * angle.cos(), minor + minor * angle.sin())
        })
        .collect();
    revolve(&profile, Profile::Smooth, 2 * steps)
}

/// A closed body of water: a wavy top over the square of half side `half`, vertical sides, a flat bottom.
///
/// `height` gives the surface's height and its two slopes at (x, z).
pub fn water_body(half: f64, bottom: f64, steps: u32, height: impl Fn(f64, f64) -> (f64, DVec2)) -> Shape {
    let mut shape = Shape::default();
    let at = |i: u32| -half + 2.0 * half * f64::from(i) / f64::from(steps);
    for j in 0..=steps {
        for i in 0..=steps {
            let (y, slope) = height(at(i), at(j));
            shape.positions.push(DVec3::new(at(i), y, at(j)));
            shape.normals.push(DVec3::new(-slope.x, 1.0, -slope.y).normalize());
        }
    }
    let index = |i: u32, j: u32| j * (steps + 1) + i;
    for j in 0..steps {
        for i in 0..steps {
            shape.triangles.push([index(i, j), index(i, j + 1), index(i + 1, j + 1)]);
            shape.triangles.push([index(i, j), index(i + 1, j + 1), index(i + 1, j)]);
        }
    }
    // One strip a side, top edge shared in position with the surface; (i, j) runs so that the outside is to the right.
    type Edge = fn(u32, u32) -> (u32, u32);
    let sides: [(Edge, DVec3); 4] = [
        (|k, n| (k, n), DVec3::Z),
        (|k, n| (n, n - k), DVec3::X),
        (|k, n| (n - k, 0), DVec3::NEG_Z),
        (|k, _| (0, k), DVec3::NEG_X),
    ];
    for (edge, normal) in sides {
        let first = shape.positions.len() as u32;
        for k in 0..=steps {
            let (i, j) = edge(k, steps);
            let top = shape.positions[index(i, j) as usize];
            shape.positions.extend([top, DVec3::new(top.x, bottom, top.z)]);
            shape.normals.extend([normal; 2]);
        }
        for k in 0..steps {
            let at = |step: u32, low: u32| first + 2 * (k + step) + low;
            shape.triangles.push([at(0, 0), at(0, 1), at(1, 1)]);
            shape.triangles.push([at(0, 0), at(1, 1), at(1, 0)]);
        }
    }
    // The bottom repeats the grid's rim only, as a fan about its middle.
    let first = shape.positions.len() as u32;
    shape.positions.push(DVec3::new(0.0, bottom, 0.0));
    shape.normals.push(DVec3::NEG_Y);
    let mut rim = 0;
    for (edge, _) in sides {
        for k in 0..steps {
            let (i, j) = edge(k, steps);
            shape.positions.push(DVec3::new(at(i), bottom, at(j)));
            shape.normals.push(DVec3::NEG_Y);
            rim += 1;
        }
    }
    for k in 0..rim {
        shape.triangles.push([first, first + 1 + (k + 1) % rim, first + 1 + k]);
    }
    shape
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;

    /// The volume enclosed, by the divergence theorem; positive when the faces look outwards.
    fn signed_volume(shape: &Shape) -> f64 {
        let corner = |i: u32| shape.positions[i as usize];
        shape.triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c))) / 6.0).sum()
    }

    /// Every edge once in each direction, corners compared by position.
    fn is_watertight(shape: &Shape) -> bool {
        let key = |i: u32| shape.positions[i as usize].to_array().map(|c| (c * 1e9).round() as i64);
        let mut edges: HashMap<_, i32> = HashMap::new();
        for t in &shape.triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                let (a, b) = (key(a), key(b));
                *edges.entry(if a < b { (a, b) } else { (b, a) }).or_default() += if a < b { 1 } else { -1 };
            }
        }
        edges.values().all(|&balance| balance == 0)
    }

    fn normals_agree(shape: &Shape) -> bool {
        shape.triangles.iter().all(|t| {
            let [a, b, c] = t.map(|i| shape.positions[i as usize]);
            let face = (b - a).cross(c - a);
            t.iter().all(|&i| shape.normals[i as usize].dot(face) > 0.0)
        })
    }

    #[test]
    fn closed_shapes_are_watertight_and_look_outwards() {
        let square = [(0.5, 0.0), (1.0, 0.0), (1.0, 0.3), (0.5, 0.3), (0.5, 0.0)].map(DVec2::from);
        for (name, shape, volume) in [
            ("cuboid", cuboid(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)), 6.0),
            ("sphere", resting_sphere(1.0, 48), 4.0 / 3.0 * PI),
            ("torus", resting_torus(1.0, 0.25, 48), 2.0 * PI * PI * 0.0625),
            ("ring", revolve(&square, Profile::Edged, 128), PI * 0.75 * 0.3),
            ("water", water_body(1.0, -1.0, 16, |_, _| (0.0, DVec2::ZERO)), 4.0),
        ] {
            assert!(is_watertight(&shape), "{name}");
            assert!(normals_agree(&shape), "{name}");
            let measured = signed_volume(&shape);
            assert!((measured / volume - 1.0).abs() < 0.01, "{name}: {measured} {volume}");
        }
    }
}
