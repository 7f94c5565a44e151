//! The pictures that are kept beside the figures: of every method one replica, and the reference.

use std::path::{Path, PathBuf};

use ergodic_assess::{Attribute, Image, write_exr};

use super::journal::Record;
use super::reference::Known;
use super::with_ending;
use crate::error::CliError;

/// The replica whose picture is kept, that of the longest budget done. One replica, not a mean of them, has the error that the
/// curves tell of.
pub const KEPT: usize = 0;

/// Where the picture of a method goes. Names of mixes are anything, so what may have a meaning in a path is written as its code.
pub fn path(stem: &Path, name: &str) -> PathBuf {
    let plain = |c: char| c.is_alphanumeric() || "-_+ ".contains(c);
    let escape = |c: char| if plain(c) { c.to_string() } else { format!("%{:02x}", u32::from(c)) };
    with_ending(stem, &format!(".{}.picture.exr", name.chars().map(escape).collect::<String>()))
}

/// Keeps the picture of a replica in place of one with a shorter budget.
pub fn keep(stem: &Path, image: &Image, record: &Record) -> Result<(), CliError> {
    let attributes = [
        ("ergodic.version", Attribute::Text(env!("CARGO_PKG_VERSION").into())),
        ("ergodic.method", Attribute::Text(record.name.clone())),
        ("ergodic.replica", Attribute::Number(record.replica as f64)),
        ("ergodic.budget_seconds", Attribute::Number(record.budget)),
        ("ergodic.seconds", Attribute::Number(record.seconds)),
    ];
    Ok(write_exr(&path(stem, &record.name), image, None, &[], &attributes)?)
}

/// The reference beside the other files: the one that was made, or a copy of the one that was given.
pub fn reference(stem: &Path, given: Option<&Path>, known: &Known) -> Result<PathBuf, CliError> {
    let Some(given) = given else { return Ok(with_ending(stem, ".reference.exr")) };
    let copy = with_ending(stem, ".given.exr");
    let origin = ("ergodic.origin", Attribute::Text(given.display().to_string()));
    write_exr(&copy, &known.image, None, &[], &[origin])?;
    Ok(copy)
}

/// The name of a file, for those that lie beside it.
pub fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_mixes_stay_in_the_folder_and_apart() {
        let of = |name: &str| path(Path::new("out/a"), name).display().to_string();
        assert_eq!(of("mlt"), "out/a.mlt.picture.exr");
        assert_eq!(of("../b%"), "out/a.%2e%2e%2fb%25.picture.exr");
        assert_ne!(of("a/b"), of("a%2fb"));
    }
}
