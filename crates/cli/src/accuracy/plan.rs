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

impl Plan {
    /// As many budgets, each twice the one before, as fit into the seconds left; what the journal has is not done again.
    pub fn new(
        entrants: &[Entrant],
        options: &AccuracyOptions,
        threads: usize,
        left: f64,
        journal: &Journal,
    ) -> Result<Self, CliError> {
        let first = options.first;
        let (mut tasks, mut all, mut planned, mut levels) = (Vec::new(), 0, 0.0, 0);
        for level in 0.. {
            let seconds = first * 2f64.powi(level);
            let level = level as usize;
            let mut of_level = Vec::new();
            for replica in 0..usize::from(options.replicas) {
                // Each replica begins with another method.
                for turn in 0..entrants.len() {
                    let entrant = (turn + replica) % entrants.len();
                    of_level.push(Task { entrant, level, seconds, replica });
                }
            }
            let missing: Vec<Task> = of_level
                .iter()
                .copied()
                .filter(|task| !journal.has(&entrants[task.entrant].name, task.level, task.replica))
                .collect();
            let cost = missing.len() as f64 * seconds / threads.min(of_level.len()) as f64;
            if planned + cost > left {
                break;
            }
            planned += cost;
            all += of_level.len();
            tasks.extend(missing);
            levels += 1;
        }
        if levels < LEAST_LEVELS {
            let each =
                first * f64::from((1 << LEAST_LEVELS) - 1) * (entrants.len() * usize::from(options.replicas)) as f64;
            return Err(CliError::Said(format!(
                "the time limit leaves {left:.1} s, but {LEAST_LEVELS} budgets from {first} s on take {:.1} s for {} methods and {} \
                 replicas on {threads} threads; raise --time-limit, or lower --replicas or --first",
                each / threads as f64,
                entrants.len(),
                options.replicas,
            )));
        }
        Ok(Self { tasks, all })
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
