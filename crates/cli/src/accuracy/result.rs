//! What the replicas say: tables, advice, accuracy.json, accuracy.csv and plots.

use std::path::{Path, PathBuf};

use ergodic_assess::accuracy::{Curve, Interval, Sample, overtakes, relative_efficiency};
use ergodic_assess::{RELATIVE_EPSILON, TRIMMED_SHARE, write_whole};
use ergodic_render::Settings;
use serde_json::{Value, json};

use super::journal::Record;
use super::pictures;
use super::plan::Entrant;
use super::plot::{self, Band};
use super::reference::Known;
use super::with_ending;
use crate::error::CliError;
use crate::options::AccuracyOptions;
use crate::{config, table};

/// What accuracy.json says of how it is written; another number for what programs that read it would misread.
pub const FORMAT: u64 = 1;

/// A way of saying how far a picture is from the reference.
#[derive(Clone, Copy)]
struct Metric {
    name: &'static str,
    key: &'static str,
    of: fn(&Record) -> f64,
}

const METRICS: [Metric; 4] = [
    Metric { name: "relMSE", key: "rel_mse", of: |r| r.rel_mse },
    Metric { name: "trimmed relMSE", key: "trimmed_rel_mse", of: |r| r.trimmed_rel_mse },
    Metric { name: "MSE", key: "mse", of: |r| r.mse },
    Metric { name: "FLIP", key: "flip", of: |r| r.flip },
];

/// Errors that are looked at: a power of ten or half of one.
const LEVELS: [f64; 11] = [1.0, 0.3, 0.1, 0.03, 0.01, 0.003, 0.001, 3e-4, 1e-4, 3e-5, 1e-5];

/// Replicas that a budget needs at least to be shown, unless fewer are asked for: a run that is stopped has fewer of the long ones.
const LEAST_REPLICAS: usize = 4;

/// One method.
struct Entry {
    name: String,
    /// Whether it is by Markov chains.
    has_chains: bool,
    /// By metric.
    curves: Vec<Curve>,
    budgets: Vec<f64>,
    wall: Vec<f64>,
    bias: Vec<Interval>,
    /// The picture that was kept, with what was measured of it.
    picture: Value,
}

/// All that was found.
pub struct Accuracy {
    entries: Vec<Entry>,
    about: Value,
    /// Of the budgets that are shown, the fewest.
    replicas: usize,
}

impl Accuracy {
    /// From the replicas; budgets that have too few, and longer ones, are left out.
    pub fn new(
        scene: &str,
        settings: &Settings,
        entrants: &[Entrant],
        (known, reference_file): (&Known, &Path),
        records: &[Record],
        options: &AccuracyOptions,
        threads: usize,
        stem: &Path,
    ) -> Result<Self, CliError> {
        let least = LEAST_REPLICAS.min(options.replicas.into());
        let entry = |entrant: &Entrant| {
            let mut points: Vec<Vec<&Record>> = Vec::new();
            for level in 0.. {
                let mut of_level: Vec<&Record> =
                    records.iter().filter(|r| r.name == entrant.name && r.level == level).collect();
                if of_level.len() < least {
                    break;
                }
                of_level.sort_unstable_by_key(|record| record.replica);
                points.push(of_level);
            }
            let curve = |of: fn(&Record) -> f64| Curve {
                name: entrant.name.clone(),
                points: points
                    .iter()
                    .map(|p| p.iter().map(|r| Sample { seconds: r.seconds, error: of(r) }).collect())
                    .collect(),
            };
            let mean = |p: &Vec<&Record>, of: fn(&Record) -> f64| p.iter().map(|r| of(r)).sum::<f64>() / p.len() as f64;
            Entry {
                name: entrant.name.clone(),
                has_chains: entrant.method.has_chains(),
                curves: METRICS.iter().map(|metric| curve(metric.of)).collect(),
                budgets: points.iter().map(|p| mean(p, |r| r.budget)).collect(),
                wall: points.iter().map(|p| mean(p, |r| r.wall_seconds)).collect(),
                bias: curve(|r| r.bias).errors(),
                picture: picture(&entrant.name, records, stem),
            }
        };
        let entries: Vec<Entry> = entrants.iter().map(entry).collect();
        let counts =
            entries.iter().filter_map(|entry| entry.curves.first()).flat_map(|curve| &curve.points).map(Vec::len);
        let Some(replicas) = counts.min() else {
            return Err(CliError::Said(format!(
                "stopped before {least} replicas of the first budget were done; the same command goes on from here"
            )));
        };
        let about = json!({
            "format": FORMAT,
            "version": env!("CARGO_PKG_VERSION"),
            "scene": scene,
            "size": settings.size,
            "config": config::to_ron(settings),
            "machine": { "processor": processor(), "system": std::env::consts::OS, "threads": threads },
            "time": "processor time of one replica on one thread, seeding included",
            "replicas": replicas,
            "reference": {
                "file": pictures::file_name(reference_file),
                "origin": known.origin,
                "relative_error_of_the_mean": known.relative_error,
                "rel_mse_of_its_own": known.noise.rel_mse,
            },
            "rel_mse_epsilon": RELATIVE_EPSILON,
            "trimmed_share": TRIMMED_SHARE,
        });
        Ok(Self { entries, about, replicas })
    }

    /// The curve by which methods are compared: relMSE.
    fn curves(&self) -> impl Iterator<Item = &Curve> + Clone {
        self.entries.iter().map(|entry| &entry.curves[0]).filter(|curve| !curve.points.is_empty())
    }

    /// The method with the least error at the last budget that all have.
    fn best(&self) -> Option<&Curve> {
        let common = self.curves().map(|curve| curve.points.len()).min()?;
        let at_last = |curve: &&Curve| curve.means()[common - 1].1 * curve.means()[common - 1].0;
        self.curves().min_by(|a, b| at_last(a).total_cmp(&at_last(b)))
    }

    /// (late, early, when) for every pair of which one overtakes the other.
    fn crossings(&self) -> Vec<(String, String, Interval)> {
        let pairs = self.curves().flat_map(|late| self.curves().map(move |early| (late, early)));
        pairs
            .filter(|(late, early)| late.name != early.name)
            .filter_map(|(late, early)| Some((late.name.clone(), early.name.clone(), overtakes(late, early)?)))
            .collect()
    }

    /// Errors that some method reaches.
    fn levels(&self) -> Vec<f64> {
        LEVELS.into_iter().filter(|e| self.curves().any(|curve| curve.time_to_reach(*e).is_some())).collect()
    }

    /// What to do, in plain words.
    pub fn advice(&self) -> String {
        let Some(best) = self.best() else { return String::new() };
        let others = self.curves().filter(|curve| curve.name != best.name);
        let rivals: Vec<(&str, Interval)> =
            others.filter_map(|curve| Some((&curve.name[..], relative_efficiency(best, curve)?))).collect();
        let clear = rivals.iter().all(|(_, ratio)| ratio.low > 1.0);
        let goal = self.levels().into_iter().filter(|e| best.time_to_reach(*e).is_some()).fold(f64::INFINITY, f64::min);
        let mut text = match best.time_to_reach(goal) {
            Some(time) => format!("Use {} here: it reaches a relMSE of {goal} in {}", best.name, seconds(&time)),
            None => format!("Use {} here: of those that took part it has the least error for its time", best.name),
        };
        let nearest = rivals.iter().min_by(|a, b| a.1.value.total_cmp(&b.1.value));
        if let Some((name, ratio)) = nearest {
            text.push_str(&if clear {
                format!(", and its time is worth {:.1} times that of {name}, the next", ratio.value)
            } else {
                format!(", but the difference to {name} is within what {} replicas can tell", self.replicas)
            });
        }
        text.push('.');
        let has_chains = |name: &str| self.entries.iter().any(|entry| entry.name == name && entry.has_chains);
        let mut chains = rivals.iter().filter(|(name, _)| has_chains(name)).peekable();
        if !has_chains(&best.name) && chains.peek().is_some() && chains.all(|(_, ratio)| ratio.low > 1.0) {
            text.push_str(" The scene is easy: independent samples do better than Markov chains.");
        }
        text
    }

    /// Tables for people.
    pub fn lines(&self) -> Vec<String> {
        let levels = self.levels();
        let best = self.best();
        let row = |entry: &Entry| {
            let curve = &entry.curves[0];
            let last = curve.errors().last().copied();
            let mut cells = vec![
                entry.name.clone(),
                last.map_or("-".into(), |e| format!("{:.2e} ({:.1e} to {:.1e})", e.value, e.low, e.high)),
                curve.slope().map_or("-".into(), |s| format!("{:.2} +- {:.2}", s.value, s.error)),
                best.and_then(|best| relative_efficiency(curve, best))
                    .map_or("-".into(), |e| format!("{:.2} ({:.2} to {:.2})", e.value, e.low, e.high)),
                entry
                    .bias
                    .last()
                    .map_or("-".into(), |b| format!("{:+.2} % +- {:.2} %", b.value * 100.0, b.error * 100.0)),
            ];
            cells.extend(levels.iter().map(|e| curve.time_to_reach(*e).map_or("-".into(), |t| seconds(&t))));
            cells
        };
        let mut head: Vec<String> = ["method", "relMSE at the last budget", "slope", "efficiency", "bias of the mean"]
            .map(String::from)
            .to_vec();
        head.extend(levels.iter().map(|e| format!("time to {e}")));
        let head: Vec<&str> = head.iter().map(String::as_str).collect();
        let rows: Vec<Vec<String>> = self.entries.iter().filter(|e| !e.budgets.is_empty()).map(row).collect();
        let mut lines = table::lines(&head, &rows);
        lines.push(String::new());
        lines.push(format!(
            "intervals of 95 % from {} replicas or more; times are processor seconds of one thread, seeding included; the slope should be -1",
            self.replicas
        ));
        for (late, early, when) in self.crossings() {
            lines.push(format!("{late} overtakes {early} at {:.2} s +- {:.2}", when.value, when.error));
        }
        lines.push(String::new());
        lines.push(self.advice());
        lines
    }

    fn json(&self) -> Value {
        let interval = |i: &Interval| json!({ "value": i.value, "low": i.low, "high": i.high, "error": i.error });
        let optional = |i: Option<Interval>| i.as_ref().map_or(Value::Null, interval);
        let best = self.best();
        let levels = self.levels();
        let entry = |entry: &Entry| {
            let points = (0..entry.budgets.len()).map(|i| {
                let mut point = json!({
                    "budget_seconds": entry.budgets[i],
                    "replicas": entry.curves[0].points[i].len(),
                    "seconds": entry.curves[0].means()[i].0,
                    "wall_seconds": entry.wall[i],
                    "bias": entry.bias.get(i).map_or(Value::Null, interval),
                });
                for (metric, curve) in METRICS.iter().zip(&entry.curves) {
                    point[metric.key] = curve.errors().get(i).map_or(Value::Null, interval);
                }
                point
            });
            let curve = &entry.curves[0];
            json!({
                "name": entry.name,
                "picture": entry.picture,
                "points": points.collect::<Vec<_>>(),
                "slope": optional(curve.slope()),
                "efficiency": optional(curve.efficiency()),
                "efficiency_relative_to_the_best": optional(best.and_then(|best| relative_efficiency(curve, best))),
                "time_to_reach": levels
                    .iter()
                    .map(|e| json!({ "rel_mse": e, "seconds": optional(curve.time_to_reach(*e)) }))
                    .collect::<Vec<_>>(),
            })
        };
        let crossings = self.crossings().into_iter();
        let mut all = self.about.clone();
        all["methods"] = self.entries.iter().map(entry).collect();
        all["crossings"] = crossings
            .map(|(late, early, when)| json!({ "late": late, "early": early, "seconds": interval(&when) }))
            .collect();
        all["best"] = best.map_or(Value::Null, |best| json!(best.name));
        all["advice"] = json!(self.advice());
        all
    }

    fn csv(&self) -> String {
        let mut csv = String::from("method,budget_seconds,replicas,seconds,wall_seconds");
        METRICS.iter().for_each(|m| csv.push_str(&format!(",{0},{0}_low,{0}_high", m.key)));
        csv.push_str(",bias,bias_error\n");
        for entry in &self.entries {
            for (i, budget) in entry.budgets.iter().enumerate() {
                let (name, replicas) = (&entry.name, entry.curves[0].points[i].len());
                csv.push_str(&format!("{name},{budget},{replicas},{},{}", entry.curves[0].means()[i].0, entry.wall[i]));
                for curve in &entry.curves {
                    let e = curve.errors()[i];
                    csv.push_str(&format!(",{},{},{}", e.value, e.low, e.high));
                }
                csv.push_str(&format!(",{},{}\n", entry.bias[i].value, entry.bias[i].error));
            }
        }
        csv
    }

    /// Writes accuracy.json, accuracy.csv and a plot for each metric; their names.
    pub fn write(&self, stem: &Path) -> Result<Vec<PathBuf>, CliError> {
        let json = serde_json::to_vec_pretty(&self.json())
            .map_err(|e| CliError::Said(format!("{} cannot be encoded: {e}", stem.display())))?;
        let mut files = vec![(with_ending(stem, ".json"), json), (with_ending(stem, ".csv"), self.csv().into_bytes())];
        for (i, metric) in METRICS.iter().enumerate() {
            let bands = self.entries.iter().filter(|entry| !entry.budgets.is_empty()).map(|entry| {
                let curve = &entry.curves[i];
                let times = curve.means().into_iter().map(|(t, _)| t);
                Band { name: entry.name.clone(), points: times.zip(curve.errors()).collect() }
            });
            let title = format!("{} against processor time", metric.name);
            let svg = plot::log_log(&title, "seconds", metric.name, &bands.collect::<Vec<_>>());
            files.push((with_ending(stem, &format!(".{}.svg", metric.key)), svg.into_bytes()));
        }
        for (path, bytes) in &files {
            write_whole(path, bytes)?;
        }
        Ok(files.into_iter().map(|(path, _)| path).collect())
    }
}

/// The picture of a method, with its own errors; null if none was kept or its file is gone.
fn picture(name: &str, records: &[Record], stem: &Path) -> Value {
    let kept = records.iter().filter(|r| r.picture && r.name == name).max_by_key(|r| r.level);
    let file = pictures::path(stem, name);
    let Some(record) = kept.filter(|_| file.exists()) else { return Value::Null };
    let mut picture = json!({
        "file": pictures::file_name(&file),
        "replica": record.replica,
        "budget_seconds": record.budget,
        "seconds": record.seconds,
        "bias": record.bias,
    });
    for metric in METRICS {
        picture[metric.key] = json!((metric.of)(record));
    }
    picture
}

/// A time with its interval.
fn seconds(time: &Interval) -> String {
    format!("{:.2} s ({:.2} to {:.2})", time.value, time.low, time.high)
}

/// What the system calls its processor; empty where it does not tell.
fn processor() -> String {
    let cpuinfo = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpuinfo.lines().find(|line| line.starts_with("model name"));
    model.and_then(|line| line.split_once(':')).map_or_else(String::new, |(_, name)| name.trim().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A method whose error is `factor` over time, times noise, in four replicas of four budgets.
    fn entry(name: &str, has_chains: bool, factor: f64, noise: f64) -> Entry {
        let replica = |seconds: f64, i: i32| {
            let error = factor / seconds * (1.0 + noise * (f64::from(i) - 1.5));
            Sample { seconds, error }
        };
        let points: Vec<Vec<Sample>> =
            [1.0, 2.0, 4.0, 8.0].iter().map(|t| (0..4).map(|i| replica(*t, i)).collect()).collect();
        let curve = Curve { name: name.into(), points };
        Entry {
            name: name.into(),
            has_chains,
            bias: curve.errors(),
            budgets: curve.means().iter().map(|(t, _)| *t).collect(),
            wall: Vec::new(),
            curves: vec![curve],
            picture: Value::Null,
        }
    }

    fn advice(entries: Vec<Entry>) -> String {
        Accuracy { entries, about: Value::Null, replicas: 4 }.advice()
    }

    #[test]
    fn a_scene_is_called_easy_only_if_chains_took_part_and_are_clearly_worse() {
        let easy = "The scene is easy";
        let path = |noise| entry("path", false, 0.02, noise);
        let clear = advice(vec![path(0.01), entry("mine", true, 0.04, 0.01)]);
        assert!(
            clear.starts_with("Use path here") && clear.contains("2.0 times that of mine, the next. The"),
            "{clear}"
        );
        assert!(clear.contains(easy), "{clear}");
        let vague = advice(vec![path(0.6), entry("mine", true, 0.024, 0.6)]);
        assert!(vague.contains("but the difference to mine is within what 4 replicas can tell"), "{vague}");
        let without = advice(vec![path(0.01), entry("bidirectional", false, 0.04, 0.01)]);
        let hard = advice(vec![path(0.01), entry("mine", true, 0.01, 0.01)]);
        assert!(hard.starts_with("Use mine here"), "{hard}");
        for other in [vague, without, hard] {
            assert!(!other.contains(easy), "{other}");
        }
    }
}
