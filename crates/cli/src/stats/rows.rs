//! Which tallies make a row, and what they come to together.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;

use super::class::ClassPattern;
use super::format::{MltStats, MutationStats, TallyStats};
use super::options::{Key, StatsOptions};
use super::read::Run;
use crate::error::CliError;

/// Classes that an error names at most.
const NAMED: usize = 24;

/// What a row is of; a part that rows are not told apart by is empty.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// Where the mutation stands in the mixtures.
    order: usize,
    pub mutation: Option<String>,
    pub length: Option<usize>,
    pub class: Option<String>,
}

impl Row {
    /// Share of the proposals that were not built for a reason.
    pub fn not_built(&self, reason: &str) -> f64 {
        self.tally.not_built.get(reason).copied().unwrap_or(0) as f64 / self.tally.proposed.max(1) as f64
    }
}

impl Place {
    /// As cells of a table, one for each key.
    pub fn cells(&self, by: &[Key]) -> Vec<String> {
        let or_other = |cell: Option<String>| cell.unwrap_or_else(|| "not told apart".into());
        let cell = |key: &Key| match key {
            Key::Mutation => or_other(self.mutation.clone()),
            Key::Length => or_other(self.length.map(|length| length.to_string())),
            Key::Class => or_other(self.class.clone()),
        };
        by.iter().map(cell).collect()
    }
}

/// What a row says of one run.
#[derive(Clone, Debug)]
pub struct Row {
    pub tally: TallyStats,
    /// Share of all proposals of the run.
    pub share: f64,
    /// Estimated processor time in seconds, and as a share of that of all mutations.
    pub seconds: Option<f64>,
    pub time_share: Option<f64>,
    /// Standard error of the acceptance.
    pub acceptance_error: Option<f64>,
    /// How many times the variance of a mean is that of independent proposals.
    pub correlation: Option<f64>,
}

/// The rows of one run.
#[derive(Debug)]
pub struct Rows {
    pub rows: BTreeMap<Place, Row>,
    /// Proposals that a filter could not judge, as nothing says of which length or class their paths were.
    pub unknown: u64,
}

/// A tally with what is known of its paths.
struct Part<'a> {
    length: Option<usize>,
    class: Option<&'a str>,
    tally: &'a TallyStats,
}

/// The recorded tallies that are just fine enough; sums of them would lose digits for nothing.
fn parts<'a>(mutation: &'a MutationStats, lengths: bool, classes: bool) -> Vec<Part<'a>> {
    let whole = || vec![Part { length: None, class: None, tally: &mutation.total }];
    if !lengths && !classes {
        return whole();
    }
    let mut parts: Vec<Part<'a>> = Vec::new();
    if classes {
        let part = |(class, tally): (&'a String, &'a TallyStats)| Part {
            length: Some(class.len() - 1),
            class: Some(class),
            tally,
        };
        parts.extend(mutation.by_class.iter().map(part));
    }
    let longest = parts.iter().filter_map(|part| part.length).max().unwrap_or(0);
    let by_length = mutation.by_length.iter().filter_map(|(length, tally)| Some((length.parse().ok()?, tally)));
    let longer = by_length.filter(|(length, _): &(usize, _)| *length > longest);
    parts.extend(longer.map(|(length, tally)| Part { length: Some(length), class: None, tally }));
    if parts.is_empty() { whole() } else { parts }
}

/// Several tallies as one; one alone stays as it is.
fn together(tallies: &[&TallyStats]) -> TallyStats {
    if let [only] = tallies {
        return (*only).clone();
    }
    let mut sum = TallyStats::default();
    let (mut acceptance, mut jump, mut nanoseconds, mut timed) = (0.0, 0.0, 0.0, 0.0);
    for tally in tallies {
        sum.proposed += tally.proposed;
        sum.faulty += tally.faulty;
        sum.accepted += tally.accepted;
        for (reason, count) in &tally.not_built {
            *sum.not_built.entry(reason.clone()).or_default() += count;
        }
        let proposed = tally.proposed as f64;
        let accepted = tally.acceptance.unwrap_or(0.0) * proposed;
        acceptance += accepted;
        jump += tally.mean_jump_pixels.unwrap_or(0.0) * accepted;
        if let Some(ns) = tally.ns_per_proposal {
            nanoseconds += ns * proposed;
            timed += proposed;
        }
    }
    sum.acceptance = (sum.proposed > 0).then(|| acceptance / sum.proposed as f64);
    sum.mean_jump_pixels = (acceptance > 0.0).then(|| jump / acceptance);
    sum.ns_per_proposal = (timed > 0.0).then(|| nanoseconds / timed);
    sum
}

/// Estimated processor time of the proposals in seconds.
fn seconds(tally: &TallyStats) -> Option<f64> {
    tally.ns_per_proposal.map(|ns| ns * 1e-9 * tally.proposed as f64)
}

/// The longest autocorrelation time in steps of what is measured of the chains.
pub fn autocorrelation(mlt: &MltStats) -> Option<f64> {
    let times = mlt.diagnostics.quantities.iter().map(|quantity| quantity.autocorrelation_time);
    times.collect::<Option<Vec<f64>>>()?.into_iter().reduce(f64::max).map(|time| time.max(1.0))
}

fn length_is_wanted(wanted: Option<&RangeInclusive<usize>>, length: Option<usize>) -> Option<bool> {
    wanted.map_or(Some(true), |range| length.map(|length| range.contains(&length)))
}

fn class_is_wanted(wanted: &[ClassPattern], class: Option<&str>) -> Option<bool> {
    if wanted.is_empty() {
        return Some(true);
    }
    class.map(|class| wanted.iter().any(|pattern| pattern.matches(class)))
}

/// The rows of a run; none if it has no mutations.
fn rows_of(run: &Run, options: &StatsOptions, order: &[String]) -> Rows {
    let mut rows = Rows { rows: BTreeMap::new(), unknown: 0 };
    let Some(mlt) = &run.stats.mlt else { return rows };
    let by = |key: Key| options.by.contains(&key);
    let (lengths, classes) = (by(Key::Length) || options.length.is_some(), by(Key::Class) || !options.class.is_empty());
    let mut groups: BTreeMap<Place, Vec<(usize, &TallyStats)>> = BTreeMap::new();
    for (index, mutation) in mlt.mutation_statistics.iter().enumerate() {
        if !options.mutation.is_empty() && !options.mutation.contains(&mutation.name) {
            continue;
        }
        for part in parts(mutation, lengths, classes) {
            let length = length_is_wanted(options.length.as_ref(), part.length);
            let class = class_is_wanted(&options.class, part.class);
            match (length, class) {
                (Some(true), Some(true)) => {}
                (Some(false), _) | (_, Some(false)) => continue,
                _ => {
                    rows.unknown += part.tally.proposed;
                    continue;
                }
            }
            let named = by(Key::Mutation);
            let place = Place {
                order: order.iter().position(|name| named && *name == mutation.name).unwrap_or(0),
                mutation: named.then(|| mutation.name.clone()),
                length: part.length.filter(|_| by(Key::Length)),
                class: part.class.filter(|_| by(Key::Class)).map(str::to_string),
            };
            groups.entry(place).or_default().push((index, part.tally));
        }
    }
    let totals = || mlt.mutation_statistics.iter().map(|mutation| &mutation.total);
    let all = totals().map(|tally| tally.proposed).sum::<u64>().max(1) as f64;
    let all_seconds: f64 = totals().filter_map(seconds).sum();
    let time = autocorrelation(mlt);
    for (place, tallies) in groups {
        let tally = together(&tallies.iter().map(|(_, tally)| *tally).collect::<Vec<_>>());
        let mutations: BTreeSet<usize> = tallies.iter().map(|(index, _)| *index).collect();
        // Mutations are drawn anew in each step, so that of a row's steps in a stretch of a chain only this share is seen: for
        // every lag but 0, correlations count as often.
        let thinning =
            mutations.iter().map(|index| mlt.mutation_statistics[*index].total.proposed).sum::<u64>() as f64 / all;
        let correlation = time.map(|time| 1.0 + (time - 1.0) * thinning);
        let error = |a: f64| correlation.map(|times| (a * (1.0 - a) / tally.proposed as f64 * times).sqrt());
        let row = Row {
            share: tally.proposed as f64 / all,
            seconds: seconds(&tally),
            time_share: seconds(&tally).filter(|_| all_seconds > 0.0).map(|seconds| seconds / all_seconds),
            acceptance_error: tally.acceptance.and_then(error),
            correlation,
            tally,
        };
        rows.rows.insert(place, row);
    }
    rows
}

/// The rows of all runs. A filter that nothing passes is an error that tells what there is.
pub fn rows(runs: &[Run], options: &StatsOptions) -> Result<Vec<Rows>, CliError> {
    let statistics = || runs.iter().filter_map(|run| run.stats.mlt.as_ref()).flat_map(|mlt| &mlt.mutation_statistics);
    let mut order: Vec<String> = Vec::new();
    for mutation in statistics() {
        if !order.contains(&mutation.name) {
            order.push(mutation.name.clone());
        }
    }
    let filters = !options.mutation.is_empty() || options.length.is_some() || !options.class.is_empty();
    if order.is_empty() && filters {
        let methods: Vec<&str> = runs.iter().map(|run| run.stats.method.as_str()).collect();
        return Err(CliError::Said(format!(
            "there is nothing to filter: a render by {} has no mutations",
            methods.join(", ")
        )));
    }
    if let Some(unknown) = options.mutation.iter().find(|name| !order.contains(name)) {
        return Err(CliError::Said(format!("there is no mutation {unknown}; there are {}", order.join(", "))));
    }
    let all: Vec<Rows> = runs.iter().map(|run| rows_of(run, options, &order)).collect();
    if filters && all.iter().all(|rows| rows.rows.is_empty()) {
        return Err(CliError::Said(format!("no path passes the filters; {}", what_there_is(statistics()))));
    }
    Ok(all)
}

/// Lengths and classes that have a row.
fn what_there_is<'a>(statistics: impl Iterator<Item = &'a MutationStats> + Clone) -> String {
    let lengths = statistics.clone().flat_map(|m| m.by_length.keys()).filter_map(|length| length.parse::<usize>().ok());
    let (shortest, longest) = lengths.fold((usize::MAX, 0), |(a, b), length| (a.min(length), b.max(length)));
    if longest == 0 {
        return "a step of these renders changes several paths at once, so that they have neither length nor class"
            .into();
    }
    // The most frequent first.
    let mut classes: BTreeMap<&str, u64> = BTreeMap::new();
    for (class, tally) in statistics.flat_map(|m| &m.by_class) {
        *classes.entry(class).or_default() += tally.proposed;
    }
    let mut classes: Vec<(&str, u64)> = classes.into_iter().collect();
    classes.sort_by_key(|(_, proposed)| std::cmp::Reverse(*proposed));
    let more = classes.len().saturating_sub(NAMED);
    let names: Vec<&str> = classes.iter().take(NAMED).map(|(class, _)| *class).collect();
    let rest = if more > 0 { format!(" and {more} rarer ones") } else { String::new() };
    format!("there are paths of {shortest} to {longest} edges, and of the classes {}{rest}", names.join(", "))
}
