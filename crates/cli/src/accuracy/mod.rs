//! `ergodic accuracy`: error against time for several methods on one scene.
//!
//! Every point is made by independent replicas with a budget of their own, so that start-up counts in full at every time. Methods
//! take turns, a replica each, and so do budgets, a round of them each, so that a machine that gets slower does so for all. `plan` says
//! what runs when, `journal` keeps what is done, so that a run can be stopped and resumed, `pictures` what it looks like, `result` turns
//! it into tables and files, and `plot` draws.

mod journal;
mod pictures;
mod plan;
mod plot;
mod reference;
mod result;

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use ergodic_assess::compare;
use ergodic_render::{Budget, Observer, Settings, Stage, render};

use crate::error::CliError;
use crate::options::AccuracyOptions;
use crate::progress::Progress;
use crate::{output, source, terminal};
pub use result::FORMAT;

use journal::{Journal, Record};
use plan::{Plan, Task};
use reference::Known;

/// Passes on the wish to stop; how far a single replica is, is not shown.
struct OneOfMany<'a>(&'a Progress);

impl Observer for OneOfMany<'_> {
    fn progress(&self, _stage: Stage, _done: f64) {}

    fn should_stop(&self) -> bool {
        self.0.should_stop()
    }
}

/// Measures and writes the files; true if it was interrupted.
pub fn run(options: &AccuracyOptions) -> Result<bool, CliError> {
    let settings = source::settings(&options.source)?;
    let say = |line: &str| {
        if !options.quiet {
            eprintln!("{line}");
        }
    };
    let source::Source { scene, name, .. } = source::open(&settings, &say)?;
    let stem = options.output.clone().unwrap_or_else(|| {
        let mut stem = source::stem(&settings).into_os_string();
        stem.push(".accuracy");
        PathBuf::from(stem)
    });
    let threads = settings.worker_threads();
    let entrants = plan::entrants(options)?;
    let start = Instant::now();
    let unwatched = |e: std::io::Error| CliError::Said(format!("cannot watch for interruptions: {e}"));
    let progress = Progress::new(options.quiet).map_err(unwatched)?;

    let limit = options.time_limit;
    let known = Known::find(options, &scene, &settings, &stem, limit, &progress)?;
    say(&known.line());
    let left = limit - start.elapsed().as_secs_f64();
    let reference_file = pictures::reference(&stem, options.reference.as_deref(), &known)?;
    let header = journal::header(&name, &settings, &entrants, options, &known);
    let journal = Journal::open(&with_ending(&stem, ".journal"), &header)?;
    let plan = Plan::new(&entrants, options, threads, left, &journal)?;
    if !journal.records().is_empty() {
        say(&format!("goes on from {} replicas that were measured before", journal.records().len()));
    }

    let journal = Mutex::new(journal);
    measure(
        &plan,
        &entrants,
        (&scene, &settings),
        &known,
        (&journal, &progress),
        start + Duration::from_secs_f64(limit),
        threads,
        options,
        &stem,
    )?;
    progress.finish();
    let journal = journal.into_inner().map_err(|_| CliError::Said("a worker thread failed".into()))?;
    let result = result::Accuracy::new(
        &name,
        &settings,
        &entrants,
        (&known, &reference_file),
        journal.records(),
        options,
        threads,
        &stem,
    )?;
    let files = result.write(&stem)?;
    if !options.quiet {
        let wrote = format!("wrote {}", files.iter().map(|p| p.display().to_string()).collect::<Vec<_>>().join(", "));
        terminal::print_lines(result.lines().into_iter().chain([String::new(), wrote]));
    }
    if progress.interrupted() {
        say("stopped before all was measured; the same command goes on from here");
    }
    Ok(progress.interrupted())
}

/// The stem with an ending.
fn with_ending(stem: &Path, ending: &str) -> PathBuf {
    let mut name = stem.as_os_str().to_os_string();
    name.push(ending);
    PathBuf::from(name)
}

/// Works through the plan until its end, the time limit, the wish to stop, or until every method is good enough.
fn measure(
    plan: &Plan,
    entrants: &[plan::Entrant],
    (scene, settings): (&ergodic_pathspace::Scene, &Settings),
    known: &Known,
    (journal, progress): (&Mutex<Journal>, &Progress),
    end: Instant,
    threads: usize,
    options: &AccuracyOptions,
    stem: &Path,
) -> Result<(), CliError> {
    let next = AtomicUsize::new(0);
    let one = |task: &Task| -> Result<(), CliError> {
        let entrant = &entrants[task.entrant];
        let mut settings = Settings {
            method: entrant.method,
            seed: settings
                .seed
                .wrapping_add(1)
                .wrapping_add((task.level as u64) << 32)
                .wrapping_add(task.replica as u64),
            threads: 1,
            budget: Budget::Seconds(task.seconds),
            ..settings.clone()
        };
        if let Some(mutations) = &entrant.mutations {
            settings.mlt.mutations.clone_from(mutations);
        }
        let rendering = render(scene, &settings, &OneOfMany(progress))?;
        if progress.interrupted() {
            return Ok(());
        }
        let image = output::image(&rendering.picture);
        let c = compare(&image, &known.image).map_err(CliError::Said)?;
        let mut record = Record {
            name: entrant.name.clone(),
            level: task.level,
            replica: task.replica,
            budget: task.seconds,
            seconds: if rendering.processor_seconds > 0.0 { rendering.processor_seconds } else { rendering.seconds },
            wall_seconds: rendering.seconds,
            rel_mse: c.rel_mse - known.noise.rel_mse,
            trimmed_rel_mse: c.trimmed_rel_mse - known.noise.trimmed_rel_mse,
            mse: c.mse - known.noise.mse,
            flip: c.flip,
            bias: c.total_mean_ratio - 1.0,
            picture: false,
        };
        let mut journal = journal.lock().map_err(|_| CliError::Said("a worker thread failed".into()))?;
        if task.replica == pictures::KEPT && !journal.has_later_picture(&record.name, task.level) {
            // Before the record: a run that is stopped in between renders this replica again.
            pictures::keep(stem, &image, &record)?;
            record.picture = true;
        }
        journal.add(record)?;
        progress.progress(Stage::Rendering, journal.records().len() as f64 / plan.all() as f64);
        Ok(())
    };
    let good_enough = |entrant: usize, level: usize| {
        let Some(target) = options.target_error else { return false };
        let Ok(journal) = journal.lock() else { return false };
        journal
            .mean_error(&entrants[entrant].name, level.wrapping_sub(1), options.replicas.into())
            .is_some_and(|e| e <= target)
    };
    let work = || -> Result<(), CliError> {
        loop {
            let Some(task) = plan.tasks().get(next.fetch_add(1, Ordering::Relaxed)) else { return Ok(()) };
            if progress.interrupted() || Instant::now() >= end {
                return Ok(());
            }
            if !good_enough(task.entrant, task.level) {
                one(task)?;
            }
        }
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        workers.into_iter().try_for_each(|w| w.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    })
}
