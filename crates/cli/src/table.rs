//! Tables of text.

/// Lines of a table, with a rule under the head. Columns of numbers line up to the right, others to the left.
pub fn lines(head: &[&str], rows: &[Vec<String>]) -> Vec<String> {
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count());
        cells.chain([head[column].chars().count()]).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    let is_number = |cell: &str| cell.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    let numeric = |column: usize| rows.iter().all(|row| row.get(column).is_none_or(|cell| is_number(cell)));
    let right: Vec<bool> = (0..head.len()).map(|column| column > 0 && numeric(column)).collect();
    let line = |cells: &mut dyn Iterator<Item = &str>| {
        let padded = cells
            .zip(&widths)
            .zip(&right)
            .map(|((cell, &width), right)| if *right { format!("{cell:>width$}") } else { format!("{cell:<width$}") });
        padded.collect::<Vec<_>>().join("  ").trim_end().to_string()
    };
    let rule = "-".repeat(widths.iter().sum::<usize>() + 2 * (widths.len() - 1));
    let mut lines = vec![line(&mut head.iter().copied()), rule];
    lines.extend(rows.iter().map(|row| line(&mut row.iter().map(String::as_str))));
    lines
}

/// A count with a unit of thousands, millions or billions.
pub fn count(n: f64) -> String {
    match n {
        n if n >= 1e9 => format!("{:.2} G", n / 1e9),
        n if n >= 1e6 => format!("{:.2} M", n / 1e6),
        n if n >= 1e4 => format!("{:.1} k", n / 1e3),
        n => format!("{n:.0}"),
    }
}

/// A share in percent.
pub fn percent(share: f64) -> String {
    if share > 0.0 && share < 0.001 { format!("{:.3} %", share * 100.0) } else { format!("{:.1} %", share * 100.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let rows = vec![vec!["lens".into(), "1".into()], vec!["multi_chain".into(), "12.5 M".into()]];
        let expected = ["mutation      count", "-------------------", "lens              1", "multi_chain  12.5 M"];
        assert_eq!(lines(&["mutation", "count"], &rows), expected);
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!([999.0, 12_345.0, 2.5e6, 3e9].map(count), ["999", "12.3 k", "2.50 M", "3.00 G"]);
        assert_eq!([0.0, 0.0005, 0.25].map(percent), ["0.0 %", "0.050 %", "25.0 %"]);
    }
}
