//! A metal ring on a plane: the cardioid caustic of its inner side.

use glam::{DVec2, DVec3};

use crate::glb::{Document, Material};
use crate::shapes::{Profile, quad, revolve};

pub(super) fn make() -> Document {
    let mut document = Document::default();
    let plane = document.material(&Material::diffuse("plane", [0.7, 0.7, 0.68]));
    // Reflectance of gold at normal incidence; rough enough that no method finds the caustic by accident.
    let gold = document.material(&Material::metal("gold", [1.0, 0.766, 0.336], 0.15));
    let lamp = document.material(&Material::lamp("lamp", [400.0, 380.0, 360.0]));

    document.shape("plane", &quad(DVec3::new(-3.0, 0.0, -3.0), DVec3::Z * 6.0, DVec3::X * 6.0), plane);
    // A band of radius 0.8 m, 4 cm thick and 35 cm high, a millimetre above the plane so that no faces coincide.
    let band = [(0.80, 0.001), (0.84, 0.001), (0.84, 0.35), (0.80, 0.35), (0.80, 0.001)].map(DVec2::from);
    document.shape("ring", &revolve(&band, Profile::Edged, 256), gold);
    // A 16 cm square, turned towards the ring.
    let centre = DVec3::new(2.2, 2.0, -0.9);
    let to_ring = -centre.normalize();
    let u = to_ring.any_orthonormal_vector() * 0.16;
    let v = to_ring.cross(u);
    document.shape("lamp", &quad(centre - (u + v) * 0.5, u, v), lamp);
    document.camera(DVec3::new(0.0, 3.0, 2.6), DVec3::new(0.0, 0.0, 0.05), 36.0);
    document
}
