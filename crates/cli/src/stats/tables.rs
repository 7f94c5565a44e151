//! Tables of rows for people.

use std::collections::BTreeSet;

use ergodic_render::R_HAT_LIMIT;

use super::columns::Column;
use super::layout::{self, Cells, Group};
use super::options::{Key, StatsOptions};
use super::read::Run;
use super::rows::{Place, Row, Rows};
use crate::table;

/// Reasons that are named in a row.
const NAMED_REASONS: usize = 2;

/// A share with its standard error in percent.
fn with_error(share: f64, error: f64) -> String {
    let digits = if error < 0.001 { 2 } else { 1 };
    format!("{:.digits$} +- {:.digits$} %", share * 100.0, error * 100.0)
}

/// A difference of two values, with its standard error where both have one, assuming that the renders are independent.
fn difference(column: &Column, row: &Row, first: &Row) -> Option<String> {
    let difference = (column.value)(row)? - (column.value)(first)?;
    let sign = if difference < 0.0 { "-" } else { "+" };
    let error = (column.error)(row).zip((column.error)(first)).map(|(a, b)| a.hypot(b));
    Some(match error {
        Some(error) => format!("{sign}{}", with_error(difference.abs(), error)),
        None => format!("{sign}{}", (column.show)(difference.abs())),
    })
}

fn cell(column: &Column, row: Option<&Row>) -> String {
    let shown = row.and_then(|row| {
        let value = (column.value)(row)?;
        Some((column.error)(row).map_or_else(|| (column.show)(value), |error| with_error(value, error)))
    });
    shown.unwrap_or_else(|| "-".into())
}

/// Why most proposals of a row were not built.
fn main_reasons(row: Option<&Row>) -> String {
    let Some(row) = row else { return String::new() };
    let mut reasons: Vec<(&String, u64)> = row.tally.not_built.iter().map(|(reason, n)| (reason, *n)).collect();
    reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let share = |n: u64| table::percent(n as f64 / row.tally.proposed.max(1) as f64);
    let named = reasons.iter().take(NAMED_REASONS).map(|(reason, n)| format!("{reason} {}", share(*n)));
    named.collect::<Vec<_>>().join(", ")
}

fn head(key: Key) -> &'static str {
    match key {
        Key::Mutation => "mutation",
        Key::Length => "edges",
        Key::Class => "class",
    }
}

fn labels(places: &[Place], by: &[Key]) -> Vec<Cells> {
    let label = |(i, key): (usize, &Key)| Cells {
        head: head(*key).into(),
        cells: places.iter().map(|place| place.cells(by)[i].clone()).collect(),
    };
    by.iter().enumerate().map(label).collect()
}

/// Renders that have rows, with the rest of what there is about them.
fn with_rows<'a>(runs: &'a [Run], rows: &'a [Rows]) -> Vec<(&'a Run, &'a Rows)> {
    runs.iter().zip(rows).filter(|(_, rows)| !rows.rows.is_empty()).collect()
}

fn main_table(shown: &[(&Run, &Rows)], places: &[Place], columns: &[&Column], options: &StatsOptions) -> Vec<String> {
    let column = |rows: &Rows, column: &Column| Cells {
        head: column.head.into(),
        cells: places.iter().map(|place| cell(column, rows.rows.get(place))).collect(),
    };
    let several = shown.len() > 1;
    let mut groups: Vec<Group> = shown
        .iter()
        .map(|(run, rows)| Group {
            title: if several { run.label.clone() } else { String::new() },
            columns: columns.iter().map(|c| column(rows, c)).collect(),
        })
        .collect();
    if let ([(_, rows)], true) = (shown, options.columns.is_empty() && !options.reasons) {
        let reasons = places.iter().map(|place| main_reasons(rows.rows.get(place)));
        groups[0].columns.push(Cells { head: "not built because".into(), cells: reasons.collect() });
    }
    if let Some((first, first_rows)) = shown.first() {
        for (run, rows) in &shown[1..] {
            let cells = |column: &Column| Cells {
                head: column.head.into(),
                cells: places
                    .iter()
                    .map(|place| {
                        let pair = rows.rows.get(place).zip(first_rows.rows.get(place));
                        pair.and_then(|(row, first)| difference(column, row, first)).unwrap_or_else(|| "-".into())
                    })
                    .collect(),
            };
            let columns: Vec<Cells> = columns.iter().filter(|column| column.differs).map(|c| cells(c)).collect();
            if !columns.is_empty() {
                groups.push(Group { title: format!("{} minus {}", run.label, first.label), columns });
            }
        }
    }
    layout::lines(&labels(places, &options.by), groups)
}

/// For each row and reason the share of proposals that were not built.
fn reasons_table(shown: &[(&Run, &Rows)], places: &[Place], options: &StatsOptions) -> Vec<String> {
    let mut lines: Vec<(&Place, String)> = Vec::new();
    for place in places {
        let rows = || shown.iter().filter_map(|(_, rows)| rows.rows.get(place));
        let names: BTreeSet<&String> = rows().flat_map(|row| row.tally.not_built.keys()).collect();
        let largest = |name: &str| rows().map(|row| row.not_built(name)).fold(0.0, f64::max);
        let mut names: Vec<(f64, &String)> = names.into_iter().map(|name| (largest(name), name)).collect();
        names.sort_by(|a, b| b.0.total_cmp(&a.0));
        lines.extend(names.into_iter().map(|(_, name)| (place, name.clone())));
    }
    let of_lines: Vec<Place> = lines.iter().map(|(place, _)| (*place).clone()).collect();
    let mut labels = labels(&of_lines, &options.by);
    labels
        .push(Cells { head: "not built because".into(), cells: lines.iter().map(|(_, name)| name.clone()).collect() });
    let cell = |rows: &Rows, place: &Place, name: &str| {
        let row = rows.rows.get(place).filter(|row| row.tally.proposed > 0);
        row.map_or("-".into(), |row| table::percent(row.not_built(name)))
    };
    let groups = shown.iter().map(|(run, rows)| Group {
        title: String::new(),
        columns: vec![Cells {
            head: run.label.clone(),
            cells: lines.iter().map(|(place, name)| cell(rows, place, name)).collect(),
        }],
    });
    layout::lines(&labels, groups.collect())
}

/// What the columns mean, and what the errors assume.
fn explanations(shown: &[(&Run, &Rows)], columns: &[&Column]) -> Vec<String> {
    let names = columns.iter().map(|column| column.head.len()).max().unwrap_or(0);
    let explain = |column: &&Column| layout::wrapped(&format!("{:names$}  {}", column.head, column.about), names + 2);
    let mut lines: Vec<String> = columns.iter().flat_map(explain).collect();
    if shown.iter().any(|(_, rows)| rows.rows.values().any(|row| row.acceptance_error.is_some())) {
        lines.extend(layout::wrapped(
            "+-  standard error. Steps of a chain depend on each other, so it takes the longest measured autocorrelation time of the \
             chains to be that of the acceptance too, and the variance of one acceptance to be a (1 - a), the greatest there can \
             be: on the safe side once the chains have mixed. A difference also takes the renders to be independent, with \
             another seed each. Columns without +- come from sums whose spread was not recorded.",
            4,
        ));
    }
    lines
}

/// What must be known besides the tables.
fn notes(shown: &[(&Run, &Rows)], runs: &[Run]) -> Vec<String> {
    let mut notes = Vec::new();
    for (run, rows) in runs
        .iter()
        .zip(std::iter::repeat(()))
        .map(|(run, ())| (run, shown.iter().find(|(other, _)| std::ptr::eq(*other, run)).map(|(_, rows)| *rows)))
    {
        let label = &run.label;
        match &run.stats.mlt {
            None => notes.push(format!("{label}: a render by {} has no mutations", run.stats.method)),
            Some(mlt) => {
                let worst = mlt.diagnostics.quantities.iter().filter_map(|quantity| quantity.r_hat).fold(1.0, f64::max);
                if worst > R_HAT_LIMIT {
                    notes.push(format!(
                        "{label}: its chains have not mixed (R-hat {worst:.2}), so its standard errors are too small"
                    ));
                }
            }
        }
        if let Some(rows) = rows.filter(|rows| rows.unknown > 0) {
            let count = table::count(rows.unknown as f64);
            notes.push(format!(
                "{label}: {count} proposals were left out, as nothing says of which length or class their paths were; paths of more \
                 than 8 edges have no class"
            ));
        }
    }
    let same =
        |(i, run): (usize, &(&Run, &Rows))| shown[..i].iter().any(|(other, _)| other.stats.seed == run.0.stats.seed);
    if shown.iter().enumerate().any(same) {
        notes.push("renders with the same seed share random numbers, so they are not quite independent".into());
    }
    notes
}

/// The tables, notes and explanations.
pub fn lines(
    runs: &[Run],
    rows: &[Rows],
    places: &[Place],
    columns: &[&Column],
    options: &StatsOptions,
) -> Vec<String> {
    let shown = with_rows(runs, rows);
    let mut lines = Vec::new();
    if !shown.is_empty() {
        lines.push(String::new());
        lines.extend(main_table(&shown, places, columns, options));
        if options.reasons {
            lines.push(String::new());
            lines.extend(reasons_table(&shown, places, options));
        }
    }
    let notes = notes(&shown, runs);
    if !notes.is_empty() {
        lines.push(String::new());
        lines.extend(notes.iter().flat_map(|note| layout::wrapped(note, 2)));
    }
    if !options.brief && !shown.is_empty() {
        lines.push(String::new());
        lines.extend(explanations(&shown, columns));
    }
    lines
}
