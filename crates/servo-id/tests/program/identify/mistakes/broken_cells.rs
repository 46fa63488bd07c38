//! Cells that are no numbers, rows that are no rows.

use super::super::MOTION;
use super::Cases;

/// A log with a cell of the row 1500 replaced.
fn with_cell(place: usize, cell: &str) -> String {
    let text = MOTION.text();
    let mut lines: Vec<_> = text.lines().map(str::to_owned).collect();
    let mut cells: Vec<_> = lines[1500].split(',').collect();
    cells[place] = cell;
    lines[1500] = cells.join(",");
    lines.join("\n") + "\n"
}

impl Cases {
    pub(super) fn broken_cells(&mut self) {
        let plain = MOTION.text();
        for (name, place, cell, words) in [
            ("infinite", 2, "inf", "log.csv:1501: column u_V"),
            (
                "a word",
                1,
                "overload",
                "log.csv:1501: column q_rad: \"overload\"",
            ),
            ("out of range", 2, "1e40", "log.csv:1501: column u_V"),
        ] {
            self.named(name, with_cell(place, cell), words);
        }
        for (name, place, cell) in [
            ("NaN", 1, "nan"),
            ("an empty cell", 2, ""),
            ("no stamp", 0, "-"),
            ("a cell too many", 1, "0,0"),
        ] {
            self.right(name, with_cell(place, cell));
        }
        self.right("cut off in a row", &plain[..plain.len() - 12]);
        let line = |(k, line): (usize, &str)| match k > 1500 {
            true => line.replace('.', ",") + "\n",
            false => format!("{line}\n"),
        };
        let mixed = plain
            .replace(',', ";")
            .lines()
            .enumerate()
            .map(line)
            .collect::<String>();
        self.named("points and commas", mixed, "a decimal comma where line");
    }
}
