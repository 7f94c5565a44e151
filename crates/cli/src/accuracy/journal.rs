//! What has been measured so far, a line of JSON for each replica, so that nothing is lost when a run is stopped.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use ergodic_render::Settings;
use serde::{Deserialize, Serialize};

use super::plan::Entrant;
use super::reference::Known;
use crate::config;
use crate::error::CliError;
use crate::options::AccuracyOptions;

/// One replica.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The method or mix.
    pub name: String,
    /// Which budget.
    pub level: usize,
    pub replica: usize,
    /// The budget in seconds.
    pub budget: f64,
    /// Seconds of processor time that it took.
    pub seconds: f64,
    pub wall_seconds: f64,
    /// Errors, those of the reference taken off.
    pub rel_mse: f64,
    pub trimmed_rel_mse: f64,
    pub mse: f64,
    /// FLIP, from which nothing can be taken off.
    pub flip: f64,
    /// Mean of the picture over that of the reference, less 1.
    pub bias: f64,
    /// Whether its picture was kept.
    #[serde(default)]
    pub picture: bool,
}

/// The file and what is in it.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    records: Vec<Record>,
}

/// What two runs must have in common for one to go on from the other.
pub fn header(
    scene: &str,
    settings: &Settings,
    entrants: &[Entrant],
    options: &AccuracyOptions,
    known: &Known,
) -> String {
    let mixes: Vec<_> = entrants.iter().map(|e| (&e.name, e.method.name(), &e.mutations)).collect();
    let settings = Settings { threads: 0, ..settings.clone() };
    serde_json::json!({
        "ergodic_accuracy": 1,
        "version": env!("CARGO_PKG_VERSION"),
        "scene": scene,
        "settings": config::to_ron(&settings),
        "entrants": format!("{mixes:?}"),
        "first": options.first,
        "reference": known.mark(),
    })
    .to_string()
}

impl Journal {
    /// Opens the file, or makes it.
    pub fn open(path: &Path, header: &str) -> Result<Self, CliError> {
        let said = |problem: String| CliError::Said(format!("{}: {problem}", path.display()));
        let text = match std::fs::read_to_string(path) {
            Ok(text) => text,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => String::new(),
            Err(e) => return Err(said(format!("cannot be read: {e}"))),
        };
        let mut lines = text.lines();
        let is_new = match lines.next() {
            None => true,
            Some(line) if line == header => false,
            Some(_) => {
                return Err(said(
                    "was made by a run with another scene, other settings, methods or another reference; remove it to begin \
                     again, or name another output by -o"
                        .into(),
                ));
            }
        };
        // The last line may have been cut off.
        let records: Vec<Record> = lines.filter_map(|line| serde_json::from_str(line).ok()).collect();
        let file = OpenOptions::new().create(true).append(true).open(path);
        let mut journal =
            Self { path: path.into(), file: file.map_err(|e| said(format!("cannot be written: {e}")))?, records };
        if is_new {
            journal.line(header)?;
        } else if !text.ends_with('\n') {
            journal.line("")?;
        }
        Ok(journal)
    }

    fn line(&mut self, line: &str) -> Result<(), CliError> {
        writeln!(self.file, "{line}")
            .and_then(|()| self.file.flush())
            .map_err(|e| CliError::Said(format!("{}: cannot be written: {e}", self.path.display())))
    }

    /// Keeps a replica.
    pub fn add(&mut self, record: Record) -> Result<(), CliError> {
        let line = serde_json::to_string(&record)
            .map_err(|e| CliError::Said(format!("{}: cannot be encoded: {e}", self.path.display())))?;
        self.line(&line)?;
        self.records.push(record);
        Ok(())
    }

    /// All replicas.
    pub fn records(&self) -> &[Record] {
        &self.records
    }

    /// Whether a replica is there.
    pub fn has(&self, name: &str, level: usize, replica: usize) -> bool {
        self.records.iter().any(|r| r.name == name && r.level == level && r.replica == replica)
    }

    /// Whether a picture of the method at a longer budget was kept.
    pub fn has_later_picture(&self, name: &str, level: usize) -> bool {
        self.records.iter().any(|r| r.picture && r.name == name && r.level > level)
    }

    /// Mean relMSE of a method at one budget, once all replicas are there.
    pub fn mean_error(&self, name: &str, level: usize, replicas: usize) -> Option<f64> {
        let errors = self.records.iter().filter(|r| r.name == name && r.level == level).map(|r| r.rel_mse);
        let (sum, n) = errors.fold((0.0, 0), |(sum, n), e| (sum + e, n + 1));
        (n >= replicas).then(|| sum / n as f64)
    }
}
