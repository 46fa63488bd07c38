//! Cells that are no numbers, rows that are no rows.

use super::super::GAIN;
use super::Expected::{Gain, Named};
use super::{Cases, lines, with_cell};

impl Cases {
    pub(super) fn broken_cells(&mut self) {
        let plain = self.motion.text();
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
            self.add(name, with_cell(&plain, place, cell), Named(words));
        }
        for (name, place, cell) in [
            ("NaN", 1, "nan"),
            ("an empty cell", 2, ""),
            ("no stamp", 0, "-"),
            ("a cell too many", 1, "0,0"),
        ] {
            self.add(name, with_cell(&plain, place, cell), Gain(GAIN));
        }
        self.add(
            "cut off in a row",
            plain[..plain.len() - 12].to_owned(),
            Gain(GAIN),
        );
        let mixed = plain.replace(',', ";");
        let mixed = lines(&mixed, |k, line| {
            Some(if k > 1500 {
                line.replace('.', ",")
            } else {
                line.to_owned()
            })
        });
        self.add(
            "points and commas",
            mixed,
            Named("a decimal comma where line"),
        );
    }
}
