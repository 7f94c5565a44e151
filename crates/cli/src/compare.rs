//! `ergodic compare`.

use ergodic_assess::{RELATIVE_EPSILON, TRIMMED_SHARE, compare, read_image};

use crate::error::CliError;
use crate::options::CompareOptions;
use crate::{table, terminal};

/// Tells how far an image is from a reference.
pub fn run(options: &CompareOptions) -> Result<(), CliError> {
    let (image, reference) = (read_image(&options.image)?, read_image(&options.reference)?);
    let c = compare(&image, &reference).map_err(|what| {
        CliError::Said(format!("{} and {}: {what}", options.image.display(), options.reference.display()))
    })?;
    let [r, g, b] = c.mean_ratio;
    let flip = if c.flip_is_hdr { "FLIP (high dynamic range)" } else { "FLIP" };
    let row = |name: &str, value: String, meaning: String| vec![name.to_string(), value, meaning];
    let rows = [
        row("MSE", format!("{:.6e}", c.mse), "mean squared error".into()),
        row("relMSE", format!("{:.6e}", c.rel_mse), format!("squared error over reference^2 + {RELATIVE_EPSILON}")),
        row(
            "trimmed relMSE",
            format!("{:.6e}", c.trimmed_rel_mse),
            format!("without the worst {} % of the pixels", TRIMMED_SHARE * 100.0),
        ),
        row("mean ratio", format!("{:.6}", c.total_mean_ratio), format!("red {r:.6}, green {g:.6}, blue {b:.6}")),
        row(flip, format!("{:.6}", c.flip), "visible difference, 0 none to 1".into()),
    ];
    terminal::print_lines(table::lines(&["measure", "value", "meaning"], &rows));
    Ok(())
}
