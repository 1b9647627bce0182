//! Plain text tables: aligned columns, two spaces between them, a line under the heads.

use std::fmt;

/// Where a cell's text stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// At the left, for names.
    Left,
    /// At the right, for numbers.
    Right,
}

/// A table to be printed.
#[derive(Debug, Clone)]
pub struct Table {
    heads: Vec<(String, Align)>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows; the first column is for names, the others for numbers.
    pub fn new(heads: &[&str]) -> Self {
        let align = |index| if index == 0 { Align::Left } else { Align::Right };
        let heads = heads.iter().enumerate().map(|(index, head)| ((*head).to_owned(), align(index))).collect();
        Self { heads, rows: Vec::new() }
    }

    /// Adds a row; cells that are missing stay empty.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    fn widths(&self) -> Vec<usize> {
        let cell = |row: &Vec<String>, column: usize| row.get(column).map_or(0, |cell| cell.chars().count());
        let widest = |(column, (head, _)): (usize, &(String, Align))| {
            let rows = self.rows.iter().map(|row| cell(row, column)).max().unwrap_or(0);
            rows.max(head.chars().count())
        };
        self.heads.iter().enumerate().map(widest).collect()
    }

    fn line(&self, widths: &[usize], cells: &[String]) -> String {
        let mut line = String::new();
        for (column, (width, (_, align))) in widths.iter().zip(&self.heads).enumerate() {
            let cell = cells.get(column).map_or("", String::as_str);
            let space = " ".repeat(width - cell.chars().count());
            let gap = if column == 0 { "" } else { "  " };
            line += &match align {
                Align::Left => format!("{gap}{cell}{space}"),
                Align::Right => format!("{gap}{space}{cell}"),
            };
        }
        line.trim_end().to_owned()
    }
}

impl fmt::Display for Table {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let widths = self.widths();
        let heads: Vec<String> = self.heads.iter().map(|(head, _)| head.clone()).collect();
        writeln!(out, "{}", self.line(&widths, &heads))?;
        let rule: Vec<String> = widths.iter().map(|width| "─".repeat(*width)).collect();
        writeln!(out, "{}", self.line(&widths, &rule))?;
        self.rows.iter().try_for_each(|row| writeln!(out, "{}", self.line(&widths, row)))
    }
}

/// Milliseconds with digits that fit their size: `0.123`, `12.3`, `1234`.
pub fn milliseconds(value: f64) -> String {
    let digits = match value.abs() {
        v if v < 10.0 => 3,
        v if v < 1000.0 => 1,
        _ => 0,
    };
    format!("{value:.digits$}")
}

/// A share as a percentage: 0.1234 is `12.3 %`, 0.00123 is `0.12 %`.
pub fn percent(value: f64) -> String {
    let digits = if value.abs() < 0.0995 { 2 } else { 1 };
    format!("{:.digits$} %", value * 100.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_by_letters_not_bytes() {
        let mut table = Table::new(&["pass", "ms"]);
        table.row(["Überblend".to_owned(), "1.5".to_owned()]);
        table.row(["b".to_owned(), "12.25".to_owned()]);
        table.row(["short".to_owned()]);
        assert_eq!(
            table.to_string(),
            "pass          ms\n─────────  ─────\nÜberblend    1.5\nb          12.25\nshort\n"
        );
    }

    #[test]
    fn numbers_keep_about_three_digits() {
        assert_eq!([0.1234, 12.34, 1234.5].map(milliseconds), ["0.123", "12.3", "1234"]);
        assert_eq!([0.1234, 0.00123].map(percent), ["12.3 %", "0.12 %"]);
    }
}
