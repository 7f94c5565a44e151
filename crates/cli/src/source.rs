//! From options to settings, and from settings to a scene that is ready to be rendered.

use std::path::{Path, PathBuf};

use ergodic_assets::{Asset, from_bytes_variant, load_variant};
use ergodic_pathspace::{Census, Plan, Projection, Scene};
use ergodic_render::{LightUnits, Settings};
use ergodic_scattering::Medium;

use crate::census::{self, CensusRow};
use crate::error::CliError;
use crate::options::SourceOptions;
use crate::{config, environment};

/// The scene that is rendered when none is named.
const BUILT_IN: &[u8] = include_bytes!("../../../scenes/ajar/scene.glb");
const BUILT_IN_NAME: &str = "ajar";

/// A scene, and what is known of it.
pub struct Source {
    /// Ready to be rendered.
    pub scene: Scene,
    /// What it is called.
    pub name: String,
    /// Which effects it has, and which the code is ready for.
    pub plan: Plan,
    /// What it has of every effect.
    pub census: Vec<CensusRow>,
    /// What the picture lacks, and how the file is shown where it could be otherwise.
    pub warnings: Vec<String>,
    pub notes: Vec<String>,
}

/// Defaults, then the config, then --set, then the options.
pub fn settings(options: &SourceOptions) -> Result<Settings, CliError> {
    let mut settings = match &options.config {
        Some(path) => config::load(path)?,
        None => Settings::default(),
    };
    let place_environment = |settings: &mut Settings| {
        if let Some(file) = &options.environment {
            settings.environment = Some(environment::with_file(settings.environment.take(), file));
        }
    };
    // Before --set, so that there is a map whose rotation and strength can be set and a size that a crop lies in, and after it,
    // because options win.
    place_environment(&mut settings);
    settings.size = options.size.unwrap_or(settings.size);
    for assignment in &options.set {
        settings = config::set(&settings, assignment)?;
    }
    if let Some(scene) = &options.scene {
        settings.scene = scene.display().to_string();
    }
    place_environment(&mut settings);
    if let Some(camera) = &options.camera {
        settings.camera.clone_from(camera);
    }
    if let Some(variant) = &options.variant {
        settings.variant.clone_from(variant);
    }
    settings.size = options.size.unwrap_or(settings.size);
    if let Some(seed) = options.seed {
        settings.seed = seed;
    }
    if let Some(threads) = options.threads {
        settings.threads = threads;
    }
    settings.validate().map_err(CliError::Said)?;
    Ok(settings)
}

/// Loads the scene of the settings and builds it; what people should know is said by `say`.
pub fn open(settings: &Settings, say: &dyn Fn(&str)) -> Result<Source, CliError> {
    let (mut asset, name) = if settings.scene.is_empty() {
        (from_bytes_variant(BUILT_IN, BUILT_IN_NAME, &settings.variant)?, BUILT_IN_NAME.to_string())
    } else {
        (load_variant(Path::new(&settings.scene), &settings.variant)?, settings.scene.clone())
    };
    let (environment, more_warnings) = environment::load(settings.environment.as_ref())?;
    let mut warnings: Vec<String> = asset.warnings.iter().chain(&more_warnings).map(ToString::to_string).collect();
    for warning in &warnings {
        say(&format!("warning: {warning}"));
    }
    let hint = asset.light_units_hint().filter(|_| settings.light_units == LightUnits::Radiometric);
    let notes: Vec<String> = asset.notes.iter().chain(&hint).map(ToString::to_string).collect();
    for note in &notes {
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
    let Asset { mut description, file, .. } = asset;
    if let Some(environment) = environment {
        if description.environment.is_some() {
            say(&format!(
                "note: the environment is the one of the settings, not that of {name} (EXT_lights_image_based); leave it \
                 out to see the file's own"
            ));
        }
        description.environment = Some(environment);
    }
    description.medium = settings.medium.map_or(Medium::VACUUM, |medium| medium.medium());
    let mut view = settings.view(camera);
    let census = census::rows(&Census::of(&description, Some(&view.camera)), &description);
    let plan = description.plan(&mut view.camera, &settings.effects);
    for effect in plan.missing().iter() {
        let warning = format!("{} is forced off, so the picture lacks what the scene has of it", effect.name());
        say(&format!("warning: {warning}"));
        warnings.push(warning);
    }
    let scene = Scene::new(description, &view).map_err(|e| CliError::Said(format!("{file}: {e}")))?;
    Ok(Source { scene, name, plan, census, warnings, notes })
}

/// Where to write if nothing else was asked for: the name of the scene, or of its folder where that says more.
pub fn stem(settings: &Settings) -> PathBuf {
    let path = Path::new(&settings.scene);
    let folder = path.parent().and_then(Path::file_name);
    let name = match path.file_stem() {
        None => BUILT_IN_NAME.into(),
        Some(name) if name == "scene" => folder.unwrap_or(name).to_os_string(),
        Some(name) => name.to_os_string(),
    };
    PathBuf::from(name)
}
