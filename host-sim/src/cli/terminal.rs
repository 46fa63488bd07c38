//! The width of the terminal.

use terminal_size::{Width, terminal_size_of};

/// Characters to a line where there is no terminal.
const ELSEWHERE: u16 = 100;

/// Narrowest width of a table.
const MIN_WIDTH: u16 = 20;

/// Characters to a line: COLUMNS, the terminal's width, or 100.
pub(super) fn width() -> u16 {
    let stated = std::env::var("COLUMNS").ok();
    let stated = stated.and_then(|columns| columns.trim().parse().ok());
    let is_wide_enough = |width: &u16| *width >= MIN_WIDTH;
    stated
        .filter(is_wide_enough)
        .or_else(|| terminal_size_of(std::io::stdout()).map(|(Width(width), _)| width))
        .filter(is_wide_enough)
        .unwrap_or(ELSEWHERE)
}
