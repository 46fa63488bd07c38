//! Tables as wide as there is room for: where there is too little, columns are left out, and no line is
//! broken.

use comfy_table::{CellAlignment, ColumnConstraint, Table};
use comfy_table::{LineStyle, TableStyle};

use super::style;

/// A rule below the heading, and nothing else.
pub(crate) const STYLE: TableStyle =
    TableStyle::new().header_separator(LineStyle::new('─', '─', '─', '─'));

/// A table of text: words to the left, figures to the right.
#[derive(Debug, Default)]
pub(crate) struct Rows {
    columns: Vec<Column>,
    rows: Vec<Vec<String>>,
}

#[derive(Debug)]
struct Column {
    heading: String,
    is_figure: bool,
    /// The higher, the sooner it is left out; none for one that stays.
    leaves: Option<u8>,
}

impl Rows {
    /// Another column of words.
    pub(crate) fn words(self, heading: &str) -> Self {
        self.column(heading, false)
    }

    /// Another column of figures.
    pub(crate) fn figures(self, heading: &str) -> Self {
        self.column(heading, true)
    }

    fn column(mut self, heading: &str, is_figure: bool) -> Self {
        self.columns.push(Column {
            heading: heading.to_owned(),
            is_figure,
            leaves: None,
        });
        self
    }

    /// The last column is left out where there is too little room, before those with a lower `rank`.
    pub(crate) fn dispensable(mut self, rank: u8) -> Self {
        if let Some(last) = self.columns.last_mut() {
            last.leaves = Some(rank);
        }
        self
    }

    /// Another row.
    pub(crate) fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }

    /// The table in so many characters a line, if it can be; what is left out is said below.
    pub(crate) fn within(&self, width: u16) -> String {
        let mut leaving: Vec<usize> = (0..self.columns.len()).collect();
        leaving.retain(|&place| self.columns[place].leaves.is_some());
        leaving.sort_by_key(|&place| self.columns[place].leaves);
        let mut left_out = Vec::new();
        loop {
            let lines = self.lines(&left_out);
            let longest = lines.iter().map(|line| measured(line)).max();
            let fits = longest.unwrap_or(0) <= usize::from(width);
            match leaving.pop().filter(|_| !fits) {
                Some(place) => left_out.push(place),
                None => return self.finished(&lines, &mut left_out),
            }
        }
    }

    fn lines(&self, left_out: &[usize]) -> Vec<String> {
        let mut table = Table::new();
        table.load_style(STYLE);
        table.set_header(self.columns.iter().map(|column| &column.heading));
        table.add_rows(&self.rows);
        for (place, column) in table.column_iter_mut().enumerate() {
            column.set_padding((0, 1));
            if self.columns[place].is_figure {
                column.set_cell_alignment(CellAlignment::Right);
            }
            if left_out.contains(&place) {
                column.set_constraint(ColumnConstraint::Hidden);
            }
        }
        let mut lines: Vec<String> = table
            .lines()
            .map(|line| line.trim_end().to_owned())
            .collect();
        let is_rule = |line: &str| line.starts_with('─');
        let texts = lines.iter().filter(|line| !is_rule(line));
        let longest = texts.map(|line| measured(line)).max().unwrap_or(0);
        // It is as long as what stands around it, without the room behind the last column.
        for rule in lines.iter_mut().filter(|line| is_rule(line)) {
            *rule = "─".repeat(longest);
        }
        lines
    }

    fn finished(&self, lines: &[String], left_out: &mut [usize]) -> String {
        let mut text: Vec<String> = lines.iter().map(|line| style::row(line)).collect();
        if !left_out.is_empty() {
            left_out.sort_unstable();
            let names = left_out
                .iter()
                .map(|&place| self.columns[place].heading.as_str());
            let names: Vec<_> = names.collect();
            text.push(format!(" (no room for: {})", names.join("; ")));
        }
        text.join("\n")
    }
}

/// Characters that a line takes.
fn measured(line: &str) -> usize {
    unicode_width::UnicodeWidthStr::width(line)
}
