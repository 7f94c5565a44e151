//! Who takes part, and what runs when.

use std::path::Path;

use ergodic_mutations::AnyMutation;
use ergodic_render::Method;

use super::journal::Journal;
use crate::config;
use crate::error::CliError;
use crate::options::AccuracyOptions;

/// A method, or a mix of mutations, that takes part.
#[derive(Clone, Debug)]
pub struct Entrant {
    /// Its name in tables, files and plots.
    pub name: String,
    pub method: Method,
    /// A mixture other than that of the settings.
    pub mutations: Option<Vec<(f64, AnyMutation)>>,
}

/// Those that the options ask for.
pub fn entrants(options: &AccuracyOptions) -> Result<Vec<Entrant>, CliError> {
    let methods =
        if options.methods.is_empty() { Method::ALL.map(|(m, _)| m).to_vec() } else { options.methods.clone() };
    let plain = |method: Method| Entrant { name: method.name().into(), method, mutations: None };
    let mut entrants: Vec<Entrant> = methods.into_iter().map(plain).collect();
    for mix in &options.mixes {
        let (name, file) = mix.split_once('=').ok_or_else(|| {
            CliError::Said(format!(
                "--mix {mix} has no file; give NAME=FILE.ron, where the file is a config with mlt.mutations"
            ))
        })?;
        let mutations = config::load(Path::new(file))?.mlt.mutations;
        entrants.push(Entrant { name: name.into(), method: Method::Mlt, mutations: Some(mutations) });
    }
    for (i, entrant) in entrants.iter().enumerate() {
        if entrants[..i].iter().any(|other| other.name == entrant.name) {
            return Err(CliError::Said(format!("{} takes part twice; give every mix a name of its own", entrant.name)));
        }
    }
    Ok(entrants)
}

/// One replica to be rendered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Task {
    pub entrant: usize,
    /// Which of the budgets.
    pub level: usize,
    pub seconds: f64,
    pub replica: usize,
}

/// What is to be done, in order.
#[derive(Clone, Debug)]
pub struct Plan {
    tasks: Vec<Task>,
    all: usize,
}

/// Budgets that there must be, for a slope to have a meaning.
const LEAST_LEVELS: usize = 3;

/// The budgets before the last that have as many replicas as are asked for, and no more.
const ONCE: usize = 3;

/// So many times as many replicas a budget has at most.
const MOST_TIMES: usize = 16;

/// Replicas at one of `levels` budgets. What a method meets rarely and brightly may decide its error, and few replicas of a short budget
/// never meet it: they would tell a small error with a small interval. So each shorter budget has twice as many, which together take no
/// longer than those of the fourth to last.
fn replicas_at(level: usize, levels: usize, asked: usize) -> usize {
    let shorter = (levels - 1 - level).saturating_sub(ONCE) as u32;
    asked * MOST_TIMES.min(1 << shorter.min(MOST_TIMES.ilog2()))
}

/// What tasks are in the order of: the round, and how late in it one of the `replicas` at one of `levels` budgets has its turn.
fn turn(replica: usize, replicas: usize, level: usize, levels: usize, rounds: usize) -> (usize, usize) {
    let round = replica * rounds / replicas;
    (round, if round.is_multiple_of(2) { level } else { levels - 1 - level })
}

impl Plan {
    /// As many budgets, each twice the one before, as fit into the seconds left; what the journal has is not done again.
    ///
    /// A round has its share of the replicas of every budget, and every other round begins with the longest: a machine that becomes
    /// slower from hour to hour does so for all budgets alike, and does not bend the slope. The first round tells about short budgets
    /// soon.
    ///
    /// If methods are to end at an error, there is one round: whether a longer budget is needed is known after the shorter one.
    pub fn new(
        entrants: &[Entrant],
        options: &AccuracyOptions,
        threads: usize,
        left: f64,
        journal: &Journal,
    ) -> Result<Self, CliError> {
        let (first, asked) = (options.first, usize::from(options.replicas));
        let rounds = if options.target_error.is_some() { 1 } else { asked };
        let of_levels = |levels: usize| {
            let (mut tasks, mut all, mut cost) = (Vec::new(), 0, 0.0);
            for level in 0..levels {
                let seconds = first * 2f64.powi(level as i32);
                let replicas = replicas_at(level, levels, asked);
                let count = replicas * entrants.len();
                let before = tasks.len();
                // Each replica begins with another method.
                let each = (0..replicas).flat_map(|replica| {
                    (0..entrants.len()).map(move |place| Task {
                        entrant: (place + replica) % entrants.len(),
                        level,
                        seconds,
                        replica,
                    })
                });
                tasks.extend(each.filter(|t| !journal.has(&entrants[t.entrant].name, t.level, t.replica)));
                cost += (tasks.len() - before) as f64 * seconds / threads.min(count) as f64;
                all += count;
            }
            // Stable, so that replicas stay in order within a budget.
            tasks.sort_by_key(|task| {
                turn(task.replica, replicas_at(task.level, levels, asked), task.level, levels, rounds)
            });
            (Self { tasks, all }, cost)
        };
        let mut fits = None;
        let mut levels = 0;
        loop {
            let (plan, cost) = of_levels(levels + 1);
            if cost > left {
                break;
            }
            fits = Some(plan);
            levels += 1;
        }
        let Some(plan) = fits.filter(|_| levels >= LEAST_LEVELS) else {
            let each =
                first * f64::from((1 << LEAST_LEVELS) - 1) * (entrants.len() * usize::from(options.replicas)) as f64;
            return Err(CliError::Said(format!(
                "the time limit leaves {left:.1} s, but {LEAST_LEVELS} budgets from {first} s on take {:.1} s for {} methods and {} \
                 replicas on {threads} threads; raise --time-limit, or lower --replicas or --first",
                each / threads as f64,
                entrants.len(),
                options.replicas,
            )));
        };
        Ok(plan)
    }

    /// In the order in which they are done.
    pub fn tasks(&self) -> &[Task] {
        &self.tasks
    }

    /// Number of replicas once all is done.
    pub fn all(&self) -> usize {
        self.all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_budgets_have_more_replicas_for_no_more_time() {
        let counts: Vec<usize> = (0..9).map(|level| replicas_at(level, 9, 4)).collect();
        assert_eq!(counts, [64, 64, 32, 16, 8, 4, 4, 4, 4]);
        for (level, count) in counts.iter().enumerate().skip(1).take(4) {
            assert_eq!(count << level, counts[5] << 5, "a level takes the time of the fourth to last");
        }
        assert_eq!([0, 1, 2].map(|level| replicas_at(level, 3, 2)), [2; 3]);
        assert_eq!(replicas_at(0, 200, 3), 48);
    }

    #[test]
    fn budgets_take_turns_and_every_other_round_is_backward() {
        let (levels, asked, rounds) = (6, 4, 4);
        let mut turns = Vec::new();
        for level in 0..levels {
            let replicas = replicas_at(level, levels, asked);
            let mut counts = vec![0; rounds];
            for replica in 0..replicas {
                let (round, late) = turn(replica, replicas, level, levels, rounds);
                counts[round] += 1;
                turns.push((round, late, level));
            }
            assert!(counts.iter().all(|count| count * rounds == replicas), "{level}: {counts:?}");
        }
        turns.sort_unstable();
        turns.dedup();
        let order: Vec<usize> = turns.into_iter().map(|(_, _, level)| level).collect();
        assert_eq!(order[..12], [0, 1, 2, 3, 4, 5, 5, 4, 3, 2, 1, 0]);
        assert_eq!(order.len(), levels * rounds);
        assert_eq!(turn(5, 6, 2, 3, 1), (0, 2), "in one round, budgets in order");
    }
}
