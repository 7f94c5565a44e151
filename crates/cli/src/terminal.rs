//! Printing that does not mind when nobody listens any more, as in `ergodic config | head`.

use std::io::Write;

/// Prints lines to standard output. When the reader has gone away, the rest is dropped.
pub fn print_lines<I>(lines: I)
where
    I: IntoIterator,
    I::Item: AsRef<str>,
{
    let mut out = std::io::stdout().lock();
    for line in lines {
        if writeln!(out, "{}", line.as_ref()).is_err() {
            return;
        }
    }
    // Nothing is left to be done about an error here.
    let _ = out.flush();
}
