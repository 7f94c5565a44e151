//! The options of `ergodic stats`.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::class::ClassPattern;
use super::columns;

const EXAMPLES: &str = "\
Examples:
  ergodic stats ajar.stats.json                          the tables of a render
  ergodic stats a b --reasons                            two renders side by side, and why proposals were not built
  ergodic stats ajar --by mutation,length --length 2..5  each mutation on paths of 2 to 5 edges
  ergodic stats ajar --class 'LS+DE' --by class          caustics: any number of specular bounces, then a diffuse one
  ergodic stats a b c --by class --sort seconds          which paths the time was spent on
  ergodic stats a b --csv - | column -s, -t              everything as comma separated values, with all digits";

fn after_help() -> String {
    let names = columns::ALL.iter().map(|column| column.name.len()).max().unwrap_or(0);
    let column = |column: &columns::Column| format!("  {:names$}  {}", column.name, column.about);
    let list: Vec<String> = columns::ALL.iter().map(column).collect();
    format!("Columns:\n{}\n\n{EXAMPLES}", list.join("\n"))
}

/// What rows are told apart by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Key {
    /// The mutation that proposed
    Mutation,
    /// The number of edges of the path that was to be changed
    Length,
    /// Heckbert's class of that path from the light L to the eye E: S for a specular vertex, D for any other
    Class,
}

/// Options of `stats`.
#[derive(Debug, Args)]
#[command(after_help = after_help())]
pub struct StatsOptions {
    /// Renders: STEM.stats.json, or STEM, STEM.exr or STEM.png beside it; the first is what the others are compared with
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Only these mutations, like lens,caustic
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    pub mutation: Vec<String>,
    /// Only paths of these numbers of edges: 3, or 2..5 for 2 to 5, 6.. or ..4
    #[arg(long, value_parser = lengths, value_name = "EDGES")]
    pub length: Option<RangeInclusive<usize>>,
    /// Only paths of these classes, like LSDE or 'LS+DE': . is S or D, * any number of the letter before it, + at least one
    #[arg(long, value_delimiter = ',', value_parser = ClassPattern::parse, value_name = "CLASSES")]
    pub class: Vec<ClassPattern>,
    /// One row for each: mutation, length, class, or several of them
    #[arg(long, value_delimiter = ',', value_enum, default_value = "mutation", value_name = "KEYS")]
    pub by: Vec<Key>,
    /// Columns to show, in this order; listed below
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    pub columns: Vec<String>,
    /// Order rows by this column of the first render that has it, the largest first
    #[arg(long, value_name = "COLUMN")]
    pub sort: Option<String>,
    /// Show for what reasons proposals were not built
    #[arg(long)]
    pub reasons: bool,
    /// Write all columns as comma separated values, one line for each row of each render; - for standard output and no tables
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Leave out what the columns mean
    #[arg(short, long)]
    pub brief: bool,
}

fn lengths(text: &str) -> Result<RangeInclusive<usize>, String> {
    let number = |text: &str, none: usize| if text.is_empty() { Some(none) } else { text.parse().ok() };
    let range = match text.split_once("..") {
        Some((from, to)) if !(from.is_empty() && to.is_empty()) => {
            number(from, 0).zip(number(to.trim_start_matches('='), usize::MAX))
        }
        Some(_) => None,
        None => text.parse().ok().map(|n| (n, n)),
    };
    match range {
        Some((from, to)) if from <= to => Ok(from..=to),
        Some((from, to)) => Err(format!("{from} is more than {to}; give the smaller number first, like {to}..{from}")),
        None => Err("give a number of edges, like 3, or a range, like 2..5, 6.. or ..4".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_include_both_ends() {
        assert_eq!(lengths("3"), Ok(3..=3));
        assert_eq!(lengths("2..5"), Ok(2..=5));
        assert_eq!(lengths("2..=5"), Ok(2..=5));
        assert_eq!(lengths("6.."), Ok(6..=usize::MAX));
        assert_eq!(lengths("..4"), Ok(0..=4));
        for wrong in ["", "..", "two", "1..x", "-1", "1...3"] {
            assert!(lengths(wrong).unwrap_err().contains("2..5"), "{wrong}");
        }
        assert!(lengths("5..2").unwrap_err().contains("2..5"));
    }
}
