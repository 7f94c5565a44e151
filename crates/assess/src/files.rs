//! Files that are there whole or not at all.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why a picture's file could not be read or written.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{file}: {problem}. {mend}")]
pub struct FileError {
    /// The file.
    pub file: String,
    /// What is wrong.
    pub problem: String,
    /// What to do about it.
    pub mend: String,
}

impl FileError {
    pub(crate) fn new(path: &Path, problem: impl Into<String>, mend: impl Into<String>) -> Self {
        Self { file: path.display().to_string(), problem: problem.into(), mend: mend.into() }
    }
}

/// Where the bytes go until they are complete.
fn partial(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}.part", std::process::id()));
    path.with_file_name(name)
}

fn unwritable(path: &Path, error: &std::io::Error) -> FileError {
    FileError::new(
        path,
        format!("cannot be written: {error}"),
        "Name a file in a folder that exists and can be written",
    )
}

/// Writes a file so that it appears only once it is complete; what was there before stays until then.
///
/// # Errors
///
/// A folder that does not exist or cannot be written, or a full disk. Nothing is left behind.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let part = partial(path);
    let written = fs::File::create(&part).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&part, path)
    });
    written.map_err(|error| {
        // The error of the first failure is what the user needs; that of clearing up after it is not.
        let _ = fs::remove_file(&part);
        unwritable(path, &error)
    })
}

/// Finds out whether [`write_whole`] could write there, before hours of work are spent on what it should write.
///
/// # Errors
///
/// Like [`write_whole`]. Nothing is left behind.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    if path.is_dir() {
        return Err(FileError::new(path, "is a folder", "Name a file"));
    }
    let part = partial(path);
    fs::File::create(&part).and_then(|_| fs::remove_file(&part)).map_err(|error| unwritable(path, &error))
}
