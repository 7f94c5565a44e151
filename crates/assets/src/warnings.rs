//! What a file holds that the picture will lack: each thing is named once.

use std::collections::BTreeMap;

/// Collects warnings; a subject that comes up often is reported once, with its first place and how often it came up.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    /// From subject to first place, consequence and count.
    subjects: BTreeMap<String, (String, String, usize)>,
}

impl Warnings {
    /// Notes that `subject`, met at `place`, has a `consequence` for the picture.
    pub(crate) fn note(&mut self, subject: impl Into<String>, place: impl Into<String>, consequence: &str) {
        let entry = self.subjects.entry(subject.into()).or_insert_with(|| (place.into(), consequence.into(), 0));
        entry.2 += 1;
    }

    /// The sentences, in alphabetical order.
    pub(crate) fn into_sentences(self) -> Vec<String> {
        let sentence = |(subject, (place, consequence, count)): (String, (String, String, usize))| {
            let place = match (place.is_empty(), count) {
                (true, _) => String::new(),
                (false, 1) => format!(" ({place})"),
                (false, more) => format!(" ({place} and {} more)", more - 1),
            };
            format!("{subject}{place}: {consequence}")
        };
        self.subjects.into_iter().map(sentence).collect()
    }
}
