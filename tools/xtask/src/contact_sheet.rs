//! `cargo xtask contact-sheet`: one picture of all glTF files below some folders, to see at a glance what is read and how.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use ergodic_assess::{Exposure, Image, to_srgb8, write_srgb8};
use ergodic_assets::{Asset, load};
use ergodic_pathspace::{CameraDescription, Scene};
use ergodic_render::{Budget, Method, Observer, Settings, Stage, render};
use ergodic_scattering::{Environment, PunctualLight, Rgb};
use glam::DVec3;

use crate::sheet::{Face, Sheet, Tile};

pub const USAGE: &str = "\
Usage: cargo xtask contact-sheet PATH... [--out FILE.png] [--size WxH] [--columns N] [--samples N] [--seconds S] [--lamps]
                                   [--studio]

Renders every .glb and .gltf file below the paths by path tracing, with its first camera or one that frames it, and puts the
pictures into one. A file that cannot be rendered gets a tile that says why.

  --out FILE.png   where to write (docs/contact-sheet.png)
  --size WxH       pixels of a tile (160x160)
  --columns N      tiles in a row (8)
  --samples N      samples a pixel (64)
  --seconds S      longest time for a tile (20)
  --lamps          light files that have no point, spot or directional lights, and no camera or no emitting surface, by two
                   directional lights from beside the camera
  --studio         light the same files by a bright sky with three soft lamps in it, which mirrors and metals show
";

/// What to make.
#[derive(Debug, PartialEq)]
struct Options {
    paths: Vec<PathBuf>,
    out: PathBuf,
    size: (u32, u32),
    columns: usize,
    samples: f64,
    seconds: f64,
    lamps: bool,
    studio: bool,
}

impl Options {
    fn read(arguments: &[String]) -> Result<Self, String> {
        let mut options = Self {
            paths: Vec::new(),
            out: crate::root().join("docs/contact-sheet.png"),
            size: (160, 160),
            columns: 8,
            samples: 64.0,
            seconds: 20.0,
            lamps: false,
            studio: false,
        };
        let mut rest = arguments.iter();
        while let Some(argument) = rest.next() {
            match argument.as_str() {
                "--lamps" => options.lamps = true,
                "--studio" => options.studio = true,
                _ => {}
            }
            if argument == "--lamps" || argument == "--studio" {
                continue;
            }
            if !argument.starts_with("--") {
                options.paths.push(argument.into());
                continue;
            }
            let value = rest.next().ok_or_else(|| format!("{argument} needs a value\n\n{USAGE}"))?;
            let wrong = || format!("{value:?} is no value of {argument}\n\n{USAGE}");
            let number = || value.parse::<f64>().ok().filter(|n| *n > 0.0 && n.is_finite()).ok_or_else(wrong);
            let side = |text: &str| text.parse::<u32>().ok().filter(|n| (16..=4096).contains(n)).ok_or_else(wrong);
            match argument.as_str() {
                "--out" => options.out = value.into(),
                "--size" => {
                    let (width, height) = value.split_once('x').ok_or_else(wrong)?;
                    options.size = (side(width)?, side(height)?);
                }
                "--columns" => options.columns = value.parse().ok().filter(|n| *n > 0).ok_or_else(wrong)?,
                "--samples" => options.samples = number()?,
                "--seconds" => options.seconds = number()?,
                _ => return Err(format!("there is no option {argument}\n\n{USAGE}")),
            }
        }
        if options.paths.is_empty() { Err(USAGE.into()) } else { Ok(options) }
    }
}

/// Stops a render after some time.
struct Until(Instant);

impl Observer for Until {
    fn progress(&self, _stage: Stage, _done: f64) {}

    fn should_stop(&self) -> bool {
        Instant::now() >= self.0
    }
}

/// Makes the sheet.
pub fn run(arguments: &[String]) -> Result<(), String> {
    if arguments.iter().any(|argument| argument == "--help") {
        print!("{USAGE}");
        return Ok(());
    }
    let options = Options::read(arguments)?;
    let mut files = Vec::new();
    for path in &options.paths {
        find(path, &mut files)?;
    }
    if files.is_empty() {
        return Err("there is no .glb or .gltf file below the paths".into());
    }
    let mut tiles = Vec::new();
    for (i, file) in files.iter().enumerate() {
        eprintln!("{} of {}: {}", i + 1, files.len(), file.display());
        let name = file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        // A sheet of many files must come to its end whatever is in one of them.
        let made = catch_unwind(AssertUnwindSafe(|| picture(file, &options)));
        let (face, remark) = match made {
            Ok(Ok((picture, warnings))) => (Face::Picture(picture), remark(warnings)),
            Ok(Err(why)) => (Face::Text(why), String::new()),
            Err(_) => (Face::Text("panicked; this is a bug".into()), String::new()),
        };
        if let Face::Text(why) = &face {
            eprintln!("  {why}");
        }
        tiles.push(Tile { name, remark, face });
    }
    let (width, height) = (options.size.0 as usize, options.size.1 as usize);
    let sheet = Sheet::of(&tiles, options.columns, width, height);
    write_srgb8(&options.out, sheet.width as u32, sheet.height as u32, &sheet.bytes).map_err(|e| e.to_string())?;
    println!("wrote {}: {} files", options.out.display(), files.len());
    Ok(())
}

fn remark(warnings: usize) -> String {
    match warnings {
        0 => String::new(),
        1 => "1 warning".into(),
        more => format!("{more} warnings"),
    }
}

/// Adds the glTF files at or below a path, in alphabetical order. Links to folders are not followed: they may lead round.
fn find(path: &Path, files: &mut Vec<PathBuf>) -> Result<(), String> {
    let broken = |e: std::io::Error| format!("cannot read {}: {e}", path.display());
    if path.is_file() {
        files.push(path.to_path_buf());
        return Ok(());
    }
    let entries = std::fs::read_dir(path).map_err(broken)?.collect::<Result<Vec<_>, _>>().map_err(broken)?;
    let mut entries: Vec<(PathBuf, bool)> =
        entries.iter().map(|entry| (entry.path(), entry.file_type().is_ok_and(|kind| kind.is_dir()))).collect();
    entries.sort();
    for (entry, is_folder) in entries {
        let is_scene =
            entry.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb") || e.eq_ignore_ascii_case("gltf"));
        if is_folder {
            find(&entry, files)?;
        } else if is_scene && entry.is_file() {
            files.push(entry);
        }
    }
    Ok(())
}

/// The picture of a file and how many warnings came with it, or why there is none.
fn picture(file: &Path, options: &Options) -> Result<(Vec<u8>, usize), String> {
    let mut asset = load(file).map_err(|e| format!("{} {}", e.place, e.problem))?;
    let settings = Settings {
        method: Method::Path,
        size: options.size,
        budget: Budget::SamplesPerPixel(options.samples),
        ..Settings::default()
    };
    let aspect = f64::from(options.size.0) / f64::from(options.size.1);
    let (camera, framed) = asset.camera("", aspect).map_err(|_| "nothing to see")?;
    let unlit = wants_lamps(&asset, framed);
    if options.lamps && unlit {
        asset.description.lights.extend(lamps(&camera));
    }
    if options.studio && unlit {
        asset.description.environment = Environment::resampled(128, 64, 4, |w| studio(&camera, w));
    }
    let warnings = asset.warnings.len();
    let scene = Scene::new(asset.description, &settings.view(camera)).map_err(|e| e.to_string())?;
    let until = Until(Instant::now() + Duration::from_secs_f64(options.seconds));
    let rendering = render(&scene, &settings, &until).map_err(|e| e.to_string())?;
    let picture = rendering.picture;
    let pixels = picture.pixels.iter().map(|p| p.to_array()).collect();
    let image = Image { width: picture.width, height: picture.height, pixels };
    Ok((to_srgb8(&image, Exposure::Automatic), warnings))
}

/// Files with lights, and with a camera and emitting surfaces, are taken for lit on purpose.
fn wants_lamps(asset: &Asset, framed: bool) -> bool {
    let description = &asset.description;
    let emits = |material: usize| description.materials[material].emission.max_element() > 0.0;
    let emits = description.placements.iter().any(|placement| emits(placement.material));
    description.lights.is_empty() && description.environment.is_none() && (framed || !emits)
}

/// The radiance of the studio from direction `w`: a sky that is brightest above, a darker floor, and soft lamps, as the camera
/// sees them, from the right and above behind it, from the left, and far above.
fn studio(camera: &CameraDescription, w: DVec3) -> Rgb {
    const LAMPS: [(DVec3, f64, f64); 3] = [
        (DVec3::new(0.6, 0.6, 0.5), 0.94, 12.0),
        (DVec3::new(-0.9, 0.2, 0.3), 0.97, 6.0),
        (DVec3::new(0.0, 1.0, -0.2), 0.98, 6.0),
    ];
    let seen = camera.transform.matrix3.inverse() * w;
    let sky = if w.y < 0.0 { 0.15 } else { 0.25 + 0.35 * w.y };
    let lamp = |(direction, cosine, radiance): (DVec3, f64, f64)| {
        if seen.normalize_or_zero().dot(direction.normalize()) > cosine { radiance } else { 0.0 }
    };
    Rgb::splat(sky + LAMPS.into_iter().map(lamp).sum::<f64>())
}

/// Two lights from beside a camera: one from the right and above, and a dimmer one from the left.
fn lamps(camera: &CameraDescription) -> [PunctualLight; 2] {
    let lamp = |direction: DVec3, irradiance: f64| PunctualLight::Directional {
        direction: (camera.transform.matrix3 * direction).normalize_or(DVec3::NEG_Y),
        irradiance: Rgb::splat(irradiance),
    };
    [lamp(DVec3::new(-0.5, -0.7, -0.6), 3.0), lamp(DVec3::new(0.8, -0.2, -0.6), 1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(arguments: &str) -> Result<Options, String> {
        Options::read(&arguments.split_whitespace().map(String::from).collect::<Vec<_>>())
    }

    #[test]
    fn options_are_read_and_checked() {
        let read = options("a b --size 32x24 --columns 3 --lamps --studio --samples 2.5").unwrap();
        assert_eq!((read.paths.len(), read.size, read.columns), (2, (32, 24), 3));
        assert!(read.lamps && read.studio && read.samples == 2.5);
        for wrong in ["", "a --size 32", "a --size 0x5", "a --columns 0", "a --samples no", "a --what 1", "a --out"] {
            assert!(options(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_scenes_are_found_and_rendered() {
        let mut files = Vec::new();
        find(&crate::scenes_folder(), &mut files).unwrap();
        assert!(files.len() >= 5 && files.is_sorted(), "{files:?}");
        let options = options("x --size 16x16 --samples 4").unwrap();
        let (picture, warnings) = picture(&crate::scenes_folder().join("cornell/scene.glb"), &options).unwrap();
        assert_eq!((picture.len(), warnings), (3 * 16 * 16, 0));
        assert!(picture.iter().any(|&byte| byte > 100));
        assert!(super::picture(Path::new("no such file.glb"), &options).unwrap_err().contains("cannot be read"));
    }
}
