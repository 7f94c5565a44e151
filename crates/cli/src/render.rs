//! `ergodic render`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use ergodic_assess::Exposure;
use ergodic_assets::{Asset, from_bytes_variant, load_variant};
use ergodic_pathspace::{Projection, Scene};
use ergodic_render::{LightUnits, Settings, render};

use crate::error::CliError;
use crate::options::RenderOptions;
use crate::output::Outputs;
use crate::progress::Progress;
use crate::{config, environment};
use crate::{report, terminal};

/// The scene that is rendered when none is named.
const BUILT_IN: &[u8] = include_bytes!("../../../scenes/ajar/scene.glb");
const BUILT_IN_NAME: &str = "ajar";

/// Renders and writes the files; true if it was interrupted.
pub fn run(options: &RenderOptions) -> Result<bool, CliError> {
    let settings = settings(options)?;
    let (mut asset, name) = if settings.scene.is_empty() {
        (from_bytes_variant(BUILT_IN, BUILT_IN_NAME, &settings.variant)?, BUILT_IN_NAME.to_string())
    } else {
        (load_variant(Path::new(&settings.scene), &settings.variant)?, settings.scene.clone())
    };
    let say = |line: &str| {
        if !options.quiet {
            eprintln!("{line}");
        }
    };
    let (environment, more_warnings) = environment::load(settings.environment.as_ref())?;
    for warning in asset.warnings.iter().chain(&more_warnings) {
        say(&format!("warning: {warning}"));
    }
    let hint = asset.light_units_hint().filter(|_| settings.light_units == LightUnits::Radiometric);
    for note in asset.notes.iter().chain(&hint) {
        say(&format!("note: {note}"));
    }
    let (intensity, irradiance) = settings.light_units.to_radiometric();
    asset.scale_lights(intensity, irradiance);
    if settings.variant.is_empty() && !asset.summary.variants.is_empty() {
        let names = asset.summary.variants.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ");
        say(&format!("{name} is shown with its default materials; --variant chooses one of {names}"));
    }
    let aspect = f64::from(settings.size.0) / f64::from(settings.size.1);
    let (camera, framed) = asset.camera(&settings.camera, aspect)?;
    if framed {
        say(&format!("{name} has no camera: it is seen from the front, framed whole"));
    }
    if settings.lens.is_some() && matches!(camera.projection, Projection::Orthographic { .. }) {
        let text = format!(
            "lens: {name} is seen by an orthographic camera, which has none; leave it out, or name another camera"
        );
        return Err(CliError::Said(text));
    }
    let outputs = Outputs::new(&stem(options, &settings))?;
    let Asset { mut description, file, .. } = asset;
    description.environment = environment;
    let scene = Scene::new(description, &settings.view(camera)).map_err(|e| CliError::Said(format!("{file}: {e}")))?;

    let unwatched = |e: std::io::Error| CliError::Said(format!("cannot watch for interruptions: {e}"));
    let progress = Progress::new(options.quiet).map_err(unwatched)?;
    let rendering = render(&Arc::new(scene), &settings, &progress);
    progress.finish();
    let rendering = rendering?;
    let exposure = options.exposure.map_or(Exposure::Automatic, Exposure::Stops);
    outputs.write(&name, &settings, &rendering, progress.interrupted(), exposure)?;
    if !options.quiet {
        let paths = outputs.paths().map(|p| p.display().to_string());
        let wrote = format!("wrote {}", paths.join(", "));
        terminal::print_lines(report::summary(&rendering).into_iter().chain([String::new(), wrote]));
    }
    if progress.interrupted() {
        say("stopped before the budget was used up; the files hold the picture so far");
    }
    Ok(progress.interrupted())
}

/// Defaults, then the config, then --set, then the options.
fn settings(options: &RenderOptions) -> Result<Settings, CliError> {
    let mut settings = match &options.config {
        Some(path) => config::load(path)?,
        None => Settings::default(),
    };
    let place_environment = |settings: &mut Settings| {
        if let Some(file) = &options.environment {
            settings.environment = Some(environment::with_file(settings.environment.take(), file));
        }
    };
    // Before --set, so that there is a map whose rotation and strength can be set, and after it, because options win.
    place_environment(&mut settings);
    for assignment in &options.set {
        settings = config::set(&settings, assignment)?;
    }
    if let Some(scene) = &options.scene {
        settings.scene = scene.display().to_string();
    }
    place_environment(&mut settings);
    if let Some(method) = options.method {
        settings.method = method;
    }
    if let Some(camera) = &options.camera {
        settings.camera.clone_from(camera);
    }
    if let Some(variant) = &options.variant {
        settings.variant.clone_from(variant);
    }
    if let Some(size) = options.size {
        settings.size = size;
    }
    if let Some(budget) = options.time.or(options.samples_per_pixel) {
        settings.budget = budget;
    }
    if let Some(seed) = options.seed {
        settings.seed = seed;
    }
    if let Some(threads) = options.threads {
        settings.threads = threads;
    }
    settings.validate().map_err(CliError::Said)?;
    Ok(settings)
}

/// Where to write: what was asked for, else the name of the scene, or of its folder where that says more.
fn stem(options: &RenderOptions, settings: &Settings) -> PathBuf {
    if let Some(stem) = &options.output {
        return stem.clone();
    }
    let path = Path::new(&settings.scene);
    let folder = path.parent().and_then(Path::file_name);
    let name = match path.file_stem() {
        None => BUILT_IN_NAME.into(),
        Some(name) if name == "scene" => folder.unwrap_or(name).to_os_string(),
        Some(name) => name.to_os_string(),
    };
    PathBuf::from(name)
}
