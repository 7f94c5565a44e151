//! `cargo xtask nightly`: every test at its large size, and every method against every reference with the full budget.

use std::process::Command;

fn cargo(arguments: &[&str]) -> Result<(), String> {
    eprintln!("cargo {}", arguments.join(" "));
    let status =
        Command::new(env!("CARGO")).args(arguments).current_dir(crate::root()).env("ERGODIC_TESTS", "nightly").status();
    match status {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("cargo {} failed: {status}", arguments.join(" "))),
        Err(e) => Err(format!("cannot run cargo: {e}")),
    }
}

/// Runs the tests, then the verification.
///
/// # Errors
///
/// Whatever fails first.
pub fn run() -> Result<(), String> {
    cargo(&["test", "--profile", "tests", "--workspace", "--no-fail-fast"])?;
    cargo(&["run", "--release", "--package", "ergodic", "--", "verify", "--budget", "full"])
}
