//! `ergodic render`.

use ergodic_assess::Exposure;
use ergodic_render::{Settings, render};

use crate::error::CliError;
use crate::options::RenderOptions;
use crate::output::Outputs;
use crate::progress::Progress;
use crate::{report, source, terminal};

/// Renders and writes the files; true if it was interrupted.
pub fn run(options: &RenderOptions) -> Result<bool, CliError> {
    let settings = settings(options)?;
    let say = |line: &str| {
        if !options.quiet {
            eprintln!("{line}");
        }
    };
    let source = source::open(&settings, &say)?;
    let outputs = Outputs::new(&options.output.clone().unwrap_or_else(|| source::stem(&settings)))?;

    let unwatched = |e: std::io::Error| CliError::Said(format!("cannot watch for interruptions: {e}"));
    let progress = Progress::new(options.quiet).map_err(unwatched)?;
    let rendering = render(&source.scene, &settings, &progress);
    progress.finish();
    let rendering = rendering?;
    let exposure = options.exposure.map_or(Exposure::Automatic, Exposure::Stops);
    outputs.write(&source, &settings, &rendering, progress.interrupted(), exposure)?;
    if !options.quiet {
        let paths = outputs.paths().map(|p| p.display().to_string());
        let wrote = format!("wrote {}", paths.join(", "));
        terminal::print_lines(report::summary(&rendering).into_iter().chain([String::new(), wrote]));
    }
    if progress.interrupted() {
        say("stopped before the budget was used up; the files hold the picture so far");
    }
    Ok(progress.interrupted())
}

/// The settings of the source, with the options of `render` alone.
fn settings(options: &RenderOptions) -> Result<Settings, CliError> {
    let mut settings = source::settings(&options.source)?;
    if let Some(method) = options.method {
        settings.method = method;
    }
    if let Some(budget) = options.time.or(options.samples_per_pixel) {
        settings.budget = budget;
    }
    settings.validate().map_err(CliError::Said)?;
    Ok(settings)
}
