//! What can be shown of a row, and what it means.

use super::rows::Row;
use crate::table;

/// A column.
#[derive(Debug)]
pub struct Column {
    /// Its name in options and files.
    pub name: &'static str,
    /// Its name in tables.
    pub head: &'static str,
    /// What it means.
    pub about: &'static str,
    pub value: fn(&Row) -> Option<f64>,
    /// The standard error of the value, where the data tell it.
    pub error: fn(&Row) -> Option<f64>,
    pub show: fn(f64) -> String,
    /// Whether it is shown of a render alone, and of each of several, if no columns are chosen.
    pub usual: [bool; 2],
    /// Whether the difference of two renders says something.
    pub differs: bool,
}

fn none(_: &Row) -> Option<f64> {
    None
}

fn unbuilt(row: &Row) -> f64 {
    row.tally.not_built.values().sum::<u64>() as f64
}

fn of_proposed(row: &Row, count: f64) -> Option<f64> {
    (row.tally.proposed > 0).then(|| count / row.tally.proposed as f64)
}

fn moved(row: &Row) -> Option<f64> {
    Some(row.tally.acceptance? * row.tally.mean_jump_pixels?)
}

/// All columns.
pub const ALL: [Column; 13] = [
    Column {
        name: "proposed",
        head: "proposed",
        about: "proposals begun",
        value: |row| Some(row.tally.proposed as f64),
        error: none,
        show: table::count,
        usual: [true, true],
        differs: false,
    },
    Column {
        name: "share",
        head: "share",
        about: "of all proposals of the render",
        value: |row| Some(row.share),
        error: none,
        show: table::percent,
        usual: [true, false],
        differs: false,
    },
    Column {
        name: "built",
        head: "built",
        about: "proposals that came to a path at all; --reasons tells why the others did not",
        value: |row| of_proposed(row, row.tally.proposed as f64 - unbuilt(row)),
        error: none,
        show: table::percent,
        usual: [true, false],
        differs: true,
    },
    Column {
        name: "acceptance",
        head: "accepted",
        about: "mean probability to be accepted; a proposal that was not built counts as 0",
        value: |row| row.tally.acceptance,
        error: |row| row.acceptance_error,
        show: table::percent,
        usual: [true, true],
        differs: true,
    },
    Column {
        name: "accepted",
        head: "moves",
        about: "proposals that were accepted",
        value: |row| Some(row.tally.accepted as f64),
        error: none,
        show: table::count,
        usual: [false, false],
        differs: false,
    },
    Column {
        name: "jump_pixels",
        head: "jump px",
        about: "mean distance on the image that an accepted proposal moves, in pixels",
        value: |row| row.tally.mean_jump_pixels,
        error: none,
        show: |pixels| format!("{pixels:.2}"),
        usual: [true, true],
        differs: true,
    },
    Column {
        name: "move_pixels",
        head: "move px",
        about: "mean distance that a proposal moves, accepted or not: accepted times jump; too small a jump explores \
                as little as too bold a one that is refused",
        value: moved,
        error: none,
        show: |pixels| format!("{pixels:.3}"),
        usual: [true, false],
        differs: true,
    },
    Column {
        name: "ns",
        head: "ns",
        about: "time of a proposal in nanoseconds, acceptance test and splats included, from one step in 16",
        value: |row| row.tally.ns_per_proposal,
        error: none,
        show: |ns| format!("{ns:.0}"),
        usual: [true, true],
        differs: true,
    },
    Column {
        name: "seconds",
        head: "seconds",
        about: "time of all its proposals, all threads together: ns times proposed",
        value: |row| row.seconds,
        error: none,
        show: |seconds| format!("{seconds:.2}"),
        usual: [false, false],
        differs: false,
    },
    Column {
        name: "time_share",
        head: "of time",
        about: "of the time of all mutations",
        value: |row| row.time_share,
        error: none,
        show: table::percent,
        usual: [true, true],
        differs: false,
    },
    Column {
        name: "moves_per_ms",
        head: "moves/ms",
        about: "accepted proposals in a millisecond of time: acceptance over ns",
        value: |row| Some(row.tally.acceptance? / row.tally.ns_per_proposal? * 1e6),
        error: none,
        show: |rate| format!("{rate:.0}"),
        usual: [false, false],
        differs: true,
    },
    Column {
        name: "correlation",
        head: "corr",
        about: "how many times the variance of a mean is that of independent proposals, from the autocorrelation time",
        value: |row| row.correlation,
        error: none,
        show: |times| format!("{times:.1}"),
        usual: [false, false],
        differs: false,
    },
    Column {
        name: "faulty",
        head: "faulty",
        about: "proposals with a density that was no number; 0 in a correct renderer",
        value: |row| Some(row.tally.faulty as f64),
        error: none,
        show: |count| format!("{count:.0}"),
        usual: [true, false],
        differs: false,
    },
];

/// The columns that are shown: those named, or the usual ones of one render or of several.
///
/// # Errors
///
/// A sentence for a name that there is not.
pub fn chosen(names: &[String], several: bool) -> Result<Vec<&'static Column>, String> {
    if names.is_empty() {
        return Ok(ALL.iter().filter(|column| column.usual[usize::from(several)]).collect());
    }
    names.iter().map(|name| named(name)).collect()
}

/// The column of a name.
///
/// # Errors
///
/// A sentence with the names that there are.
pub fn named(name: &str) -> Result<&'static Column, String> {
    let found = ALL.iter().find(|column| column.name == name || column.head == name);
    found.ok_or_else(|| {
        let names: Vec<&str> = ALL.iter().map(|column| column.name).collect();
        format!("there is no column {name}; there are {}", names.join(", "))
    })
}
