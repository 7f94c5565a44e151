//! What can be wrong with a scene file.

use thiserror::Error;

/// What kind of trouble a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Trouble {
    /// The file, or one it refers to, could not be read.
    Unreadable,
    /// The file breaks the specification where it matters for the picture.
    Malformed,
    /// The file requires something that is not supported.
    Unsupported,
    /// The file asks for more memory than is allowed.
    TooLarge,
}

/// Why a scene could not be loaded: which file, where in it, what, and how to mend it.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{file}: {}{problem}. {mend}", if place.is_empty() { String::new() } else { format!("{place}: ") })]
pub struct AssetError {
    /// What kind of trouble it is.
    pub trouble: Trouble,
    /// The file.
    pub file: String,
    /// Where in it, as a path through the JSON such as `meshes[2].primitives[0].indices`; may be empty.
    pub place: String,
    /// What is wrong.
    pub problem: String,
    /// What to do about it.
    pub mend: String,
}

/// Trouble at a place, before the file's name is known.
#[derive(Clone, Debug)]
pub(crate) struct Flaw {
    pub trouble: Trouble,
    pub place: String,
    pub problem: String,
    pub mend: String,
}

impl Flaw {
    pub(crate) fn new(
        trouble: Trouble,
        place: impl Into<String>,
        problem: impl Into<String>,
        mend: impl Into<String>,
    ) -> Self {
        Self { trouble, place: place.into(), problem: problem.into(), mend: mend.into() }
    }

    /// A violation of the specification, mended by exporting again.
    pub(crate) fn malformed(place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::new(Trouble::Malformed, place, problem, "Export the file again, or correct it there")
    }

    /// The flaw of a reference that leads nowhere.
    pub(crate) fn dangling(place: impl Into<String>, what: &str, index: usize, count: usize) -> Self {
        Self::malformed(place, format!("refers to {what}[{index}], but the file has {count} {what}"))
    }

    pub(crate) fn in_file(self, file: &str) -> AssetError {
        let Self { trouble, place, problem, mend } = self;
        AssetError { trouble, file: file.into(), place, problem, mend }
    }
}
