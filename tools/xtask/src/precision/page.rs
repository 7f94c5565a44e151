//! The page: sections with tables, and how numbers with intervals are written.

use ergodic_assess::accuracy::Interval;

/// A part of the page.
#[derive(Debug)]
pub struct Section {
    pub title: &'static str,
    /// Paragraphs and tables, in Markdown.
    pub parts: Vec<String>,
}

impl Section {
    /// In Markdown.
    pub fn text(&self) -> String {
        format!("## {}\n\n{}\n", self.title, self.parts.join("\n\n"))
    }
}

/// A number with three digits.
pub fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if !(1e-3..1e5).contains(&size) => format!("{value:.1e}"),
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 10.0 => format!("{value:.1}"),
        size if size >= 0.1 => format!("{value:.2}"),
        _ => format!("{value:.4}"),
    }
}

/// A number with its interval.
pub fn cell(interval: Option<Interval>) -> String {
    interval.map_or("-".into(), |i| format!("{} ({} to {})", short(i.value), short(i.low), short(i.high)))
}

/// The same, with the value and its ends in percent and a sign.
pub fn signed_percent(interval: Option<Interval>) -> String {
    let percent = |value: f64| format!("{:+.2}", value * 100.0);
    interval.map_or("-".into(), |i| format!("{} % ({} to {})", percent(i.value), percent(i.low), percent(i.high)))
}

/// A table: heads, and rows of which the first column is text.
pub fn table(heads: &[&str], rows: &[Vec<String>]) -> String {
    let rule = format!("|---|{}", "--:|".repeat(heads.len() - 1));
    let lines = rows.iter().map(|row| format!("| {} |", row.join(" | ")));
    [format!("| {} |", heads.join(" | ")), rule].into_iter().chain(lines).collect::<Vec<_>>().join("\n")
}

/// What the system calls its processor.
fn processor() -> String {
    let cpuinfo = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpuinfo.lines().find(|line| line.starts_with("model name"));
    model
        .and_then(|line| line.split_once(':'))
        .map_or_else(|| "an unknown processor".into(), |(_, name)| name.trim().into())
}

/// The whole page.
pub fn text(sections: &[Section], seconds: f64) -> String {
    let sections: Vec<String> = sections.iter().map(Section::text).collect();
    format!(
        "# The price of precision\n\n\
         What is done here for accuracy, what it costs and what it gains. `cargo xtask precision` measures all of it and writes this \
         page;\n`cargo xtask precision --help` lists the parts.\n\n\
         Brackets are intervals of 95 % by the bootstrap over rounds or replicas. What is compared takes turns, and time is processor \
         time of\none thread, so that other programs disturb both alike. Measured on {}, {}, in {:.0} minutes.\n\n{}",
        processor(),
        std::env::consts::OS,
        (seconds / 60.0).ceil(),
        sections.join("\n")
    )
}
