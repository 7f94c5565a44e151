//! Environments from files: what is read, what is warned of, what is refused.

use std::path::PathBuf;

use ergodic_assets::{Trouble, load_environment};
use exr::prelude::write_rgb_file;
use glam::DVec3;
use image::codecs::hdr::HdrEncoder;

/// A file in a folder of its own, gone when dropped.
struct File(PathBuf);

impl File {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("ergodic-environments-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a writable temporary folder");
        Self(folder.join(name))
    }

    fn of(name: &str, bytes: &[u8]) -> Self {
        let file = Self::new(name);
        std::fs::write(&file.0, bytes).expect("a writable temporary folder");
        file
    }

    fn exr(name: &str, width: usize, height: usize, texel: impl Fn(usize, usize) -> [f32; 3] + Sync) -> Self {
        let file = Self::new(name);
        write_rgb_file(&file.0, width, height, |x, y| texel(x, y).into()).expect("a writable temporary folder");
        file
    }
}

impl Drop for File {
    fn drop(&mut self) {
        let _ = self.0.parent().map(std::fs::remove_dir_all);
    }
}

fn gradient(x: usize, y: usize) -> [f32; 3] {
    [x as f32, y as f32 * 0.5, 1.0]
}

#[test]
fn hdr_and_exr_files_hold_the_same_map() {
    let exr = File::exr("a.exr", 8, 4, gradient);
    let mut bytes = Vec::new();
    let texels: Vec<_> = (0..32).map(|i| image::Rgb(gradient(i % 8, i / 8))).collect();
    HdrEncoder::new(&mut bytes).encode(&texels, 8, 4).unwrap();
    let hdr = File::of("a.hdr", &bytes);
    let (exact, warnings) = load_environment(&exr.0, 2.0, 0.0).unwrap();
    assert_eq!((exact.size(), warnings), ((8, 4), vec![]));
    let (rounded, warnings) = load_environment(&hdr.0, 2.0, 0.0).unwrap();
    assert_eq!((rounded.size(), warnings), ((8, 4), vec![]));
    // The middle of the map is +x, between columns 3 and 4 and rows 1 and 2.
    let middle = exact.radiance(DVec3::X);
    assert!((middle - 2.0 * DVec3::new(3.5, 0.75, 1.0)).length() < 1e-6, "{middle}");
    // The brightest channel of an HDR file's pixel has 8 bits.
    assert!((rounded.radiance(DVec3::X) - middle).abs().max_element() < 8.0 / 128.0);
}

#[test]
fn what_is_no_radiance_is_replaced_with_a_warning() {
    let file = File::exr("odd.exr", 4, 2, |x, y| match (x, y) {
        (1, 0) => [f32::NAN, 5.0, 5.0],
        (2, 0) => [-1.0, 5.0, 5.0],
        (3, 1) => [f32::INFINITY, 1.0, 1.0],
        _ => [1.0; 3],
    });
    let (environment, warnings) = load_environment(&file.0, 1.0, 0.0).unwrap();
    assert_eq!(warnings.len(), 3, "{warnings:?}");
    for (part, place) in
        [("no number", "row 0, column 1"), ("negative", "row 0, column 2"), ("infinite", "row 1, column 3")]
    {
        assert!(warnings.iter().any(|w| w.contains(part) && w.contains(place)), "{part}: {warnings:?}");
    }
    // All rows are as large: the mean is that of the texels.
    let mean = DVec3::new(1.0 * 5.0 + 65504.0, 5.0 + 6.0, 5.0 + 6.0) / 8.0;
    assert!((environment.mean() - mean).abs().max_element() < 1e-9, "{} {mean}", environment.mean());
}

#[test]
fn maps_of_another_shape_or_without_light_are_warned_of() {
    let square = File::exr("square.exr", 4, 4, |_, _| [1.0; 3]);
    let (_, warnings) = load_environment(&square.0, 1.0, 0.0).unwrap();
    assert!(warnings.len() == 1 && warnings[0].contains("twice as wide as high"), "{warnings:?}");
    let black = File::exr("black.exr", 4, 2, |_, _| [0.0; 3]);
    let (_, warnings) = load_environment(&black.0, 1.0, 0.0).unwrap();
    assert!(warnings.len() == 1 && warnings[0].contains("black"), "{warnings:?}");
}

#[test]
fn files_that_are_no_map_are_named() {
    let missing = load_environment("no/such/file.hdr".as_ref(), 1.0, 0.0).unwrap_err();
    assert_eq!(missing.trouble, Trouble::Unreadable);
    assert!(missing.to_string().contains("no/such/file.hdr"));
    let text = File::of("text.hdr", b"this is text");
    let mut cut = std::fs::read(&File::exr("whole.exr", 64, 32, gradient).0).unwrap();
    cut.truncate(cut.len() / 2);
    let cut = File::of("cut.exr", &cut);
    let mut png = Vec::new();
    image::RgbImage::new(2, 1).write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).unwrap();
    let png = File::of("picture.png", &png);
    // A header that promises more pixels than there may be.
    let vast = File::of("vast.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 30000 +X 60000\n");
    for (file, trouble) in [
        (&text, Trouble::Unsupported),
        (&png, Trouble::Unsupported),
        (&cut, Trouble::Malformed),
        (&vast, Trouble::TooLarge),
    ] {
        let error = load_environment(&file.0, 1.0, 0.0).unwrap_err();
        assert_eq!(error.trouble, trouble, "{error}");
        assert!(error.to_string().contains(file.0.file_name().unwrap().to_str().unwrap()), "{error}");
    }
}
