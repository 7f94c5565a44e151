//! `ergodic stats`: the statistics of renders, side by side.
//!
//! `format` is the contents of a file, `read` finds and reads them, `rows` takes together what the options ask for, `columns` says
//! what a row shows, `tables`, `facts` and `csv` put it down.

mod class;
mod columns;
mod csv;
mod facts;
pub mod format;
mod layout;
pub mod options;
mod read;
mod rows;
mod tables;

use std::collections::BTreeSet;

use ergodic_assess::write_whole;

use crate::error::CliError;
use crate::terminal;
use options::StatsOptions;

/// Shows the tables, or writes them.
pub fn run(options: &StatsOptions) -> Result<(), CliError> {
    let columns = columns::chosen(&options.columns, options.files.len() > 1).map_err(CliError::Said)?;
    let sort = options.sort.as_deref().map(columns::named).transpose().map_err(CliError::Said)?;
    let runs = read::read(&options.files)?;
    let rows = rows::rows(&runs, options)?;
    let all: BTreeSet<&rows::Place> = rows.iter().flat_map(|rows| rows.rows.keys()).collect();
    let mut places: Vec<rows::Place> = all.into_iter().cloned().collect();
    if let Some(column) = sort {
        let value = |place: &rows::Place| rows.iter().find_map(|rows| rows.rows.get(place).and_then(column.value));
        let order = |place: &rows::Place| value(place).unwrap_or(f64::NEG_INFINITY);
        places.sort_by(|a, b| order(b).total_cmp(&order(a)));
    }
    let mut wrote = Vec::new();
    if let Some(file) = &options.csv {
        let text = csv::text(&runs, &rows, &places);
        if file.as_os_str() == "-" {
            terminal::print_lines(text.lines());
            return Ok(());
        }
        write_whole(file, text.as_bytes())?;
        wrote = vec![String::new(), format!("wrote {}", file.display())];
    }
    let mut lines = facts::lines(&runs);
    lines.extend(tables::lines(&runs, &rows, &places, &columns, options));
    lines.extend(wrote);
    terminal::print_lines(lines);
    Ok(())
}
