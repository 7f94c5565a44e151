//! From the names on the command line to documents and pictures, all checked.

use std::fs;
use std::path::{Path, PathBuf};

use ergodic_assess::{Image, read_image};
use serde_json::{Value, json};

use crate::error::CliError;
use crate::{accuracy, report};
use shape::{AccuracyShape, StatsShape};

mod shape;

/// The JSON of a run.
pub struct Document {
    kind: &'static str,
    name: String,
    file: String,
    json: Value,
}

/// A picture of the page.
pub struct Shown {
    pub name: String,
    pub file: String,
    /// What it is, in a few words.
    pub caption: String,
    pub image: Image,
}

/// All that the page shows.
pub struct Inputs {
    pub title: String,
    pub documents: Vec<Document>,
    pub pictures: Vec<Shown>,
    /// Which of the pictures the others are compared with.
    pub reference: Option<usize>,
    pub warnings: Vec<String>,
}

/// What a name on the command line stands for.
enum Found {
    Json(PathBuf),
    Picture(PathBuf),
}

fn with_ending(stem: &Path, ending: &str) -> PathBuf {
    let mut name = stem.as_os_str().to_os_string();
    name.push(ending);
    PathBuf::from(name)
}

fn without_ending(path: &Path, ending: &str) -> Option<PathBuf> {
    path.to_str()?.strip_suffix(ending).map(PathBuf::from)
}

/// The file that is meant.
fn find(name: &Path) -> Result<Found, CliError> {
    let is_json = |path: &Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    if name.is_file() {
        let stats = without_ending(name, ".exr").map(|stem| with_ending(&stem, ".stats.json")).filter(|p| p.is_file());
        return Ok(match stats {
            Some(stats) => Found::Json(stats),
            None if is_json(name) => Found::Json(name.into()),
            None => Found::Picture(name.into()),
        });
    }
    for ending in [".stats.json", ".json", ".accuracy.json"] {
        let path = with_ending(name, ending);
        if path.is_file() {
            return Ok(Found::Json(path));
        }
    }
    let exr = with_ending(name, ".exr");
    if exr.is_file() {
        return Ok(Found::Picture(exr));
    }
    Err(CliError::Said(format!(
        "{}: there is no such file, nor one with .stats.json, .json, .accuracy.json or .exr added. Name the STEM.stats.json of \
         `ergodic render` or the STEM.accuracy.json of `ergodic accuracy`",
        name.display()
    )))
}

fn read_json(path: &Path) -> Result<Value, CliError> {
    let said = |problem: String| CliError::Said(format!("{}: {problem}", path.display()));
    let bytes = fs::read(path).map_err(|e| said(format!("cannot be read: {e}")))?;
    serde_json::from_slice(&bytes).map_err(|e| {
        said(format!("line {}, column {}: is not JSON: {e}. Render or measure again", e.line(), e.column()))
    })
}

/// Checks that a document is of the format that the page knows and has what the page shows.
fn check<T: serde::de::DeserializeOwned>(path: &Path, json: &Value, format: u64, again: &str) -> Result<T, CliError> {
    let said = |problem: String| CliError::Said(format!("{}: {problem}", path.display()));
    let version = json["version"].as_str().unwrap_or("an unknown version");
    match json["format"].as_u64() {
        Some(found) if found == format => {}
        Some(found) => {
            return Err(said(format!(
                "is of format {found}, written by ergodic {version}, but this is ergodic {}, which reads format {format}. {again}",
                env!("CARGO_PKG_VERSION")
            )));
        }
        None => return Err(said(format!("does not say its format, so an older ergodic wrote it. {again}"))),
    }
    serde_path_to_error::deserialize(json).map_err(|e| {
        let place = e.path().to_string();
        said(format!("at {place}: {}. {again}", e.into_inner()))
    })
}

impl Document {
    /// As the page holds it: integers that JavaScript would round are texts.
    pub fn embedded(&self) -> Value {
        fn exact(value: &Value) -> Value {
            const EXACT: u64 = 1 << 53;
            match value {
                Value::Number(n) if n.as_u64().is_some_and(|n| n > EXACT) => Value::String(n.to_string()),
                Value::Array(list) => list.iter().map(exact).collect(),
                Value::Object(map) => Value::Object(map.iter().map(|(k, v)| (k.clone(), exact(v))).collect()),
                other => other.clone(),
            }
        }
        json!({ "kind": self.kind, "name": self.name, "file": self.file, "json": exact(&self.json) })
    }
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

impl Inputs {
    /// Reads all files.
    pub fn read(files: &[PathBuf], reference: Option<&Path>) -> Result<Self, CliError> {
        let mut inputs = Self {
            title: String::new(),
            documents: Vec::new(),
            pictures: Vec::new(),
            reference: None,
            warnings: Vec::new(),
        };
        for file in files {
            match find(file)? {
                Found::Picture(path) => inputs.add_picture(&path)?,
                Found::Json(path) => {
                    let json = read_json(&path)?;
                    if json["methods"].is_array() {
                        inputs.add_accuracy(&path, json, reference)?;
                    } else if json["method"].is_string() {
                        inputs.add_render(&path, json)?;
                    } else {
                        return Err(CliError::Said(format!(
                            "{}: is neither the statistics of a render (it has no \"method\") nor an accuracy run (no \"methods\")",
                            path.display()
                        )));
                    }
                }
            }
        }
        if let Some(path) = reference {
            let image = read_image(path)?;
            inputs.reference = Some(inputs.pictures.len());
            inputs.push("reference".into(), path, "what the others are compared with".into(), image)?;
        }
        if inputs.title.is_empty() {
            inputs.title = inputs.pictures.iter().map(|p| p.name.clone()).collect::<Vec<_>>().join(", ");
        }
        Ok(inputs)
    }

    /// Width and height of all pictures.
    pub fn size(&self) -> (u32, u32) {
        self.pictures.first().map_or((0, 0), |p| (p.image.width, p.image.height))
    }

    fn push(&mut self, name: String, path: &Path, caption: String, image: Image) -> Result<(), CliError> {
        if let Some(first) = self.pictures.first()
            && self.size() != (image.width, image.height)
        {
            let (width, height) = self.size();
            return Err(CliError::Said(format!(
                "{} has {} x {} pixels, but {} {width} x {height}; pictures of one page have one size, so make another page for it, \
                 or render it again with --size {width}x{height}",
                path.display(),
                image.width,
                image.height,
                first.file
            )));
        }
        let file = path.display().to_string();
        let name = if self.pictures.iter().any(|p| p.name == name) { format!("{name} ({file})") } else { name };
        self.pictures.push(Shown { name, file, caption, image });
        Ok(())
    }

    fn add_title(&mut self, scene: &str) {
        let path = Path::new(scene);
        let stem = path.file_stem().unwrap_or(path.as_os_str());
        let folder = path.parent().and_then(Path::file_name);
        let name = if stem == "scene" { folder.unwrap_or(stem) } else { stem };
        let name = name.to_string_lossy().into_owned();
        if self.title.is_empty() {
            self.title = name;
        } else if !self.title.split(", ").any(|known| known == name) {
            self.title = format!("{}, {name}", self.title);
        }
    }

    fn add_picture(&mut self, path: &Path) -> Result<(), CliError> {
        let image = read_image(path)?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        self.warnings.push(format!("{}: no statistics lie beside it", path.display()));
        self.push(name, path, "a picture without statistics".into(), image)
    }

    fn add_render(&mut self, path: &Path, json: Value) -> Result<(), CliError> {
        let again = "Render again with this version";
        let shape: StatsShape = check(path, &json, report::STATS_FORMAT, again)?;
        let stem = without_ending(path, ".stats.json").unwrap_or_else(|| path.with_extension(""));
        let exr = with_ending(&stem, ".exr");
        if !exr.is_file() {
            return Err(CliError::Said(format!(
                "{}: the picture of {} is missing; they belong together, so put it there or render again",
                exr.display(),
                path.display()
            )));
        }
        let image = read_image(&exr)?;
        if (image.width, image.height) != (shape.width, shape.height) {
            return Err(CliError::Said(format!(
                "{} has {} x {} pixels, but {} tells of {} x {}; one of them is of another render. {again}",
                exr.display(),
                image.width,
                image.height,
                path.display(),
                shape.width,
                shape.height
            )));
        }
        let unit = if shape.mutation_statistics.is_some() { "mutations" } else { "samples" };
        let caption = format!(
            "{}, {}, {} {unit} a pixel",
            shape.method,
            crate::progress::human_time(shape.wall_seconds),
            crate::table::count(shape.samples_per_pixel)
        );
        let name = name_of(&stem);
        self.add_title(&shape.scene);
        self.documents.push(Document { kind: "render", name: name.clone(), file: path.display().to_string(), json });
        self.push(name, &exr, caption, image)
    }

    fn add_accuracy(&mut self, path: &Path, json: Value, reference: Option<&Path>) -> Result<(), CliError> {
        let shape: AccuracyShape = check(path, &json, accuracy::FORMAT, "Run the same `ergodic accuracy` again")?;
        if self.documents.iter().any(|d| d.kind == "accuracy") {
            return Err(CliError::Said(format!(
                "{}: is a second accuracy run; make a page for each, since each has a reference of its own",
                path.display()
            )));
        }
        if let Some(reference) = reference {
            return Err(CliError::Said(format!(
                "--reference {}: {} was measured against a reference of its own; leave --reference out",
                reference.display(),
                path.display()
            )));
        }
        let beside = |file: &str| path.with_file_name(file);
        for method in &shape.methods {
            let Some(picture) = &method.picture else {
                self.warnings.push(format!("{}: no picture of {} was kept", path.display(), method.name));
                continue;
            };
            let file = beside(&picture.file);
            if !file.is_file() {
                self.warnings.push(format!("{}: the picture of {} is missing", file.display(), method.name));
                continue;
            }
            let caption = format!("replica {} at a budget of {} s", picture.replica, picture.budget_seconds);
            self.push(method.name.clone(), &file, caption, read_image(&file)?)?;
        }
        let file = beside(&shape.reference.file);
        if file.is_file() {
            let image = read_image(&file)?;
            self.reference = Some(self.pictures.len());
            self.push("reference".into(), &file, "what the others are compared with".into(), image)?;
        } else {
            self.warnings
                .push(format!("{}: the reference is missing, so no errors by pixel are shown", file.display()));
        }
        self.add_title(&shape.scene);
        self.documents.push(Document {
            kind: "accuracy",
            name: name_of(&path.with_extension("")),
            file: path.display().to_string(),
            json,
        });
        Ok(())
    }
}
