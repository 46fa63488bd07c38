//! What the colours of a picture mean, written in lines that cover nothing.

use super::canvas::{Align, BLACK, Frame, SMALL, Sheet, Stroke, width};

/// Height of a line, points.
pub(super) const LINE: f64 = 10.0;

/// Length of what a line or a colour is shown by, and room behind it and behind the words, points.
const SAMPLE: f64 = 12.0;
const BEHIND_SAMPLE: f64 = 3.0;
const BEHIND_WORDS: f64 = 9.0;

/// How much of a colour is seen where it lies behind curves.
pub(super) const BAND: f64 = 0.25;

/// What something is shown by.
#[derive(Debug, Clone, Copy)]
pub(super) enum Mark {
    /// A line.
    Line(Stroke),
    /// A line in a band of its colour.
    Banded(Stroke),
    /// An area of a colour, of which so much is seen.
    Area(&'static str, f64),
}

/// An entry.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    pub(super) mark: Mark,
    pub(super) words: String,
}

/// Where each entry stands: its line, and how far to the right.
fn places(entries: &[Entry], room: f64) -> Vec<(usize, f64)> {
    let (mut line, mut x) = (0, 0.0);
    let place = |entry: &Entry| {
        let long = SAMPLE + BEHIND_SAMPLE + width(&entry.words, SMALL);
        if x > 0.0 && x + long > room {
            line += 1;
            x = 0.0;
        }
        let place = (line, x);
        x += long + BEHIND_WORDS;
        place
    };
    entries.iter().map(place).collect()
}

/// Lines that entries take in so much room.
pub(super) fn lines(entries: &[Entry], room: f64) -> usize {
    places(entries, room).last().map_or(0, |(line, _)| line + 1)
}

/// Writes them, from the upper left corner on.
pub(super) fn draw(sheet: &mut Sheet, (left, top): (f64, f64), room: f64, entries: &[Entry]) {
    /// How far below a line's top the words stand, and the middle of what is before them.
    const BASE: f64 = 7.0;
    const MIDDLE: f64 = 4.5;
    for (entry, (line, x)) in entries.iter().zip(places(entries, room)) {
        let (x, y) = (left + x, top + line as f64 * LINE);
        let area = Frame {
            left: x,
            top: y + 1.5,
            width: SAMPLE,
            height: 6.0,
        };
        let ends = ((x, y + MIDDLE), (x + SAMPLE, y + MIDDLE));
        match entry.mark {
            Mark::Line(stroke) => sheet.line(ends.0, ends.1, stroke),
            Mark::Banded(stroke) => {
                sheet.rectangle(area, stroke.colour, BAND);
                sheet.line(ends.0, ends.1, stroke);
            }
            Mark::Area(colour, opacity) => sheet.rectangle(area, colour, opacity),
        }
        let at = (x + SAMPLE + BEHIND_SAMPLE, y + BASE);
        sheet.words(at, &entry.words, SMALL, Align::Left, BLACK);
    }
}
