//! What each render is as a whole, and by which settings renders differ.

use std::collections::BTreeSet;

use super::format::{MltStats, Stats};
use super::layout::{self, Cells, Group};
use super::read::Run;
use crate::progress::human_time;
use crate::{override_path, table};

/// Settings longer than this are cut.
const LONGEST_VALUE: usize = 32;

/// A line of the table: what it is called, and what it says of a render.
type Fact = (&'static str, fn(&Stats) -> Option<String>);

fn mlt(stats: &Stats, of: impl Fn(&MltStats) -> String) -> Option<String> {
    stats.mlt.as_ref().map(of)
}

/// The largest of a diagnostic over what is measured.
fn largest(mlt: &MltStats, of: fn(&super::format::Quantity) -> Option<f64>, show: fn(f64) -> String) -> String {
    mlt.diagnostics.quantities.iter().filter_map(of).reduce(f64::max).map_or_else(|| "-".into(), show)
}

const FACTS: [Fact; 16] = [
    ("method", |stats| Some(stats.method.clone())),
    ("size", |stats| Some(format!("{}x{}", stats.width, stats.height))),
    ("samples, or mutations, a pixel", |stats| Some(table::count(stats.samples_per_pixel))),
    ("wall time", |stats| {
        let stopped = if stats.interrupted { ", stopped" } else { "" };
        Some(format!("{}{stopped}", human_time(stats.wall_seconds)))
    }),
    ("threads", |stats| Some(stats.threads.to_string())),
    ("rays a second", |stats| Some(table::count(stats.rays_per_second))),
    ("mean radiance", |stats| Some(stats.mean.map(|mean| format!("{mean:.4}")).join(" "))),
    ("contributions left out", |stats| Some(stats.stability.total.to_string())),
    ("b, and its standard error", |stats| mlt(stats, |m| format!("{:.5} +- {:.2} %", m.b, m.b_relative_error * 100.0))),
    ("time of seeding, direct light", |stats| {
        mlt(stats, |m| format!("{}, {}", human_time(m.seeding_seconds), human_time(m.direct_seconds)))
    }),
    ("mutations", |stats| {
        mlt(stats, |m| {
            format!("{}, {} a second", table::count(m.mutations as f64), table::count(m.mutations_per_second))
        })
    }),
    ("chains", |stats| mlt(stats, |m| m.chains.to_string())),
    ("mutations of a chain before it begins anew", |stats| {
        mlt(stats, |m| m.life.map_or("-".into(), |life| life.to_string()))
    }),
    ("longest autocorrelation, steps", |stats| {
        mlt(stats, |m| largest(m, |quantity| quantity.autocorrelation_time, |steps| format!("{steps:.1}")))
    }),
    ("largest R-hat", |stats| mlt(stats, |m| largest(m, |quantity| quantity.r_hat, |r_hat| format!("{r_hat:.3}")))),
    ("longest stay", |stats| {
        mlt(stats, |m| format!("{} steps, {}", m.diagnostics.longest_stay, m.diagnostics.longest_stay_class))
    }),
];

/// Settings that are not the same in all renders: the path, and the value of each render.
fn differing(runs: &[Run]) -> Vec<(String, Vec<String>)> {
    let leaves: Vec<Vec<(String, &str)>> = runs.iter().map(|run| override_path::leaves(&run.stats.config)).collect();
    let mut seen = BTreeSet::new();
    let paths = leaves.iter().flatten().map(|(path, _)| path).filter(|path| seen.insert(*path));
    let values = |path: &String| -> Vec<String> {
        let of_run =
            |leaves: &Vec<(String, &str)>| leaves.iter().find(|(other, _)| other == path).map(|(_, v)| v.to_string());
        leaves.iter().map(|leaves| of_run(leaves).unwrap_or("-".into())).collect()
    };
    // The table has these anyway.
    let paths = paths.filter(|path| !["method", "size.0", "size.1"].contains(&path.as_str()));
    let all = paths.map(|path| (path.clone(), values(path)));
    all.filter(|(_, values)| values.iter().any(|value| *value != values[0])).collect()
}

/// A value in one line that is not too long.
fn short(value: &str) -> String {
    let words = value.split_whitespace().collect::<Vec<_>>().join(" ");
    let cut = words.chars().count() > LONGEST_VALUE;
    if cut { words.chars().take(LONGEST_VALUE - 3).chain("...".chars()).collect() } else { words }
}

/// The table.
pub fn lines(runs: &[Run]) -> Vec<String> {
    let mut rows: Vec<(String, Vec<String>)> = FACTS
        .iter()
        .map(|(name, of)| (*name, runs.iter().map(|run| of(&run.stats)).collect::<Vec<_>>()))
        .filter(|(_, values)| values.iter().any(Option::is_some))
        .map(|(name, values)| (name.into(), values.into_iter().map(|value| value.unwrap_or("-".into())).collect()))
        .collect();
    rows.extend(differing(runs).into_iter().map(|(path, values)| (path, values.iter().map(|v| short(v)).collect())));
    let labels = Cells { head: "render".into(), cells: rows.iter().map(|(name, _)| name.clone()).collect() };
    let column = |i: usize| Cells {
        head: runs[i].label.clone(),
        cells: rows.iter().map(|(_, values)| values[i].clone()).collect(),
    };
    let group = |i: usize| Group { title: String::new(), columns: vec![column(i)] };
    let mut lines = layout::lines(&[labels], (0..runs.len()).map(group).collect());
    for run in runs {
        let warnings = run.stats.mlt.iter().flat_map(|mlt| &mlt.diagnostics.warnings);
        lines.extend(warnings.flat_map(|warning| layout::wrapped(&format!("warning, {}: {warning}", run.label), 2)));
    }
    lines
}
