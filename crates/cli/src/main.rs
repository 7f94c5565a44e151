//! The `ergodic` command: from a scene and settings to a picture with its statistics.

mod accuracy;
mod census;
mod compare;
mod config;
mod environment;
mod error;
mod inspect;
mod options;
mod output;
mod override_path;
mod page;
mod progress;
mod render;
mod report;
mod source;
mod stats;
mod table;
mod terminal;
mod verify;

use std::process::ExitCode;

use clap::Parser;

use options::{Command, Options};

/// What the shell is told after an error.
const FAILED: u8 = 2;
/// What the shell is told when a test against a reference fails.
const DISAGREES: u8 = 1;
/// What the shell is told after an interruption that kept the picture so far.
const INTERRUPTED: u8 = 130;

fn main() -> ExitCode {
    let outcome = match Options::parse().command {
        Command::Render(options) => render::run(&options).map(|interrupted| if interrupted { INTERRUPTED } else { 0 }),
        Command::Config => {
            terminal::print_lines(config::TEMPLATE.lines());
            Ok(0)
        }
        Command::Inspect(options) => inspect::run(&options).map(|()| 0),
        Command::Report(options) => page::run(&options).map(|()| 0),
        Command::Compare(options) => compare::run(&options).map(|()| 0),
        Command::Accuracy(options) => {
            accuracy::run(&options).map(|interrupted| if interrupted { INTERRUPTED } else { 0 })
        }
        Command::Stats(options) => stats::run(&options).map(|()| 0),
        Command::Verify(options) => verify::run(&options).map(|holds| if holds { 0 } else { DISAGREES }),
    };
    match outcome {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            eprint!("{}", error.report());
            ExitCode::from(FAILED)
        }
    }
}
