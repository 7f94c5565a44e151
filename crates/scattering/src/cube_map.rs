//! Cube maps: radiance from every direction as six square images, one a face of a cube about the scene.
//!
//! Faces come in the order +x, -x, +y, -y, +z, -z. Seen from the centre, with the eyes of a right-handed world, no image is mirrored.
//! The images of the four sides have +y at their top; the top of that of +y is towards -z, and of that of -y towards +z.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};

use crate::{Environment, Rgb};

/// Radiance that is constant over each texel of a cube.
#[derive(Clone, Debug)]
pub struct CubeMap {
    side: usize,
    /// Face by face, row by row from the top.
    texels: Vec<[f32; 3]>,
}

/// Points along a side of a tent, when the map is resampled.
const POINTS: u32 = 6;

/// Right, down and forward of each face.
const FACES: [[DVec3; 3]; 6] = [
    [DVec3::Z, DVec3::NEG_Y, DVec3::X],
    [DVec3::NEG_Z, DVec3::NEG_Y, DVec3::NEG_X],
    [DVec3::NEG_X, DVec3::Z, DVec3::Y],
    [DVec3::NEG_X, DVec3::NEG_Z, DVec3::NEG_Y],
    [DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z],
    [DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z],
];

/// The solid angle of the part of the face z = 1 that lies between its centre and the corner (x, y).
fn corner(x: f64, y: f64) -> f64 {
    libm::atan2(x * y, (x * x + y * y + 1.0).sqrt())
}

impl CubeMap {
    /// From six faces of `side` times `side` texels, finite and not negative. `None` if the number of texels is another, or 0.
    pub fn new(side: u32, texels: Vec<[f32; 3]>) -> Option<Self> {
        let side = side as usize;
        (side > 0 && texels.len() == 6 * side * side).then_some(Self { side, texels })
    }

    /// Radiance from a direction, which need not have length 1.
    pub fn radiance(&self, w: DVec3) -> Rgb {
        let a = w.abs();
        let face = if a.x >= a.y && a.x >= a.z {
            usize::from(w.x < 0.0)
        } else if a.y >= a.z {
            2 + usize::from(w.y < 0.0)
        } else {
            4 + usize::from(w.z < 0.0)
        };
        let [right, down, forward] = FACES[face];
        let side = self.side as f64;
        let index = |along: f64| ((0.5 * (along / w.dot(forward) + 1.0) * side) as usize).min(self.side - 1);
        let texel = (face * self.side + index(w.dot(down))) * self.side + index(w.dot(right));
        Rgb::from_array(self.texels[texel].map(f64::from))
    }

    /// The mean radiance over all directions.
    pub fn mean(&self) -> Rgb {
        let edge = |i: usize| 2.0 * i as f64 / self.side as f64 - 1.0;
        let mut sum = Rgb::ZERO;
        for (row, texels) in self.texels.chunks_exact(self.side).enumerate() {
            let row = row % self.side;
            let (top, bottom) = (edge(row), edge(row + 1));
            for (column, texel) in texels.iter().enumerate() {
                let (left, right) = (edge(column), edge(column + 1));
                let angle = corner(right, bottom) - corner(left, bottom) - corner(right, top) + corner(left, top);
                sum += Rgb::from_array(texel.map(f64::from)) * angle;
            }
        }
        sum / (4.0 * PI)
    }

    /// The same as a latitude-longitude map, turned by `rotation` and times `strength`. It has four texels along the equator and two
    /// along a meridian for each of a face's side, which is a little finer than the cube is in the middle of a face. Its mean radiance
    /// is exactly the cube's times `strength`.
    pub fn to_environment(&self, rotation: DQuat, strength: f64) -> Environment {
        let back = rotation.normalize().conjugate();
        let (width, height) = (4 * self.side as u32, 2 * self.side as u32);
        let resampled = Environment::resampled(width, height, POINTS, |w| self.radiance(back * w) * strength);
        let resampled = resampled.unwrap_or_else(|| unreachable!("a cube map has texels"));
        let (wanted, found) = (self.mean() * strength, resampled.mean());
        let factor = |channel: usize| if found[channel] > 0.0 { wanted[channel] / found[channel] } else { 1.0 };
        resampled.tinted(Rgb::new(factor(0), factor(1), factor(2)))
    }
}
