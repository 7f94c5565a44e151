//! Pictures written, read, compared.

use std::path::PathBuf;

use ergodic_assess::{
    Attribute, Exposure, Image, check_writable, compare, flip_hdr, flip_ldr, read_image, write_exr, write_png,
};

/// A folder of its own for each test, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("ergodic-assess-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder for temporary files");
        Self(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Waves and a chequerboard; `k` bends them, and a high dynamic range stretches them to 20.
fn pattern(k: f64, high_range: bool) -> Image {
    let (width, height) = (96, 64);
    let mut pixels = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let (fx, fy) = (f64::from(x), f64::from(y));
            let r = 0.5 + 0.5 * (0.11 * fx * (1.0 + 0.2 * k) + 0.05 * fy).sin();
            let g = 0.5 + 0.5 * (0.07 * fy + 0.3 * k).cos() * (0.23 * fx).sin();
            let b = f64::from((x / 8 + y / 8) % 2) * 0.7 + 0.1 * k;
            let pixel = [r, g, b].map(|v| v.clamp(0.0, 1.0));
            pixels.push(if high_range { pixel.map(|v| v.powi(3) * 20.0 + 0.01) } else { pixel });
        }
    }
    Image { width, height, pixels }
}

#[test]
fn exr_comes_back_as_it_was_written() {
    let folder = Folder::new("exr");
    let path = folder.0.join("a.exr");
    let image = pattern(0.0, true);
    let attributes = [("b", Attribute::Number(0.25)), ("scene", Attribute::Text("ring ❤".into()))];
    let levels: Vec<f64> = (0..image.pixels.len()).map(|i| i as f64).collect();
    write_exr(&path, &image, None, &[("acceptance", &levels)], &attributes).unwrap();
    let read = read_image(&path).unwrap();
    let rounded: Vec<_> = image.pixels.iter().map(|p| p.map(|v| f64::from(v as f32))).collect();
    assert_eq!((read.width, read.height, read.pixels), (image.width, image.height, rounded));
    let meta = exr::meta::MetaData::read_from_file(&path, true).unwrap();
    let names: Vec<String> = meta.headers[0].channels.list.iter().map(|c| c.name.to_string()).collect();
    assert_eq!(names, ["B", "G", "R", "acceptance"]);
    let other = &meta.headers[0].own_attributes.other;
    assert_eq!(other.get("b".as_bytes()), Some(&exr::meta::attribute::AttributeValue::F64(0.25)));
    assert!(other.contains_key("scene".as_bytes()));
    // Nothing else is left in the folder.
    assert_eq!(std::fs::read_dir(&folder.0).unwrap().count(), 1);
}

#[test]
fn png_is_srgb() {
    let folder = Folder::new("png");
    let path = folder.0.join("a.png");
    let image = Image { width: 2, height: 1, pixels: vec![[0.5, 0.0, 0.25], [0.7, 0.1, 100.0]] };
    write_png(&path, &image, Exposure::Stops(0.0)).unwrap();
    let read = read_image(&path).unwrap();
    for (a, b) in read.pixels.iter().flatten().zip(image.pixels.iter().flatten()) {
        assert!((a - b.min(1.0)).abs() < 0.004, "{a} is not {b}");
    }
}

#[test]
fn what_cannot_be_written_or_read_leaves_nothing_and_says_why() {
    let folder = Folder::new("errors");
    let image = pattern(0.0, false);
    let nowhere = folder.0.join("missing").join("a.exr");
    for error in [
        check_writable(&nowhere).unwrap_err(),
        write_exr(&nowhere, &image, None, &[], &[]).unwrap_err(),
        write_png(&nowhere, &image, Exposure::Automatic).unwrap_err(),
        check_writable(&folder.0).unwrap_err(),
        read_image(&nowhere).unwrap_err(),
        read_image(&folder.0).unwrap_err(),
    ] {
        assert!(!error.problem.is_empty() && !error.mend.is_empty(), "{error}");
    }
    check_writable(&folder.0.join("a.exr")).unwrap();
    assert_eq!(std::fs::read_dir(&folder.0).unwrap().count(), 0);
    std::fs::write(folder.0.join("text.png"), "no image").unwrap();
    assert!(read_image(&folder.0.join("text.png")).unwrap_err().problem.contains("decoded"));
}

#[test]
fn a_damaged_exr_is_an_error_and_no_panic() {
    let folder = Folder::new("damage");
    let path = folder.0.join("a.exr");
    write_exr(&path, &pattern(0.0, false), None, &[], &[]).unwrap();
    let whole = std::fs::read(&path).unwrap();
    let mut state = 7u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize
    };
    let mut refused = 0;
    for _ in 0..400 {
        let mut bytes = whole.clone();
        for _ in 0..3 {
            let at = next() % bytes.len().min(400);
            bytes[at] = next() as u8;
        }
        std::fs::write(&path, &bytes).unwrap();
        refused += usize::from(read_image(&path).is_err());
    }
    assert!(refused > 100, "{refused}");
}

#[test]
fn distances_are_what_their_formulas_say() {
    let reference = Image { width: 2, height: 1, pixels: vec![[0.5; 3], [0.25; 3]] };
    let image = Image { width: 2, height: 1, pixels: vec![[0.6; 3], [0.25; 3]] };
    let c = compare(&image, &reference).unwrap();
    assert!((c.mse - 0.005).abs() < 1e-12);
    assert!((c.rel_mse - 0.5 * 0.01 / 0.26).abs() < 1e-12);
    assert_eq!(c.trimmed_rel_mse, 0.0, "the worse of two pixels is left out");
    assert!((c.total_mean_ratio - 0.85 / 0.75).abs() < 1e-12 && !c.flip_is_hdr);
    let same = compare(&reference, &reference).unwrap();
    assert_eq!((same.mse, same.flip, same.total_mean_ratio), (0.0, 0.0, 1.0));
}

#[test]
fn images_that_cannot_be_compared_are_an_error() {
    let a = pattern(0.0, false);
    let b = Image { width: 1, height: 1, pixels: vec![[0.0; 3]] };
    assert!(compare(&a, &b).unwrap_err().contains("96 x 64"));
    let mut c = a.clone();
    c.pixels[97][1] = f64::NAN;
    assert!(compare(&c, &a).unwrap_err().contains("(1, 1) of the image"));
}

/// The figures are those of the authors' own evaluator, version 1.7, on the same patterns.
#[test]
fn flip_agrees_with_the_authors_evaluator() {
    let at = |map: &[f64], x: usize, y: usize| map[y * 96 + x];
    let mean = |map: &[f64]| map.iter().sum::<f64>() / map.len() as f64;
    for (high_range, expected) in [(false, LDR), (true, HDR)] {
        let (image, reference) = (pattern(1.0, high_range), pattern(0.0, high_range));
        let map = if high_range { flip_hdr(&image, &reference) } else { flip_ldr(&image, &reference) };
        for (found, expected) in [mean(&map), at(&map, 20, 10), at(&map, 70, 40)].iter().zip(expected) {
            assert!((found - expected).abs() < 2e-4, "{found} is not {expected}");
        }
    }
}

/// Mean, pixel (20, 10), pixel (70, 40).
const LDR: [f64; 3] = [0.581277, 0.484559, 0.638803];
const HDR: [f64; 3] = [0.668390, 0.565344, 0.747631];
