//! `cargo xtask profile`: where the time of mutations goes on a scene.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::{Value, json};

/// What `cargo xtask profile --help` prints.
const HELP: &str = "\
Usage: cargo xtask profile SCENE [--seconds S] [--json FILE]

Where the time of mutation steps goes on scenes/SCENE: the default mixture, one thread, 64 chains, 256 x 256 pixels. S is how long
to measure in all, 20 by default, without building. All times are processor time of the thread.

Two programs are built and run, because either slows down what it measures.

1. Bare rays. A round of 196608 mutations is recorded: every ray, in order. Then rounds of the same mutations, not recorded, and
   rounds that only trace the recorded rays again, in the same order, take turns. `ratio` is the median of mutation time by ray
   time: 1 would mean that a mutation costs nothing but its rays. Bare rays come from a list and have nothing between them, so
   their data stay in the caches better than in a mutation; the ratio tells that too.

2. Phases. Code marks where phases begin and end, by a store to one byte. While one thread makes mutations, another looks at the
   byte every 50 microseconds or more. `share` is how often it saw the phase, with the standard error of that many independent
   looks; `ns` is the share of the mutation's time. A phase within another interrupts it. The marks cost a little, most where
   phases are short; the last line says how much in all. The compiler and the processor may move work past a mark, some
   nanoseconds; so triangles and random numbers, which are short, are less certain than their error says.

traversal       World::intersect, visible, escapes without the tests of triangles
intersection    the tests of triangles
shading         vertices from hits, sampling of BSDFs, evaluation of the path's contribution
densities       ln_density of mutations, forward and backward
film            splats
random numbers  draws of the chains' streams
bookkeeping     the rest: copies of paths, edges, choices, acceptance, statistics
";

const DEFAULT_SECONDS: f64 = 20.0;

struct Options {
    scene: String,
    file: PathBuf,
    seconds: f64,
    json: Option<PathBuf>,
}

impl Options {
    fn read(arguments: &[String]) -> Result<Self, String> {
        let mut scene = None;
        let (mut seconds, mut json) = (DEFAULT_SECONDS, None);
        let mut rest = arguments.iter();
        while let Some(argument) = rest.next() {
            let mut value = || rest.next().ok_or(format!("{argument} needs a value; see `cargo xtask profile --help`"));
            match argument.as_str() {
                "--seconds" => {
                    let text = value()?;
                    seconds = text
                        .parse()
                        .ok()
                        .filter(|s: &f64| *s > 0.0 && s.is_finite())
                        .ok_or(format!("--seconds is `{text}`; it must be a number greater than 0"))?;
                }
                "--json" => json = Some(PathBuf::from(value()?)),
                name if scene.is_none() && !name.starts_with('-') => scene = Some(name.to_string()),
                other => return Err(format!("`{other}` is not understood; see `cargo xtask profile --help`")),
            }
        }
        let scene = scene.ok_or("name a scene, as in `cargo xtask profile ajar`")?;
        let file = crate::scenes_folder().join(&scene).join("scene.glb");
        if !file.exists() {
            let known = crate::scenes::ALL.iter().map(|recipe| recipe.name).collect::<Vec<_>>().join(", ");
            return Err(format!("there is no scene `{scene}`; the scenes are {known}"));
        }
        Ok(Self { scene, file, seconds, json })
    }
}

/// Builds the profile program with a feature, runs it and reads what it prints.
fn measured(feature: &str, options: &Options) -> Result<Value, String> {
    let output = Command::new(env!("CARGO"))
        .args(["run", "--quiet", "--release", "--package", "ergodic-profile", "--features", feature, "--"])
        .arg(&options.file)
        .arg((options.seconds / 2.0).to_string())
        .current_dir(crate::root())
        .stderr(Stdio::inherit())
        .output()
        .map_err(|e| format!("cannot run cargo: {e}"))?;
    if !output.status.success() {
        return Err(format!("the profile program with the feature `{feature}` failed; its message is above"));
    }
    serde_json::from_slice(&output.stdout).map_err(|e| format!("the profile program printed no JSON: {e}"))
}

/// A number of a report; NaN, which shows, if it is not there.
fn number(value: &Value, name: &str) -> f64 {
    value[name].as_f64().unwrap_or(f64::NAN)
}

fn print(scene: &str, rays: &Value, phases: &Value) {
    let (of_rays, of_phases) = (|name| number(rays, name), |name| number(phases, name));
    println!("{scene}: {:.0} ns a mutation, {:.2} M/s", of_rays("mutation_ns"), 1e3 / of_rays("mutation_ns"));
    println!(
        "rays a mutation: {:.2} closest, {:.2} any; {:.0} ns bare",
        of_rays("closest_per_mutation"),
        of_rays("any_per_mutation"),
        of_rays("bare_rays_ns")
    );
    println!(
        "ratio {:.2} of mutation to bare rays, {:.2} to {:.2} over {:.0} rounds\n",
        of_rays("ratio"),
        of_rays("least_ratio"),
        of_rays("most_ratio"),
        of_rays("rounds")
    );
    let head = format!("{:<14}  {:>15}  {:>6}", "phase", "share", "ns");
    println!("{head}\n{}", "-".repeat(head.len()));
    for phase in phases["phases"].as_array().into_iter().flatten() {
        let (share, error) = (number(phase, "share") * 100.0, number(phase, "standard_error") * 100.0);
        let name = phase["phase"].as_str().unwrap_or("?");
        println!("{name:<14}  {share:>5.1} +- {error:>3.1} %  {:>6.0}", number(phase, "ns"));
    }
    let marked = of_phases("mutation_ns") / of_rays("mutation_ns") - 1.0;
    println!("\n{:.0} looks; the marks make mutations {:+.0} % slower", of_phases("looks"), marked * 100.0);
}

fn write(file: &Path, scene: &str, rays: &Value, phases: &Value) -> Result<(), String> {
    let text = format!("{:#}\n", json!({ "scene": scene, "bare_rays": rays, "phases": phases }));
    std::fs::write(file, text).map_err(|e| format!("cannot write {}: {e}", file.display()))
}

/// Measures and tells.
pub fn run(arguments: &[String]) -> Result<(), String> {
    if arguments.iter().any(|argument| argument == "--help") {
        print!("{HELP}");
        return Ok(());
    }
    let options = Options::read(arguments)?;
    let rays = measured("record", &options)?;
    let phases = measured("phases", &options)?;
    print(&options.scene, &rays, &phases);
    options.json.as_ref().map_or(Ok(()), |file| write(file, &options.scene, &rays, &phases))
}
