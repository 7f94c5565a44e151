//! A mesh gives the same bits whether it is baked or instanced.

use ergodic_geometry::{Anchor, Instance, Ray, World};
use glam::{DAffine3, DMat3, DQuat, DVec3};

use crate::support::{Random, bumpy_sphere};

/// Rigid, mirrored, sheared, non-uniform, tiny and flattening transforms.
pub fn transforms() -> Vec<DAffine3> {
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 0.7);
    let mut all = vec![
        DAffine3::IDENTITY,
        DAffine3::from_rotation_translation(turn, DVec3::new(3.0, 0.1, 0.2)),
        DAffine3::from_scale_rotation_translation(DVec3::new(-1.0, 1.0, 1.0), turn, DVec3::new(-2.0, 1.0, 0.0)),
        DAffine3::from_scale_rotation_translation(DVec3::new(0.1, 3.0, 1.0), turn, DVec3::new(0.0, 4.0, 0.0)),
        DAffine3::from_scale_rotation_translation(DVec3::new(1.0, -0.3, 20.0), turn, DVec3::new(0.0, -4.0, 0.0)),
        DAffine3::from_mat3_translation(
            DMat3::from_cols(DVec3::X, DVec3::new(0.9, 1.0, 0.0), DVec3::new(0.3, -0.4, 0.5)),
            DVec3::new(1.0, 1.0, 5.0),
        ),
        DAffine3::from_scale_rotation_translation(DVec3::splat(1e-3), turn, DVec3::new(0.0, 0.0, -3.0)),
        DAffine3::from_scale_rotation_translation(DVec3::new(1.0, 0.0, 1.0), turn, DVec3::new(0.0, 0.0, -5.0)),
    ];
    // Two at the same place: ties go to the first.
    all.push(all[1]);
    all
}

fn worlds() -> (World, World) {
    let mesh = bumpy_sphere(2, 5);
    let instances = |own: bool| -> Vec<Instance> {
        transforms()
            .into_iter()
            .enumerate()
            .map(|(i, transform)| Instance { mesh: if own { i as u32 } else { 0 }, transform })
            .collect()
    };
    let flat = World::build(vec![mesh.clone(); transforms().len()], instances(true)).expect("a valid world");
    let shared = World::build(vec![mesh], instances(false)).expect("a valid world");
    (flat, shared)
}

/// A ray towards one of the instances, from anywhere or from far outside; some aim at vertices.
fn ray_at(random: &mut Random, world: &World) -> Ray {
    let reach = if random.below(10) == 0 { 1e5 } else { 6.0 };
    let origin = random.cube() * reach;
    let instance = random.below(world.instances().len()) as u32;
    let [a, b, c] = world.triangle(instance, random.below(world.triangle_count(instance)) as u32);
    let target = match random.below(3) {
        0 => a,
        1 => a.lerp(b, random.next()),
        _ => (a + b + c) / 3.0,
    };
    Ray { origin, direction: (target - origin).normalize() }
}

#[test]
fn baked_and_instanced_hits_have_the_same_bits() {
    let (flat, shared) = worlds();
    assert_eq!(flat.bounds(), shared.bounds());
    let mut random = Random::new(1);
    let mut hit_by_instance = vec![0; transforms().len()];
    for _ in 0..100_000 {
        let ray = ray_at(&mut random, &flat);
        let (a, b) = (flat.intersect(&ray), shared.intersect(&ray));
        let bits = |hit: ergodic_geometry::Hit| {
            (hit.instance, hit.triangle, hit.u.to_bits(), hit.v.to_bits(), hit.t.to_bits())
        };
        assert_eq!(a.map(bits), b.map(bits));
        if let (Some(a), Some(b)) = (a, b) {
            hit_by_instance[a.instance as usize] += 1;
            assert_eq!(flat.surface(&a), shared.surface(&b));
        }
    }
    // The last one coincides with another and must lose every tie.
    let last = hit_by_instance.pop();
    assert_eq!(last, Some(0));
    assert!(hit_by_instance.iter().all(|&hits| hits > 500), "{hit_by_instance:?}");
}

#[test]
fn baked_and_instanced_shadows_agree() {
    let (flat, shared) = worlds();
    let mut random = Random::new(2);
    let mut visible = 0;
    for _ in 0..50_000 {
        let ends = [0; 2].map(|_| {
            let instance = random.below(transforms().len()) as u32;
            let (u, v) = random.barycentrics();
            let surface = flat.surface_at(instance, random.below(flat.triangle_count(instance)) as u32, u, v);
            Anchor { position: surface.position, normal: surface.ng }
        });
        let seen = flat.visible(&ends[0], &ends[1]);
        assert_eq!(seen, shared.visible(&ends[0], &ends[1]));
        visible += u32::from(seen);
        let direction = random.direction();
        assert_eq!(flat.escapes(&ends[0], direction), shared.escapes(&ends[0], direction));
    }
    assert!((500..49_500).contains(&visible), "{visible}");
}

#[test]
fn planted_fault_object_space_tests_differ_in_bits() {
    // The same ray and mesh in a rotated space hit at another bit pattern: the equality above is not a matter of course.
    let (flat, _) = worlds();
    let transform = transforms()[3];
    let alone =
        World::build(vec![bumpy_sphere(2, 5)], vec![Instance { mesh: 0, transform: DAffine3::IDENTITY }]).unwrap();
    let inverse = transform.inverse();
    let mut random = Random::new(1);
    let mut differences = 0;
    for _ in 0..2000 {
        let ray = ray_at(&mut random, &flat);
        if let Some(hit) = flat.intersect(&ray).filter(|hit| hit.instance == 3) {
            let local = Ray {
                origin: inverse.transform_point3(ray.origin),
                direction: inverse.transform_vector3(ray.direction),
            };
            differences += u32::from(alone.intersect(&local).is_none_or(|other| other.t.to_bits() != hit.t.to_bits()));
        }
    }
    assert!(differences > 0);
}

#[test]
fn instances_do_not_leak() {
    let (_, shared) = worlds();
    let mut random = Random::new(4);
    for (instance, transform) in transforms().into_iter().enumerate() {
        // The flattened one has no inside.
        if transform.matrix3.determinant() == 0.0 {
            continue;
        }
        for _ in 0..20_000 {
            let origin = transform.transform_point3(random.cube() * 0.35);
            let [a, b, _] = shared.triangle(instance as u32, random.below(320) as u32);
            let target = if random.below(2) == 0 { a } else { a.lerp(b, random.next()) };
            let ray = Ray { origin, direction: (target - origin).normalize() };
            assert!(shared.intersect(&ray).is_some(), "instance {instance}");
        }
    }
}
