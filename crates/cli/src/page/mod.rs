//! `ergodic report`: one HTML page of a render or an accuracy run.
//!
//! `input` finds and checks the files, `picture` packs what a browser is to draw, `html` puts the page together. All that is
//! shown is made by the page's own script (`js/`) from the JSON of the run, which the page holds word for word, so that no figure
//! is written down twice.

mod html;
mod input;
mod picture;

use std::path::{Path, PathBuf};

use ergodic_assess::{Exposure, Image, RELATIVE_EPSILON, check_writable, compare_with_map, write_whole};
use serde_json::json;

use crate::error::CliError;
use crate::options::ReportOptions;
use crate::terminal;
use html::Blob;
use input::{Inputs, Shown};

/// Pages up to this size open at once. Larger ones are written too, with a hint.
const COMFORTABLE_BYTES: usize = 15 << 20;

/// Makes the page.
pub fn run(options: &ReportOptions) -> Result<(), CliError> {
    let output = match (&options.output, options.files.first()) {
        (Some(output), _) => output.clone(),
        (None, Some(first)) => default_output(first),
        (None, None) => return Err(CliError::Said("name a file of a render or of an accuracy run".into())),
    };
    check_writable(&output)?;
    let inputs = Inputs::read(&options.files, options.reference.as_deref())?;
    let page = page(&inputs)?;
    write_whole(&output, page.as_bytes())?;
    if !options.quiet {
        let mib = page.len() as f64 / f64::from(1 << 20);
        terminal::print_lines([format!("wrote {}, {mib:.1} MiB", output.display())]);
        if page.len() > COMFORTABLE_BYTES {
            let (width, height) = inputs.size();
            eprintln!(
                "note: {} pictures of {width} x {height} make a large page, which opens slowly; name fewer",
                inputs.pictures.len()
            );
        }
    }
    Ok(())
}

/// The name of the first file, without what it has of endings.
fn default_output(first: &Path) -> PathBuf {
    let name = first.file_name().unwrap_or_default().to_string_lossy();
    let stem = [".stats.json", ".json", ".exr", ".png", ".hdr"].iter().find_map(|ending| name.strip_suffix(ending));
    first.with_file_name(format!("{}.html", stem.unwrap_or(&name)))
}

/// The text of the page.
fn page(inputs: &Inputs) -> Result<String, CliError> {
    let reference = inputs.reference.map(|i| &inputs.pictures[i].image);
    // All pictures are shown alike, as our PNG shows the reference, or else the first.
    let base = reference.or(inputs.pictures.first().map(|p| &p.image)).map_or(1.0, |i| Exposure::Automatic.factor(i));
    let (mut pictures, mut blobs, mut warnings) = (Vec::new(), Vec::new(), inputs.warnings.clone());
    for (i, shown) in inputs.pictures.iter().enumerate() {
        let packed = picture::pack(&shown.image);
        blobs.push(Blob { id: format!("picture-{i}"), bytes: packed.bytes });
        let against = reference.filter(|_| inputs.reference != Some(i));
        let (comparison, flip) = match against {
            Some(reference) => compared(shown, reference, &mut warnings),
            None => (None, None),
        };
        let has_flip = flip.is_some();
        blobs.extend(flip.map(|bytes| Blob { id: format!("flip-{i}"), bytes }));
        pictures.push(json!({
            "name": shown.name,
            "file": shown.file,
            "caption": shown.caption,
            "width": shown.image.width,
            "height": shown.image.height,
            "scale": packed.scale,
            "clipped": packed.clipped,
            "flip": has_flip,
            "comparison": comparison,
        }));
    }
    let data = json!({
        "generator": concat!("ergodic ", env!("CARGO_PKG_VERSION")),
        "title": inputs.title,
        "pictures": pictures,
        "reference": inputs.reference,
        "exposure": base,
        "rel_mse_epsilon": RELATIVE_EPSILON,
        "documents": inputs.documents.iter().map(input::Document::embedded).collect::<Vec<_>>(),
        "warnings": warnings,
    });
    html::assemble(&inputs.title, &data, &blobs)
}

/// Distances of a picture from the reference, and the map of FLIP; neither where a pixel is no number.
fn compared(
    shown: &Shown,
    reference: &Image,
    warnings: &mut Vec<String>,
) -> (Option<serde_json::Value>, Option<Vec<u8>>) {
    match compare_with_map(&shown.image, reference) {
        Ok((c, flip)) => {
            let json = json!({
                "mse": c.mse,
                "rel_mse": c.rel_mse,
                "trimmed_rel_mse": c.trimmed_rel_mse,
                "flip": c.flip,
                "bias": c.total_mean_ratio - 1.0,
            });
            (Some(json), Some(picture::pack_flip(&flip)))
        }
        Err(what) => {
            warnings.push(format!("{} cannot be compared with the reference: {what}", shown.name));
            (None, None)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_are_named_after_what_they_show() {
        let of = |name: &str| default_output(Path::new(name)).display().to_string();
        assert_eq!(of("out/a.stats.json"), "out/a.html");
        assert_eq!(of("a.accuracy.json"), "a.accuracy.html");
        assert_eq!(of("out/v1.2"), "out/v1.2.html");
    }
}
