//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use ergodic_render::{Budget, Method};

use crate::stats::options::StatsOptions;

const AFTER_HELP: &str = "\
Examples:
  ergodic render                                     the default scene: ajar.png, ajar.exr, ajar.stats.json
  ergodic render room.glb --size 640x360 --time 1m   Metropolis light transport for a minute
  ergodic render room.glb --method path --samples-per-pixel 64
  ergodic render --config scenes/ring/ring.ron --set mlt.chains=1000 -o out/ring
  ergodic config > my.ron                            every setting, explained, to start from
  ergodic inspect room.glb                           what a file holds, and what is not supported
  ergodic accuracy room.glb --time-limit 20m         which method is best for this scene, and how long it takes
  ergodic report room.accuracy.json                  one page to look at it: room.accuracy.html
  ergodic compare out/ring.exr reference.exr         how far one picture is from another
  ergodic stats a.stats.json b.stats.json            what the mutations of two renders did, and by how much they differ
  ergodic verify cornell --method path               whether this build still makes the stored reference";

/// Metropolis light transport in path space for glTF 2.0 scenes, after Veach.
#[derive(Debug, Parser)]
#[command(name = "ergodic", version, after_help = AFTER_HELP, max_term_width = 110)]
pub struct Options {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to STEM.exr, STEM.png and STEM.stats.json
    Render(RenderOptions),
    /// Print the default config, every setting explained
    Config,
    /// Tell what is in a scene file
    Inspect(InspectOptions),
    /// Tell how far an image is from a reference
    Compare(CompareOptions),
    /// Make one HTML page of a render or of an accuracy run, to look at, compare and measure
    Report(ReportOptions),
    /// Measure error against time for several methods on a scene, and say which is best
    Accuracy(AccuracyOptions),
    /// Test this build against the stored reference images, by statistics over independent replicas
    Verify(VerifyOptions),
    /// Show what the mutations of one or more renders did, side by side
    Stats(StatsOptions),
}

/// What is rendered, and how. Options win over --set, which wins over the config, which wins over the defaults.
#[derive(Clone, Debug, Args)]
pub struct SourceOptions {
    /// A .glb or .gltf file; without one, the config's, else the built-in room with the door ajar
    pub scene: Option<PathBuf>,
    /// Settings in RON; `ergodic config` prints all of them
    #[arg(long, value_name = "FILE.ron")]
    pub config: Option<PathBuf>,
    /// Light from infinitely far away: a latitude-longitude map, .hdr or .exr
    #[arg(long, value_name = "FILE")]
    pub environment: Option<PathBuf>,
    /// A camera by its name or its number in the file; without it the first
    #[arg(long, value_name = "NAME|N")]
    pub camera: Option<String>,
    /// A variant of the materials by its name, where the file has variants; `ergodic inspect` lists them
    #[arg(long, value_name = "NAME")]
    pub variant: Option<String>,
    /// Size of the picture in pixels, like 640x360
    #[arg(long, value_parser = size, value_name = "WxH")]
    pub size: Option<(u32, u32)>,
    /// Key of all random numbers; the same seed gives the same picture
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Worker threads, 0 for one a core; the picture does not depend on it
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Change one setting by its path, like mlt.chains=1000 or filter='Gaussian(radius: 2, sigma: 0.5)'; may be repeated
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub set: Vec<String>,
}

/// Options of `render`.
#[derive(Debug, Args)]
pub struct RenderOptions {
    /// What, and how
    #[command(flatten)]
    pub source: SourceOptions,
    /// path: path tracing. bidirectional: bidirectional path tracing. mlt: Metropolis light transport in path space. pssmlt: in
    /// primary sample space. mmlt: multiplexed
    #[arg(long, value_parser = method, value_name = "METHOD")]
    pub method: Option<Method>,
    /// Stop after this time, seeding included: 30s, 5m, 1.5h, or a number of seconds
    #[arg(long, value_parser = time, value_name = "TIME", conflicts_with = "samples_per_pixel")]
    pub time: Option<Budget>,
    /// Stop after this many samples a pixel; for mlt, pssmlt and mmlt, mutations a pixel
    #[arg(long, value_parser = samples, value_name = "N")]
    pub samples_per_pixel: Option<Budget>,
    /// Output files without their endings, like out/picture; the scene's name in this folder by default
    #[arg(short, long, value_name = "STEM")]
    pub output: Option<PathBuf>,
    /// Brightness of the PNG in stops; without it chosen from the picture. The EXR always holds radiance
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true)]
    pub exposure: Option<f64>,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

/// Options of `accuracy`.
#[derive(Debug, Args)]
pub struct AccuracyOptions {
    /// What, and how
    #[command(flatten)]
    pub source: SourceOptions,
    /// Methods that take part, like path,bidirectional,mlt; all of them by default
    #[arg(long, value_parser = method, value_delimiter = ',', value_name = "METHODS")]
    pub methods: Vec<Method>,
    /// A mix of mutations that takes part under a name: the mlt.mutations of a config; may be repeated
    #[arg(long = "mix", value_name = "NAME=FILE.ron")]
    pub mixes: Vec<String>,
    /// The picture to compare with, one of `cargo xtask reference` or any other; without one it is made first, in a quarter of the
    /// time
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,
    /// Wall time that all may take: 30s, 10m, 1.5h, or a number of seconds. With a longer one the same command goes on
    #[arg(long, value_parser = seconds, value_name = "TIME", default_value = "10m")]
    pub time_limit: f64,
    /// Independent replicas of each method at the longest budgets; short ones, which cost little, have up to 16 times as many
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u16).range(2..=1000))]
    pub replicas: u16,
    /// The first budget in seconds; every further one is twice the one before
    #[arg(long, value_parser = seconds, value_name = "TIME", default_value = "0.25")]
    pub first: f64,
    /// A method is not given more time once its relMSE is this small
    #[arg(long, value_name = "E")]
    pub target_error: Option<f64>,
    /// Output files without their endings; the scene's name with .accuracy in this folder by default
    #[arg(short, long, value_name = "STEM")]
    pub output: Option<PathBuf>,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

/// Options of `inspect`.
#[derive(Debug, Args)]
pub struct InspectOptions {
    /// A .glb or .gltf file
    pub scene: PathBuf,
    /// Tell of this map too, a .hdr or .exr file that is to light the scene
    #[arg(long, value_name = "FILE")]
    pub environment: Option<PathBuf>,
    /// Show the materials of this variant
    #[arg(long, value_name = "NAME", default_value = "")]
    pub variant: String,
}

/// Options of `compare`.
#[derive(Debug, Args)]
pub struct CompareOptions {
    /// The image to judge: EXR, HDR, PNG, JPEG or WebP
    pub image: PathBuf,
    /// The image it should be like
    pub reference: PathBuf,
}

const REPORT_HELP: &str = "\
Examples:
  ergodic report ajar.stats.json                     ajar.html: the picture, its statistics, the config
  ergodic report mlt path -o both.html               mlt.stats.json and path.stats.json, to flip between
  ergodic report mlt path --reference long.exr       with errors against a reference, by pixel
  ergodic report room.accuracy.json                  curves, tables and the picture of every method

The page is one file. It needs no network and opens from disk in any browser of 2023 or later.";

/// Options of `report`.
#[derive(Debug, Args)]
#[command(after_help = REPORT_HELP)]
pub struct ReportOptions {
    /// STEM.stats.json or STEM.exr of a render, STEM.json of an accuracy run, a stem of either, or any image. Pictures of one size
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// The picture that renders are compared with; an accuracy run brings its own
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,
    /// The page; the first file's name with .html by default
    #[arg(short, long, value_name = "FILE.html")]
    pub output: Option<PathBuf>,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

/// How much work `verify` puts into each case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Effort {
    /// Minutes: what the test suite runs
    Quick,
    /// Up to an hour: sees errors a quarter the size
    Full,
}

/// Options of `verify`.
#[derive(Debug, Args)]
pub struct VerifyOptions {
    /// Names of scenes in scenes/ with a reference in reference/; all of them by default
    pub scenes: Vec<String>,
    /// Test one method only: path, bidirectional, mlt, pssmlt or mmlt
    #[arg(long, value_parser = method, value_name = "METHOD")]
    pub method: Option<Method>,
    /// Test one mix of mutations only: full, or the name of a mutation, which is mixed with a little bidirectional
    #[arg(long, value_name = "MIX")]
    pub mix: Option<String>,
    /// How much work to put into it
    #[arg(long, value_enum, default_value_t = Effort::Quick)]
    pub budget: Effort,
    /// The first seed of the replicas
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Worker threads, 0 for one a core
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
    /// The folder that holds scenes/ and reference/
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub root: PathBuf,
    /// Where to write pictures of what failed
    #[arg(short, long, value_name = "DIR", default_value = ".")]
    pub output: PathBuf,
    /// Print failures only
    #[arg(short, long)]
    pub quiet: bool,
}

fn method(text: &str) -> Result<Method, String> {
    let found = Method::ALL.iter().find(|(_, name)| *name == text).map(|(method, _)| *method);
    found.ok_or_else(|| {
        let names: Vec<&str> = Method::ALL.iter().map(|(_, name)| *name).collect();
        format!("there are the methods {}", names.join(", "))
    })
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let numbers = text.split_once(['x', 'X']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    match numbers {
        Some((0, _) | (_, 0)) => Err("width and height must be at least 1".into()),
        Some(size) => Ok(size),
        None => Err("give width and height in pixels, like 640x360".into()),
    }
}

fn time(text: &str) -> Result<Budget, String> {
    seconds(text).map(Budget::Seconds)
}

fn seconds(text: &str) -> Result<f64, String> {
    let units = [("ms", 1e-3), ("s", 1.0), ("m", 60.0), ("h", 3600.0), ("", 1.0)];
    let seconds = units.iter().find_map(|(unit, seconds)| {
        let number: f64 = text.strip_suffix(unit)?.parse().ok()?;
        Some(number * seconds)
    });
    match seconds {
        Some(seconds) if seconds > 0.0 && seconds.is_finite() => Ok(seconds),
        _ => Err("give a time greater than 0, like 30s, 5m or 1.5h".into()),
    }
}

fn samples(text: &str) -> Result<Budget, String> {
    match text.parse::<f64>() {
        Ok(samples) if samples > 0.0 && samples.is_finite() => Ok(Budget::SamplesPerPixel(samples)),
        _ => Err("give a number greater than 0".into()),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Options::command().debug_assert();
    }

    #[test]
    fn values_are_read_with_their_units() {
        assert_eq!(size("640x360"), Ok((640, 360)));
        assert!(size("0x360").is_err() && size("640").is_err() && size("-1x2").is_err());
        assert_eq!(time("90"), Ok(Budget::Seconds(90.0)));
        assert_eq!(time("1.5h"), Ok(Budget::Seconds(5400.0)));
        assert_eq!(time("250ms"), Ok(Budget::Seconds(0.25)));
        assert!(time("0s").is_err() && time("nans").is_err() && time("soon").is_err());
        assert!(samples("inf").is_err() && samples("-1").is_err());
        assert_eq!(method("bidirectional"), Ok(Method::Bidirectional));
        assert!(method("pathh").unwrap_err().contains("path, bidirectional, mlt"));
    }
}
