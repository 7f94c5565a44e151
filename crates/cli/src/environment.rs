//! The environment that settings ask for.

use std::path::Path;

use ergodic_assets::load_environment;
use ergodic_render::{EnvironmentMap, EnvironmentSettings};
use ergodic_scattering::{Environment, Rgb};

use crate::error::CliError;

/// Loads it, with warnings of what is wrong with its file.
pub fn load(settings: Option<&EnvironmentSettings>) -> Result<(Option<Environment>, Vec<String>), CliError> {
    match settings {
        None => Ok((None, Vec::new())),
        Some(EnvironmentSettings::Constant(r, g, b)) => {
            Ok((Some(Environment::constant(Rgb::new(*r, *g, *b))), Vec::new()))
        }
        Some(EnvironmentSettings::Map(EnvironmentMap { file, rotation, strength })) => {
            let (environment, warnings) = load_environment(Path::new(file), *strength, *rotation)?;
            Ok((Some(environment), warnings))
        }
    }
}

/// The settings with the map in `file`, which keeps rotation and strength if they had another map.
pub fn with_file(settings: Option<EnvironmentSettings>, file: &Path) -> EnvironmentSettings {
    let file = file.display().to_string();
    match settings {
        Some(EnvironmentSettings::Map(map)) => EnvironmentSettings::Map(EnvironmentMap { file, ..map }),
        _ => EnvironmentSettings::Map(EnvironmentMap { file, ..EnvironmentMap::default() }),
    }
}

/// Its size, mean radiance and orientation.
pub fn describe(environment: &Environment) -> [String; 3] {
    let (width, height) = environment.size();
    let mean = environment.mean();
    let bytes = environment.bytes() as f64 / f64::from(1 << 20);
    [
        format!("{width} x {height} texels, {bytes:.1} MiB"),
        format!("{mean:.4}"),
        "middle column +x, right of it +z, top +y".into(),
    ]
}
