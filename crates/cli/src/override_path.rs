//! Finds the value of a setting in RON text by its path, such as `mlt.mutations.1.0`.
//!
//! The text is what `config::to_ron` wrote: complete, so that every setting is there to be found, and without comments.

use std::ops::Range;

/// A part of a path that leads nowhere, and the parts that would.
#[derive(Debug, PartialEq, Eq)]
pub struct PathError {
    /// The part.
    pub part: String,
    /// What there is instead.
    pub known: Vec<String>,
}

/// Where the value lies.
pub fn value_span(text: &str, path: &str) -> Result<Range<usize>, PathError> {
    let mut span = trim(text, 0..text.len());
    for part in path.split('.') {
        let members = members(text, span);
        let found = members.iter().find(|(name, _)| name == part).map(|(_, value)| value.clone());
        span = found.ok_or_else(|| PathError {
            part: part.to_string(),
            known: members.into_iter().map(|(name, _)| name).collect(),
        })?;
    }
    Ok(span)
}

/// Every value that has no members, with its path, in order.
pub fn leaves(text: &str) -> Vec<(String, &str)> {
    fn collect<'a>(text: &'a str, path: &str, span: Range<usize>, leaves: &mut Vec<(String, &'a str)>) {
        let members = members(text, span.clone());
        if members.is_empty() {
            leaves.push((path.to_string(), &text[span]));
        }
        for (name, value) in members {
            let path = if path.is_empty() { name } else { format!("{path}.{name}") };
            collect(text, &path, value, leaves);
        }
    }
    let mut all = Vec::new();
    collect(text, "", trim(text, 0..text.len()), &mut all);
    all
}

fn trim(text: &str, span: Range<usize>) -> Range<usize> {
    let inner = &text[span.clone()];
    let start = span.start + (inner.len() - inner.trim_start().len());
    start..start + inner.trim().len()
}

/// The members of a struct, tuple, list or enum variant: names, or numbers from 0 where there are none.
fn members(text: &str, span: Range<usize>) -> Vec<(String, Range<usize>)> {
    let value = &text[span.clone()];
    let opening = value.find(['(', '[', '"']).filter(|&i| !value[i..].starts_with('"'));
    let (Some(opening), true) = (opening, value.ends_with([')', ']'])) else { return Vec::new() };
    let inside = span.start + opening + 1..span.end - 1;
    split(text, inside, ',')
        .into_iter()
        .map(|part| trim(text, part))
        .filter(|part| !part.is_empty())
        .enumerate()
        .map(|(i, part)| match &split(text, part.clone(), ':')[..] {
            [name, rest @ ..] if !rest.is_empty() => {
                (text[name.clone()].trim().to_string(), trim(text, name.end + 1..part.end))
            }
            _ => (i.to_string(), part),
        })
        .collect()
}

/// The parts between separators that lie in no bracket and in no string.
fn split(text: &str, span: Range<usize>, separator: char) -> Vec<Range<usize>> {
    let mut parts = Vec::new();
    let mut start = span.start;
    let mut depth = 0;
    let mut quoted = false;
    let mut escaped = false;
    for (i, c) in text[span.clone()].char_indices().map(|(i, c)| (span.start + i, c)) {
        if quoted {
            quoted = escaped || c != '"';
            escaped = c == '\\' && !escaped;
            continue;
        }
        match c {
            '"' => quoted = true,
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            _ if c == separator && depth == 0 => {
                parts.push(start..i);
                start = i + 1;
            }
            _ => {}
        }
    }
    parts.push(start..span.end);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"(a: 1, b: (c: "x, (y: \"", d: [Left(e: 2.5), (3, Right)]), f: None)"#;

    #[test]
    fn values_are_found_by_name_and_number() {
        let value = |path| value_span(TEXT, path).map(|span| &TEXT[span]);
        assert_eq!(value("a"), Ok("1"));
        assert_eq!(value("b.c"), Ok(r#""x, (y: \"""#));
        assert_eq!(value("b.d.0"), Ok("Left(e: 2.5)"));
        assert_eq!(value("b.d.0.e"), Ok("2.5"));
        assert_eq!(value("b.d.1.1"), Ok("Right"));
        assert_eq!(value("f"), Ok("None"));
    }

    #[test]
    fn what_is_not_there_comes_with_what_is() {
        let error = |path| value_span(TEXT, path).unwrap_err();
        assert_eq!(error("b.x"), PathError { part: "x".into(), known: vec!["c".into(), "d".into()] });
        assert_eq!(error("b.d.7").known, ["0", "1"]);
        assert!(error("a.b").known.is_empty());
        assert!(error("b.c.y").known.is_empty());
    }
}
