//! The film, its edges, and what must not reach it.

use ergodic_metropolis::Fault;
use ergodic_pathspace::stability::Place;
use ergodic_render::{Film, FilterSettings, Method, SplatBuffer, Unobserved, render};
use ergodic_scattering::{Filter, Rgb};
use ergodic_tests::{Estimate, Eye, cuboid, description, diffuse, estimate, nightly, scene_of, view_of};
use glam::{DVec2, DVec3};

use super::{AGREES, REPLICAS, SIDE, settings};

#[test]
fn a_billion_splats_on_one_pixel() {
    let mut film = Film::new(1, 1, Filter::Box);
    let (mut plain, mut single) = (0.0, 0.0f32);
    let colour = Rgb::new(0.1, 1.0, 0.7);
    let count = 1_000_000_000u64;
    for _ in 0..count {
        film.splat(DVec2::splat(0.5), colour);
        plain += colour.x;
        single += colour.x as f32;
    }
    let found = film.develop(1.0).pixels[0];
    let expected = colour * count as f64;
    let error = ((found - expected) / expected).abs().max_element();
    let plain_error = (plain / expected.x - 1.0).abs();
    let single_error = (f64::from(single) / expected.x - 1.0).abs();
    println!("1e9 splats: off by {error:.1e}; a plain f64 sum by {plain_error:.1e}, f32 by {single_error:.2}");
    assert!(error < 1e-12, "{error}");
    // What would be wrong elsewhere.
    assert!(plain_error > 1e-9 && single_error > 0.5);
}

#[test]
fn small_splats_beside_large_ones_and_parts_of_films_are_not_lost() {
    let mut parts = vec![SplatBuffer::new(); 8];
    let mut film = Film::new(2, 1, Filter::Box);
    let merge = |film: &mut Film, parts: &mut [SplatBuffer]| film.merge(&mut parts.iter_mut().collect::<Vec<_>>());
    let mut plain = 0.0f64;
    for i in 0..100_000 {
        for part in &mut parts {
            if i == 0 {
                part.splat(DVec2::new(0.5, 0.5), Rgb::splat(1e15));
                plain += 1e15;
            }
            part.splat(DVec2::new(0.5, 0.5), Rgb::splat(1e-3));
            plain += 1e-3;
        }
        if parts.iter().any(|part| part.room() < 2) {
            merge(&mut film, &mut parts);
        }
    }
    merge(&mut film, &mut parts);
    let found = film.develop(1.0).pixels[0].x;
    assert!((found - 8.0 * (1e15 + 100.0)).abs() <= 1.0, "{found}");
    // A plain sum loses them.
    assert!((plain - 8.0 * (1e15 + 100.0)).abs() > 100.0, "{plain}");
}

#[test]
fn image_points_on_the_border_of_the_film() {
    for filter in [FilterSettings::Box, FilterSettings::Gaussian { radius: 1.5, sigma: 0.5 }] {
        let mut film = Film::new(4, 3, filter.filter());
        let edge = |size: f64| [-1e9, -1.5, -1e-300, 0.0, 0.5, size - 1e-15, size, size + 1.5, 1e9];
        for x in edge(4.0) {
            for y in edge(3.0) {
                film.splat(DVec2::new(x, y), Rgb::ONE);
            }
        }
        assert!(film.develop(1.0).pixels.iter().all(|p| p.is_finite() && p.min_element() >= 0.0));
    }
}

#[test]
fn border_pixels_are_as_bright_as_the_others() {
    // The same radiance everywhere: perturbations that leave the film are rejected, not wrapped around it.
    let room = (cuboid(DVec3::new(1.0, 1.0, 0.5), true), diffuse(0.5, 1.0));
    let eye = Eye { from: DVec3::new(0.3, -0.2, 0.1), at: DVec3::new(-0.9, 0.9, -0.4), up: DVec3::Z, fov: 1.2 };
    let scene = scene_of(vec![room], Vec::new(), &eye, SIDE);
    let side = SIDE as usize;
    for filter in [FilterSettings::Box, FilterSettings::Gaussian { radius: 1.5, sigma: 0.5 }] {
        let mut settings = settings(Method::Mlt, &(2..=2), 512.0);
        settings.filter = filter;
        let view = settings.view(eye.description());
        let things = vec![(cuboid(DVec3::new(1.0, 1.0, 0.5), true), diffuse(0.5, 1.0))];
        let description = ergodic_tests::description_of(things, Vec::new(), &eye);
        let scene = match filter {
            FilterSettings::Box => scene.clone(),
            FilterSettings::Gaussian { .. } => {
                ergodic_pathspace::Scene::new(description, &view).unwrap_or_else(|e| panic!("{e}"))
            }
        };
        let border = |i: usize| [i % side, i / side].iter().any(|&c| c == 0 || c + 1 == side);
        let found: [Estimate; 2] = estimate(&scene, &settings, REPLICAS, |picture| {
            [true, false].map(|wanted| {
                let pixels: Vec<Rgb> =
                    picture.pixels.iter().enumerate().filter(|(i, _)| border(*i) == wanted).map(|(_, p)| *p).collect();
                pixels.iter().sum::<Rgb>() / pixels.len() as f64
            })
        })
        .unwrap_or_else(|e| panic!("{e}"));
        println!(
            "{filter:?}: border {:.5} +- {:.5}, inside {:.5} +- {:.5}",
            found[0].mean, found[0].error, found[1].mean, found[1].error
        );
        for part in &found {
            assert!(part.z(Rgb::splat(0.5)) < AGREES && part.relative_error() < 0.02, "{found:?}");
        }
    }
}

#[test]
fn materials_that_are_no_number_are_counted_and_kept_off_the_film() {
    let mut broken = description("cornell");
    let material = broken.materials.iter().position(|m| m.emission == Rgb::ZERO).expect("a wall");
    broken.materials[material].base_color.y = f64::NAN;
    let scene = view_of(broken, (SIDE, SIDE));
    for (method, name) in Method::ALL {
        let rendering = render(&scene, &settings(method, &(1..=6), 64.0), &Unobserved).expect("valid settings");
        assert!(rendering.picture.pixels.iter().all(|p| p.is_finite() && p.min_element() >= 0.0), "{name}");
        let stability = rendering.counts.stability;
        let counts: Vec<_> = Place::ALL.iter().map(|p| (p.name(), stability.at(*p).non_finite)).collect();
        let faults = rendering.mlt.map_or(0, |report| {
            report.statistics.iter().map(|s| s.total().faulty[Fault::Target as usize]).sum::<u64>()
        });
        println!("{name}: {counts:?}, {faults} faulty proposals");
        assert!(stability.total() > 1000, "{name}: {counts:?}");
        assert_eq!(stability.at(Place::Film).total(), 0, "{name}: it is caught before the film");
        assert!(method != Method::Mlt || faults > 1000, "{faults}");
    }
    // Without the planted NaN nothing is counted: see the scenes of the repository.
    for name in ["cornell", "ajar", "ring", "glass", "pool"] {
        let scene = view_of(description(name), (64, 64));
        for (method, method_name) in Method::ALL {
            let mut settings = settings(method, &(1..=16), nightly(16.0, 256.0));
            settings.size = (64, 64);
            let rendering = render(&scene, &settings, &Unobserved).expect("valid settings");
            let faults: u64 = rendering.mlt.iter().flat_map(|r| &r.statistics).flat_map(|s| s.total().faulty).sum();
            assert_eq!((rendering.counts.stability.total(), faults), (0, 0), "{name}, {method_name}");
        }
    }
}
