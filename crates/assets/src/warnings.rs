//! What a file holds that the picture will lack, and what else is worth knowing: each thing is named once.

use std::collections::BTreeMap;

/// From subject to first place, what is said of it and count.
type Subjects = BTreeMap<String, (String, String, usize)>;

/// Collects warnings and notes; a subject that comes up often is reported once, with its first place and how often it came
/// up.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    lacking: Subjects,
    noted: Subjects,
}

fn add(subjects: &mut Subjects, subject: String, place: String, said: &str) {
    let entry = subjects.entry(subject).or_insert_with(|| (place, said.into(), 0));
    entry.2 += 1;
}

impl Warnings {
    /// Warns that `subject`, met at `place`, has a `consequence` for the picture.
    pub(crate) fn note(&mut self, subject: impl Into<String>, place: impl Into<String>, consequence: &str) {
        add(&mut self.lacking, subject.into(), place.into(), consequence);
    }

    /// Notes how `subject`, met at `place`, is shown, where nothing is lacking.
    pub(crate) fn mention(&mut self, subject: impl Into<String>, place: impl Into<String>, how: &str) {
        add(&mut self.noted, subject.into(), place.into(), how);
    }

    /// The sentences of the warnings and of the notes, each in alphabetical order.
    pub(crate) fn into_sentences(self) -> (Vec<String>, Vec<String>) {
        (sentences(self.lacking), sentences(self.noted))
    }
}

fn sentences(subjects: Subjects) -> Vec<String> {
    let sentence = |(subject, (place, said, count)): (String, (String, String, usize))| {
        let place = match (place.is_empty(), count) {
            (true, _) => String::new(),
            (false, 1) => format!(" ({place})"),
            (false, more) => format!(" ({place} and {} more)", more - 1),
        };
        format!("{subject}{place}: {said}")
    };
    subjects.into_iter().map(sentence).collect()
}
