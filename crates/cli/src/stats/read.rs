//! Finds the stats of renders and reads them.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use ergodic_render::Method;

use super::format::Stats;
use crate::error::CliError;

/// How the file's name ends.
const ENDING: &str = ".stats.json";

/// One render.
#[derive(Debug)]
pub struct Run {
    /// What tables call it: the name of the file without its ending, or the path where names are the same.
    pub label: String,
    /// The file.
    pub path: PathBuf,
    pub stats: Stats,
}

/// Reads the stats of renders.
pub fn read(files: &[PathBuf]) -> Result<Vec<Run>, CliError> {
    let mut runs = files.iter().map(|file| read_one(file)).collect::<Result<Vec<_>, _>>()?;
    let stem = |path: &Path, name: Option<&OsStr>| {
        let text = name.unwrap_or(path.as_os_str()).to_string_lossy();
        text.strip_suffix(ENDING).unwrap_or(&text).to_string()
    };
    let names: Vec<String> = runs.iter().map(|run| stem(&run.path, run.path.file_name())).collect();
    for (run, name) in runs.iter_mut().zip(&names) {
        let unique = names.iter().filter(|other| *other == name).count() == 1;
        run.label = if unique { name.clone() } else { stem(&run.path, None) };
    }
    Ok(runs)
}

/// Where the stats are that a file, or a stem, stands for.
fn find(file: &Path) -> PathBuf {
    let text = file.as_os_str().to_string_lossy();
    let stem = [".exr", ".png"].iter().find_map(|ending| text.strip_suffix(ending));
    match stem {
        Some(stem) => PathBuf::from(format!("{stem}{ENDING}")),
        None if file.is_file() => file.into(),
        None if text.ends_with(ENDING) => file.into(),
        None => PathBuf::from(format!("{text}{ENDING}")),
    }
}

fn read_one(file: &Path) -> Result<Run, CliError> {
    let path = find(file);
    let said = |what: String| CliError::Said(format!("{}: {what}", path.display()));
    let bytes = std::fs::read(&path).map_err(|e| {
        said(format!("cannot be read: {e}; give STEM{ENDING}, which `ergodic render` writes beside STEM.exr"))
    })?;
    let stats: Stats = serde_json::from_slice(&bytes).map_err(|e| said(what_else(&bytes, &e)))?;
    // A part that may be missing is missing as well if it cannot be read, so what went wrong is asked again.
    let chains = Method::ALL.iter().any(|(method, name)| *name == stats.method && has_chains(*method));
    if chains && stats.mlt.is_none() {
        let reason = serde_json::from_slice::<super::format::MltStats>(&bytes).err();
        let reason = reason.map_or_else(String::new, |e| format!(": {e}"));
        return Err(said(format!("the statistics of its mutations cannot be read{reason}")));
    }
    Ok(Run { label: String::new(), path, stats })
}

fn has_chains(method: Method) -> bool {
    !matches!(method, Method::Path | Method::Bidirectional)
}

/// Why a file is not what is wanted, in words.
fn what_else(bytes: &[u8], error: &serde_json::Error) -> String {
    let value: Option<serde_json::Value> = serde_json::from_slice(bytes).ok();
    let has = |key: &str| value.as_ref().is_some_and(|value| value.get(key).is_some());
    if value.is_none() {
        format!("is not JSON; give STEM{ENDING}, which `ergodic render` writes")
    } else if has("rel_mse_epsilon") {
        format!("is the result of `ergodic accuracy`; give STEM{ENDING}, which `ergodic render` writes")
    } else if has("version") && has("method") && has("rays") {
        let version = value.as_ref().and_then(|value| value["version"].as_str()).unwrap_or("?");
        format!("was written by version {version}, whose format is another: {error}; render again")
    } else {
        format!("is not the stats of a render: {error}; give STEM{ENDING}, which `ergodic render` writes")
    }
}
