//! Tables with groups of columns, cut into several where they are too wide.

/// No line is longer, unless a single column is.
pub const WIDTH: usize = 110;
const GAP: usize = 2;

/// A column: its head and its cells.
#[derive(Clone, Debug)]
pub struct Cells {
    pub head: String,
    pub cells: Vec<String>,
}

/// Columns that belong together.
#[derive(Clone, Debug)]
pub struct Group {
    /// Over the heads; empty for none.
    pub title: String,
    pub columns: Vec<Cells>,
}

fn length(text: &str) -> usize {
    text.chars().count()
}

impl Cells {
    fn width(&self) -> usize {
        self.cells.iter().chain([&self.head]).map(|cell| length(cell)).max().unwrap_or(0)
    }

    fn is_numeric(&self) -> bool {
        self.cells.iter().all(|cell| cell.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)))
    }
}

impl Group {
    fn width(&self) -> usize {
        let columns = self.columns.iter().map(|column| column.width() + GAP).sum::<usize>();
        columns.saturating_sub(GAP).max(length(&self.title))
    }

    /// The group, or its columns in several groups of the same title where it is wider than what there is.
    fn cut(self, room: usize) -> Vec<Self> {
        let mut parts = vec![Self { title: self.title.clone(), columns: Vec::new() }];
        for column in self.columns {
            let last = parts.len() - 1;
            parts[last].columns.push(column);
            if parts[last].columns.len() > 1 && parts[last].width() > room {
                let column = parts[last].columns.pop();
                parts.push(Self { title: self.title.clone(), columns: column.into_iter().collect() });
            }
        }
        parts
    }
}

/// Lines of one or more tables: each has the labels in front, and as many groups as there is room for.
pub fn lines(labels: &[Cells], groups: Vec<Group>) -> Vec<String> {
    let front = labels.iter().map(|label| label.width() + GAP).sum::<usize>();
    let room = WIDTH.saturating_sub(front);
    let mut tables: Vec<Vec<Group>> = Vec::new();
    let mut used = 0;
    for group in groups.into_iter().flat_map(|group| group.cut(room)) {
        let width = group.width() + GAP + 1;
        match tables.last_mut() {
            Some(table) if used + width <= room + GAP => {
                table.push(group);
                used += width;
            }
            _ => {
                tables.push(vec![group]);
                used = width;
            }
        }
    }
    let mut lines = Vec::new();
    for table in tables {
        if !lines.is_empty() {
            lines.push(String::new());
        }
        lines.extend(one(labels, &table));
    }
    lines
}

fn one(labels: &[Cells], groups: &[Group]) -> Vec<String> {
    let padded = |text: &str, width: usize, right: bool| {
        if right { format!("{text:>width$}") } else { format!("{text:<width$}") }
    };
    let line = |label: &dyn Fn(&Cells) -> String, of: &dyn Fn(&Cells) -> String| {
        let gap = " ".repeat(GAP);
        let labels = labels.iter().map(|column| padded(&label(column), column.width(), false));
        let groups = groups.iter().enumerate().map(|(i, group)| {
            let cells = group.columns.iter().map(|column| padded(&of(column), column.width(), column.is_numeric()));
            let text = padded(&cells.collect::<Vec<_>>().join(&gap), group.width(), false);
            // Groups stand a little further apart than columns.
            if i > 0 { format!(" {text}") } else { text }
        });
        labels.chain(groups).collect::<Vec<_>>().join(&gap).trim_end().to_string()
    };
    let mut lines = Vec::new();
    if groups.iter().any(|group| !group.title.is_empty()) {
        let front: String = labels.iter().map(|label| " ".repeat(label.width() + GAP)).collect();
        let titles = groups.iter().enumerate().map(|(i, group)| {
            let text = padded(&group.title, group.width(), false);
            if i > 0 { format!(" {text}") } else { text }
        });
        lines.push(format!("{front}{}", titles.collect::<Vec<_>>().join(&" ".repeat(GAP))).trim_end().to_string());
    }
    lines.push(line(&|label| label.head.clone(), &|column| column.head.clone()));
    let rows = labels.first().or_else(|| groups.first()?.columns.first()).map_or(0, |column| column.cells.len());
    let body: Vec<String> = (0..rows)
        .map(|row| {
            let cell = |column: &Cells| column.cells.get(row).cloned().unwrap_or_default();
            line(&cell, &cell)
        })
        .collect();
    let rule = lines.iter().chain(&body).map(|line| length(line)).max().unwrap_or(0);
    lines.push("-".repeat(rule));
    lines.extend(body);
    lines
}

/// A sentence in lines of the width, all but the first indented.
pub fn wrapped(text: &str, indent: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if length(line) + 1 + length(word) <= WIDTH => {
                line.push(' ');
                line.push_str(word);
            }
            Some(_) => lines.push(format!("{}{word}", " ".repeat(indent))),
            None => lines.push(word.to_string()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(head: &str, cells: &[&str]) -> Cells {
        Cells { head: head.into(), cells: cells.iter().map(ToString::to_string).collect() }
    }

    #[test]
    fn groups_stand_side_by_side_with_their_titles() {
        let labels = [column("mutation", &["lens", "caustic"])];
        let group = |title: &str| Group { title: title.into(), columns: vec![column("ns", &["1", "20"])] };
        let expected = [
            "          first   second",
            "mutation  ns      ns",
            "------------------------",
            "lens       1       1",
            "caustic   20      20",
        ];
        assert_eq!(lines(&labels, vec![group("first"), group("second")]), expected);
    }

    #[test]
    fn what_is_too_wide_becomes_several_tables_and_nothing_is_lost() {
        let labels = [column("class", &["LDE", "LSDE"])];
        let wide = |i: usize| Group {
            title: format!("run {i}"),
            columns: (0..14).map(|j| column(&format!("head {i} {j}"), &["1.0", "2.0"])).collect(),
        };
        let lines = lines(&labels, (0..5).map(wide).collect());
        assert!(lines.iter().all(|line| length(line) <= WIDTH), "{lines:#?}");
        let text = lines.join("\n");
        for i in 0..5 {
            assert!((0..14).all(|j| text.contains(&format!("head {i} {j}"))), "{text}");
        }
        assert!(lines.iter().filter(|line| line.starts_with("LSDE")).count() >= 7);
    }
}
