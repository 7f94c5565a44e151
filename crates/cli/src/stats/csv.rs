//! All columns with all their digits, one line for each row of each render.

use std::collections::BTreeSet;

use super::columns;
use super::read::Run;
use super::rows::{Place, Row, Rows};

/// A cell as RFC 4180 has it.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

fn number(value: Option<f64>) -> String {
    value.filter(|value| value.is_finite()).map_or_else(String::new, |value| value.to_string())
}

/// Names and values of what a render is, the same in all its lines.
fn of_run(run: &Run) -> Vec<(&'static str, String)> {
    let stats = &run.stats;
    let mlt = stats.mlt.as_ref();
    let whole = |value: Option<u64>| value.map_or_else(String::new, |value| value.to_string());
    vec![
        ("run", quoted(&run.label)),
        ("scene", quoted(&stats.scene)),
        ("method", quoted(&stats.method)),
        ("seed", stats.seed.to_string()),
        ("width", stats.width.to_string()),
        ("height", stats.height.to_string()),
        ("threads", stats.threads.to_string()),
        ("samples_per_pixel", number(Some(stats.samples_per_pixel))),
        ("wall_seconds", number(Some(stats.wall_seconds))),
        ("rays", stats.rays.to_string()),
        ("mean_red", number(Some(stats.mean[0]))),
        ("mean_green", number(Some(stats.mean[1]))),
        ("mean_blue", number(Some(stats.mean[2]))),
        ("left_out", stats.stability.total.to_string()),
        ("b", number(mlt.map(|mlt| mlt.b))),
        ("b_relative_error", number(mlt.map(|mlt| mlt.b_relative_error))),
        ("mutations", whole(mlt.map(|mlt| mlt.mutations))),
        ("chains", whole(mlt.map(|mlt| mlt.chains as u64))),
        ("life", whole(mlt.and_then(|mlt| mlt.life))),
    ]
}

/// The whole file. A render without rows has one line, with what it has.
pub fn text(runs: &[Run], rows: &[Rows], places: &[Place]) -> String {
    let reasons: BTreeSet<&str> = rows
        .iter()
        .flat_map(|rows| rows.rows.values())
        .flat_map(|row| row.tally.not_built.keys().map(String::as_str))
        .collect();
    let mut head: Vec<String> =
        runs.first().map_or_else(Vec::new, |run| of_run(run).into_iter().map(|(name, _)| name.to_string()).collect());
    head.extend(["mutation", "length", "class"].map(str::to_string));
    head.extend(columns::ALL.iter().map(|column| column.name.to_string()));
    head.push("acceptance_error".into());
    head.extend(reasons.iter().map(|reason| format!("not_built.{reason}")));
    let mut text = head.join(",") + "\n";
    for (run, rows) in runs.iter().zip(rows) {
        let about: Vec<String> = of_run(run).into_iter().map(|(_, value)| value).collect();
        let mut line = |place: Option<&Place>, row: Option<&Row>| {
            let mut cells = about.clone();
            let of_place = |of: &dyn Fn(&Place) -> Option<String>| quoted(&place.and_then(of).unwrap_or_default());
            cells.push(of_place(&|place| place.mutation.clone()));
            cells.push(of_place(&|place| place.length.map(|length| length.to_string())));
            cells.push(of_place(&|place| place.class.clone()));
            cells.extend(columns::ALL.iter().map(|column| number(row.and_then(column.value))));
            cells.push(number(row.and_then(|row| row.acceptance_error)));
            let count = |reason: &str| row.map(|row| row.tally.not_built.get(reason).copied().unwrap_or(0) as f64);
            cells.extend(reasons.iter().map(|reason| number(count(reason))));
            text.push_str(&cells.join(","));
            text.push('\n');
        };
        for place in places {
            if let Some(row) = rows.rows.get(place) {
                line(Some(place), Some(row));
            }
        }
        if rows.rows.is_empty() {
            line(None, None);
        }
    }
    text
}
