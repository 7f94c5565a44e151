//! `cargo xtask reference`: the stored images that renders are tested against.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use ergodic_assess::{Attribute, Image, Reference};
use ergodic_pathspace::Scene;
use ergodic_render::{Budget, Method, Observer, Settings, Stage, render_replicas};

/// Width and height of all references.
const SIZE: (u32, u32) = (64, 64);

/// Replicas of each reference. Those of `ergodic verify` have other seeds.
const REPLICAS: usize = 32;
const FIRST_SEED: u64 = 1 << 32;

/// How a scene's reference is made: by the unbiased estimator of independent samples that has the least error for its time
/// there. None is made by Markov chains, which the references are there to test.
struct Plan {
    scene: &'static str,
    method: Method,
    samples_per_pixel: f64,
}

const PLANS: [Plan; 6] = [
    Plan { scene: "cornell", method: Method::Bidirectional, samples_per_pixel: 192.0 },
    Plan { scene: "ajar", method: Method::Bidirectional, samples_per_pixel: 384.0 },
    Plan { scene: "ring", method: Method::Bidirectional, samples_per_pixel: 256.0 },
    Plan { scene: "glass", method: Method::Path, samples_per_pixel: 1536.0 },
    Plan { scene: "dusk", method: Method::Path, samples_per_pixel: 384.0 },
    Plan { scene: "pool", method: Method::Path, samples_per_pixel: 2048.0 },
];

/// Tells of every tenth replica.
struct Lines;

impl Observer for Lines {
    fn progress(&self, stage: Stage, done: f64) {
        if stage == Stage::Rendering && (done * 10.0).fract() < 1.0 / REPLICAS as f64 * 10.0 - 1e-9 {
            eprintln!("  {:.0} %", done * 100.0);
        }
    }

    fn should_stop(&self) -> bool {
        false
    }
}

/// Writes the references of the named scenes, of all if none is named.
pub fn write(names: &[String]) -> Result<(), String> {
    for recipe in crate::chosen(names)? {
        let sky = recipe.sky.is_some();
        let plan = PLANS.iter().find(|plan| plan.scene == recipe.name);
        write_one(plan.ok_or_else(|| format!("there is no plan for the reference of {}", recipe.name))?, sky)?;
    }
    Ok(())
}

fn settings(plan: &Plan) -> Settings {
    Settings {
        method: plan.method,
        size: SIZE,
        seed: FIRST_SEED,
        budget: Budget::SamplesPerPixel(plan.samples_per_pixel),
        ..Settings::default()
    }
}

/// Makes the reference of a scene, with the sky in its folder if it has one.
fn write_one(plan: &Plan, sky: bool) -> Result<(), String> {
    let name = plan.scene;
    eprintln!("{name}: {REPLICAS} replicas by {}", plan.method.name());
    let settings = settings(plan);
    let folder = crate::scenes_folder().join(name);
    let mut asset = ergodic_assets::load(&folder.join("scene.glb")).map_err(|e| e.to_string())?;
    if sky {
        let (environment, _) =
            ergodic_assets::load_environment(&folder.join(crate::SKY), 1.0, 0.0).map_err(|e| e.to_string())?;
        asset.description.environment = Some(environment);
    }
    let (camera, _) = asset.camera("", f64::from(SIZE.0) / f64::from(SIZE.1)).map_err(|e| e.to_string())?;
    let scene = Scene::new(asset.description, &settings.view(camera)).map_err(|e| e.to_string())?;
    let start = Instant::now();
    let renderings = render_replicas(&scene, &settings, REPLICAS, &Lines).map_err(|e| e.to_string())?;
    let seconds = start.elapsed().as_secs_f64();
    let refused: u64 = renderings.iter().map(|r| r.counts.stability.total()).sum();
    let images: Vec<Image> = renderings
        .iter()
        .map(|r| Image {
            width: r.picture.width,
            height: r.picture.height,
            pixels: r.picture.pixels.iter().map(|p| p.to_array()).collect(),
        })
        .collect();
    let reference = Reference::from_replicas(&images).ok_or("there are too few replicas")?;
    let (total, total_error) = reference.total();
    let block_error = reference.median_block_error();

    let folder = crate::root().join("reference");
    let attributes = [
        ("ergodic.scene", Attribute::Text(name.into())),
        ("ergodic.method", Attribute::Text(plan.method.name().into())),
        ("ergodic.replicas", Attribute::Number(REPLICAS as f64)),
    ];
    reference.write(&folder.join(format!("{name}.exr")), &attributes).map_err(|e| e.to_string())?;
    let provenance = provenance(plan, seconds, refused, (total, total_error, block_error));
    std::fs::write(folder.join(format!("{name}.ron")), provenance).map_err(|e| format!("{name}.ron: {e}"))?;
    eprintln!(
        "  mean luminance {total:.6} +- {:.3} %, median block +- {:.2} %, {seconds:.0} s",
        total_error * 100.0,
        block_error * 100.0
    );
    Ok(())
}

/// What produced a reference, and how good it is.
fn provenance(plan: &Plan, seconds: f64, refused: u64, (total, total_error, block_error): (f64, f64, f64)) -> String {
    format!(
        "// How reference/{name}.exr was made. Remake it with the command.\n(\n    command: \"cargo xtask reference {name}\",\n    \
         commit: \"{commit}\",\n    method: \"{method}\",\n    size: {SIZE:?},\n    replicas: {REPLICAS},\n    \
         first_seed: {FIRST_SEED},\n    // samples a pixel in each replica\n    samples_per_pixel: {spp:?},\n    \
         seconds: {seconds:.0},\n    refused_splats: {refused},\n    mean_luminance: {total:.7},\n    \
         relative_error_of_the_mean: {total_error:.2e},\n    median_relative_error_of_a_block: {block_error:.2e},\n)\n",
        name = plan.scene,
        commit = commit(),
        method = plan.method.name(),
        spp = plan.samples_per_pixel,
    )
}

/// The commit that is checked out, with a mark if other files than the references differ from it.
fn commit() -> String {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).current_dir(Path::new(env!("CARGO_MANIFEST_DIR"))).output();
        output.ok().filter(|o| o.status.success()).map(|o| String::from_utf8_lossy(&o.stdout).trim().to_string())
    };
    let head = git(&["rev-parse", "HEAD"]).unwrap_or_else(|| "unknown".into());
    let changed = git(&["status", "--porcelain", "--untracked-files=no", "--", ":/", ":!/reference"])
        .is_some_and(|text| !text.is_empty());
    if changed { format!("{head} with changes") } else { head }
}
