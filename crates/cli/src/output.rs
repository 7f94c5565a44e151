//! The three files of a render.

use std::path::{Path, PathBuf};

use ergodic_assess::{
    Attribute, Exposure, FileError, Image, Window, check_writable, write_exr, write_png, write_whole,
};
use ergodic_render::{Picture, Rendering, Settings};

use crate::census::PlanStats;
use crate::config;
use crate::error::CliError;
use crate::source::Source;
use crate::stats::format::Stats;

/// Where the files go.
#[derive(Debug)]
pub struct Outputs {
    exr: PathBuf,
    png: PathBuf,
    stats: PathBuf,
}

impl Outputs {
    /// The files of a stem, known to be writable.
    pub fn new(stem: &Path) -> Result<Self, CliError> {
        if stem.file_name().is_none() {
            let text = format!("-o {} names no file; give a stem like out/picture", stem.display());
            return Err(CliError::Said(text));
        }
        let with = |ending: &str| {
            let mut name = stem.as_os_str().to_os_string();
            name.push(ending);
            PathBuf::from(name)
        };
        let outputs = Self { exr: with(".exr"), png: with(".png"), stats: with(".stats.json") };
        for path in outputs.paths() {
            check_writable(path)?;
        }
        Ok(outputs)
    }

    /// All of them.
    pub fn paths(&self) -> [&Path; 3] {
        [&self.exr, &self.png, &self.stats]
    }

    /// Writes a render.
    pub fn write(
        &self,
        source: &Source,
        settings: &Settings,
        rendering: &Rendering,
        interrupted: bool,
        exposure: Exposure,
    ) -> Result<(), CliError> {
        let image = image(&rendering.picture);
        let layers = rendering.mlt.as_ref().and_then(|report| report.layers.as_ref());
        let extra: Vec<(&str, &[f64])> = layers.map_or_else(Vec::new, |layers| {
            vec![
                ("acceptance", &layers.acceptance[..]),
                ("longest_stay", &layers.longest_stay),
                ("standard_error", &layers.standard_error),
            ]
        });
        let window = settings.crop.map(|(left, top, ..)| Window { corner: (left, top), whole: settings.size });
        write_exr(&self.exr, &image, window, &extra, &attributes(source, settings, rendering))?;
        write_png(&self.png, &image, exposure)?;
        let json = Stats::new(source, settings, rendering, interrupted).to_json();
        let json = json.map_err(|e| CliError::Said(format!("{} cannot be encoded: {e}", self.stats.display())))?;
        write_whole(&self.stats, &json).map_err(|e: FileError| e.into())
    }
}

/// A picture as an image of files and metrics.
pub fn image(picture: &Picture) -> Image {
    let pixels = picture.pixels.iter().map(|p| p.to_array()).collect();
    Image { width: picture.width, height: picture.height, pixels }
}

/// What the EXR says of itself.
fn attributes(source: &Source, settings: &Settings, rendering: &Rendering) -> Vec<(&'static str, Attribute)> {
    let text = |text: &str| Attribute::Text(text.into());
    let plan = PlanStats::new(&source.plan, source.scene.repertoire(), &settings.mlt.mutations);
    let plan = serde_json::to_string(&plan).unwrap_or_default();
    let mut list = vec![
        ("ergodic.version", text(env!("CARGO_PKG_VERSION"))),
        ("ergodic.scene", text(&source.name)),
        ("ergodic.effects", text(&plan)),
        ("ergodic.config", text(&config::to_ron(settings))),
        ("ergodic.seed", Attribute::Number(settings.seed as f64)),
        ("ergodic.method", text(settings.method.name())),
        ("ergodic.seconds", Attribute::Number(rendering.seconds)),
        ("ergodic.samples_per_pixel", Attribute::Number(rendering.samples_per_pixel)),
        ("ergodic.rays", Attribute::Number(rendering.counts.rays as f64)),
    ];
    if let Some(report) = &rendering.mlt {
        list.push(("ergodic.mutations", Attribute::Number(report.mutations as f64)));
        list.push(("ergodic.b", Attribute::Number(report.b)));
        list.push(("ergodic.b_relative_error", Attribute::Number(report.b_relative_error)));
    }
    list
}
