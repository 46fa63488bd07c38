//! Tables within the available width. If it is too small, columns are left out, and no line is broken.

use comfy_table::{CellAlignment, ColumnConstraint, LineStyle, TableStyle};

use super::style;
use crate::present::Table;

/// A rule below the heading, and nothing else.
const STYLE: TableStyle = TableStyle::new().header_separator(LineStyle::new('─', '─', '─', '─'));

/// The table in at most `width` characters a line, if possible. Columns that were left out are named below.
pub(super) fn within(table: &Table, width: u16) -> String {
    let mut leaving: Vec<usize> = (0..table.columns.len()).collect();
    leaving.retain(|&place| table.columns[place].drop_order.is_some());
    leaving.sort_by_key(|&place| table.columns[place].drop_order);
    let mut left_out = Vec::new();
    loop {
        let lines = lines(table, &left_out);
        let longest = lines.iter().map(|line| measured(line)).max();
        let fits = longest.unwrap_or(0) <= usize::from(width);
        match leaving.pop().filter(|_| !fits) {
            Some(place) => left_out.push(place),
            None => return finished(table, &lines, &mut left_out, usize::from(width)),
        }
    }
}

fn lines(table: &Table, left_out: &[usize]) -> Vec<String> {
    let mut text = comfy_table::Table::new();
    text.load_style(STYLE);
    text.set_header(table.columns.iter().map(|column| &column.name));
    text.add_rows(&table.rows);
    for (place, column) in text.column_iter_mut().enumerate() {
        column.set_padding((0, 1));
        if table.columns[place].is_figures {
            column.set_cell_alignment(CellAlignment::Right);
        }
        if left_out.contains(&place) {
            column.set_constraint(ColumnConstraint::Hidden);
        }
    }
    let mut lines: Vec<String> = text
        .lines()
        .map(|line| line.trim_end().to_owned())
        .collect();
    let is_rule = |line: &str| line.starts_with('─');
    let texts = lines.iter().filter(|line| !is_rule(line));
    let longest = texts.map(|line| measured(line)).max().unwrap_or(0);
    // The rule is as long as the lines around it, without the padding of the last column.
    for rule in lines.iter_mut().filter(|line| is_rule(line)) {
        *rule = "─".repeat(longest);
    }
    lines
}

fn finished(table: &Table, lines: &[String], left_out: &mut [usize], width: usize) -> String {
    let mut text: Vec<String> = lines.iter().map(|line| style::row(line)).collect();
    left_out.sort_unstable();
    if let Some((last, others)) = left_out.split_last() {
        let name = |&place: &usize| table.columns[place].name.as_str();
        let columns = if others.is_empty() {
            "column"
        } else {
            "columns"
        };
        let others = others.iter().map(|place| format!("\"{}\",", name(place)));
        let mut line = format!(" (narrow terminal: {columns}");
        for name in others.chain([format!("\"{}\" hidden)", name(last))]) {
            if measured(&line) + 1 + measured(&name) > width {
                text.push(std::mem::replace(&mut line, " ".to_owned()));
            }
            line += &format!(" {name}");
        }
        text.push(line);
    }
    text.join("\n")
}

/// Characters that a line takes.
fn measured(line: &str) -> usize {
    unicode_width::UnicodeWidthStr::width(line)
}
