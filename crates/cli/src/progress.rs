//! The progress bar, and Ctrl-C.

use std::sync::Arc;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use ergodic_render::{Observer, Stage};
use indicatif::{ProgressBar, ProgressStyle};
use signal_hook::consts::{SIGINT, SIGTERM};

/// Steps of the bar.
const STEPS: u64 = 1000;

/// Shows how far a render is, and passes on the wish to stop.
pub struct Progress {
    bar: ProgressBar,
    stop: Arc<AtomicBool>,
    stage: Mutex<Option<(Stage, Instant)>>,
}

fn name(stage: Stage) -> &'static str {
    match stage {
        Stage::Seeding => "seeding",
        Stage::Direct => "direct light",
        Stage::Rendering => "rendering",
    }
}

impl Progress {
    /// A bar on the terminal, unless `quiet`. From now on the first interruption is a wish to stop with what there is, and
    /// the second ends the program at once.
    pub fn new(quiet: bool) -> Result<Self, std::io::Error> {
        let stop = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // In this order: the first time the flag is not yet set.
            signal_hook::flag::register_conditional_shutdown(signal, 130, Arc::clone(&stop))?;
            signal_hook::flag::register(signal, Arc::clone(&stop))?;
        }
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(STEPS) };
        let style = ProgressStyle::with_template("{msg:>12} [{bar:40}] {percent:>3} %  {prefix}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
        Ok(Self { bar, stop, stage: Mutex::new(None) })
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// Whether the user asked to stop.
    pub fn interrupted(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// A time as people say it.
pub fn human_time(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        0..60 if seconds < 9.95 => format!("{seconds:.1} s"),
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
    }
}

impl Observer for Progress {
    fn progress(&self, stage: Stage, done: f64) {
        let Ok(mut current) = self.stage.lock() else { return };
        let begun = match *current {
            Some((same, begun)) if same == stage => begun,
            _ => {
                let now = Instant::now();
                *current = Some((stage, now));
                self.bar.set_message(name(stage));
                now
            }
        };
        self.bar.set_position((done * STEPS as f64) as u64);
        let elapsed = begun.elapsed().as_secs_f64();
        if done > 0.0 && elapsed > 0.5 {
            self.bar.set_prefix(format!("{} left", human_time(elapsed / done * (1.0 - done))));
        }
    }

    fn should_stop(&self) -> bool {
        self.interrupted()
    }
}

#[cfg(test)]
mod tests {
    use super::human_time;

    #[test]
    fn times_are_readable() {
        let times = [0.04, 9.9, 59.0, 61.0, 7300.0].map(human_time);
        assert_eq!(times, ["0.0 s", "9.9 s", "59 s", "1 min 01 s", "2 h 01 min"]);
    }
}
