//! Surfaces at their limits: normals that disagree, faces without area, roughness next to none.

use ergodic_geometry::Mesh;
use ergodic_pathspace::{Placement, Scene};
use ergodic_render::{Method, Picture, RenderError, Unobserved, render};
use ergodic_scattering::{Material, Rgb};
use ergodic_tests::{Eye, cuboid, description, description_of, diffuse, nightly, quad, scene_of, view_of};
use glam::{DAffine3, DMat3, DVec3};

use super::{SIDE, check, means, settings};

/// A mesh of its own corners for every triangle, its normals leant by an angle in radians towards a direction of their own.
fn with_leaning_normals(mesh: &Mesh, angle: f64) -> Mesh {
    let mut leaning = Mesh::default();
    let mut normals = Vec::new();
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
        let n = (b - a).cross(c - a).normalize();
        let first = leaning.positions.len() as u32;
        leaning.triangles.push([first, first + 1, first + 2]);
        leaning.positions.extend([a, b, c]);
        for (i, edge) in [b - a, c - b, a - c].into_iter().enumerate() {
            // Each corner leans another way.
            let towards = if i == 1 { -edge.normalize() } else { edge.normalize() };
            normals.push(n * angle.cos() + towards * angle.sin());
        }
    }
    leaning.normals = Some(normals);
    leaning
}

#[test]
fn no_light_leaks_out_of_a_closed_box_with_bent_normals() {
    let angle = 45f64.to_radians();
    let shell = with_leaning_normals(&cuboid(DVec3::splat(0.5), false), angle);
    let lining = with_leaning_normals(&cuboid(DVec3::splat(0.49), true), angle);
    let lamp = cuboid(DVec3::splat(0.1), false);
    let floor = quad(DVec3::new(-2.0, -2.0, -0.6), DVec3::X * 4.0, DVec3::Y * 4.0);
    let eye = Eye { from: DVec3::new(1.5, -1.5, 1.2), at: DVec3::ZERO, up: DVec3::Z, fov: 1.0 };
    let white = diffuse(0.9, 0.0);
    let things = vec![(shell, white.clone()), (lining, white.clone()), (lamp, diffuse(0.5, 10.0)), (floor, white)];
    let scene = scene_of(things, Vec::new(), &eye, SIDE);
    for method in [Method::Path, Method::Bidirectional] {
        let picture = render(&scene, &settings(method, &(1..=8), 64.0), &Unobserved).expect("valid settings").picture;
        assert!(picture.pixels.iter().all(|p| *p == Rgb::ZERO), "{method:?}");
    }
    let error = render(&scene, &settings(Method::Mlt, &(1..=8), 64.0), &Unobserved).unwrap_err();
    assert!(matches!(error, RenderError::Dark(_)), "{error}");
    println!("outside of a closed box with normals bent by 45 degrees: exactly 0");
}

#[test]
fn normals_eighty_degrees_from_their_faces() {
    for degrees in [45.0f64, 80.0, 89.0] {
        let ball = with_leaning_normals(&cuboid(DVec3::splat(0.5), false), degrees.to_radians());
        let floor = quad(DVec3::new(-2.0, -2.0, -0.5), DVec3::X * 4.0, DVec3::Y * 4.0);
        let lamp = quad(DVec3::new(-0.5, -0.5, 1.5), DVec3::Y, DVec3::X);
        let eye = Eye { from: DVec3::new(1.5, -1.5, 1.2), at: DVec3::ZERO, up: DVec3::Z, fov: 0.9 };
        let things = vec![(ball, diffuse(0.8, 0.0)), (floor, diffuse(0.6, 0.0)), (lamp, diffuse(0.0, 4.0))];
        let scene = scene_of(things, Vec::new(), &eye, SIDE);
        let expected = means(&scene, &settings(Method::Path, &(1..=4), 256.0));
        check(&format!("normals leant by {degrees}"), &scene, 1..=4, [0.0, 64.0, 512.0], &expected, 0.03);
    }
}

#[test]
fn faces_without_area_and_faces_given_twice_change_nothing() {
    let scene = || description("cornell");
    let picture = |scene, method| -> Picture {
        render(&view_of(scene, (SIDE, SIDE)), &settings(method, &(1..=6), 16.0), &Unobserved)
            .expect("valid settings")
            .picture
    };
    for (method, name) in Method::ALL {
        let plain = picture(scene(), method);
        // Every mesh with its triangles given again, and triangles that are a point or a line added to it.
        let mut crowded = scene();
        for mesh in &mut crowded.meshes {
            mesh.triangles.extend(mesh.triangles.clone());
            mesh.triangles.extend([[0, 0, 0], [0, 1, 1], [2, 0, 2]]);
        }
        // And every thing placed again, in the very same place.
        crowded.placements.extend(crowded.placements.clone());
        assert_eq!(plain, picture(crowded, method), "{name}");
    }
    println!("faces given twice, points and lines: the same picture to the bit");
}

#[test]
fn needles_do_no_harm() {
    // Triangles 1 long and down to 1e-12 wide, one of them bright, in the middle of the room.
    let base = description("cornell");
    let (low, high) = base.bounds().expect("it has triangles");
    let (middle, size) = ((low + high) * 0.5, high - low);
    let mut spiked = base.clone();
    for (i, width) in [1e-6, 1e-9, 1e-12].into_iter().enumerate() {
        let at = middle + DVec3::new(0.02 * i as f64, 0.0, 0.0) * size;
        let needle = Mesh {
            positions: vec![at, at + DVec3::Y * 0.3 * size.y, at + DVec3::X * width * size.x],
            triangles: vec![[0, 1, 2], [0, 2, 1]],
            ..Mesh::default()
        };
        spiked.placements.push(Placement {
            mesh: spiked.meshes.len(),
            material: spiked.materials.len(),
            transform: DAffine3::IDENTITY,
        });
        spiked.meshes.push(needle);
        spiked.materials.push(diffuse(0.5, if i == 1 { 1.0 } else { 0.0 }));
    }
    let edges = 1..=6;
    let expected = means(&view_of(base, (SIDE, SIDE)), &settings(Method::Bidirectional, &edges, 64.0));
    check("needles", &view_of(spiked, (SIDE, SIDE)), edges, [64.0, 64.0, 256.0], &expected, 0.02);
}

#[test]
fn a_mirrored_scene_gives_the_mirrored_picture() {
    let leaning = with_leaning_normals(&cuboid(DVec3::splat(0.4), false), 0.5);
    let floor = quad(DVec3::new(-2.0, -2.0, -0.4), DVec3::X * 4.0, DVec3::Y * 4.0);
    let lamp = quad(DVec3::new(0.3, -0.5, 1.5), DVec3::Y, DVec3::X);
    let eye = Eye { from: DVec3::new(0.0, -2.2, 1.2), at: DVec3::ZERO, up: DVec3::Z, fov: 0.9 };
    let things = vec![(leaning, diffuse(0.8, 0.0)), (floor, diffuse(0.6, 0.0)), (lamp, diffuse(0.0, 4.0))];
    let right = description_of(things, Vec::new(), &eye);
    let mut mirrored = right.clone();
    for placement in &mut mirrored.placements {
        placement.transform.matrix3 = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    }
    let edges = 1..=4;
    // Its left half is the other's right half: the whole less the left.
    let expected = means(&view_of(right, (SIDE, SIDE)), &settings(Method::Bidirectional, &edges, 128.0));
    let other_half = ergodic_tests::Estimate {
        mean: 2.0 * expected[0].mean - expected[1].mean,
        error: (4.0 * expected[0].error * expected[0].error + expected[1].error * expected[1].error).map(f64::sqrt),
    };
    let scene = view_of(mirrored, (SIDE, SIDE));
    check("mirrored", &scene, edges, [128.0, 64.0, 256.0], &[expected[0], other_half], 0.02);
}

/// A metal floor that mirrors a lamp with an edge, seen at a slant.
fn metal(roughness: f64) -> Scene {
    let floor = quad(DVec3::new(-2.0, -2.0, 0.0), DVec3::X * 4.0, DVec3::Y * 4.0);
    let lamp = quad(DVec3::new(-0.3, 1.0, 0.2), DVec3::X * 1.1, DVec3::Z * 0.9);
    let eye = Eye { from: DVec3::new(0.0, -1.5, 1.0), at: DVec3::new(0.0, 0.1, 0.0), up: DVec3::Z, fov: 0.7 };
    let material = Material { metallic: 1.0, roughness, base_color: Rgb::splat(0.9), ..Material::default() };
    let mut lit = diffuse(0.0, 2.0);
    lit.double_sided = true;
    scene_of(vec![(floor, material), (lamp, lit)], Vec::new(), &eye, SIDE)
}

#[test]
fn no_jump_from_rough_to_smooth() {
    let edges = 1..=3;
    let threshold = ergodic_scattering::SMOOTH_ALPHA;
    // Four by four blocks of pixels, a little rougher and a little smoother than where lobes become Dirac.
    let blocks = |alpha: f64, method| {
        let picture = render(&metal(alpha.sqrt()), &settings(method, &edges, 512.0), &Unobserved)
            .expect("valid settings")
            .picture;
        let mut sums = [0.0; 16];
        for (i, pixel) in picture.pixels.iter().enumerate() {
            let (x, y) = (i % SIDE as usize, i / SIDE as usize);
            sums[y / 4 * 4 + x / 4] += pixel.x / 16.0;
        }
        sums
    };
    let brightest = blocks(threshold, Method::Path).into_iter().fold(0.0, f64::max);
    for method in [Method::Path, Method::Bidirectional] {
        let (smooth, rough) = (blocks(0.9 * threshold, method), blocks(1.1 * threshold, method));
        let worst = smooth.iter().zip(rough).map(|(a, b)| (a - b).abs() / brightest).fold(0.0, f64::max);
        println!(
            "across the threshold of smoothness, {}: blocks differ by {worst:.1e} of the brightest",
            method.name()
        );
        assert!(worst < 0.02, "{worst}");
    }
}

#[test]
fn every_roughness_from_one_to_none_agrees_with_path_tracing() {
    let edges = 1..=3;
    for exponent in (0..=8).step_by(nightly(4, 1)) {
        let alpha = 10f64.powf(-0.5 * f64::from(exponent));
        let scene = metal(alpha.sqrt());
        let expected = means(&scene, &settings(Method::Path, &edges, 256.0));
        check(&format!("alpha {alpha:.0e}"), &scene, edges.clone(), [0.0, 64.0, 512.0], &expected, 0.04);
    }
}
