//! Meaning of colours, in lines that cover nothing.

use super::canvas::{Canvas, SMALL};
use super::font::width;
use super::plot::{BAND_OPACITY, LEVEL, SPAN_OPACITY, trace_stroke};
use super::surface::{Align, Colour, Frame, Stroke};
use crate::present::Figure;

/// Height of a line, points.
pub(super) const LINE: f64 = 10.0;

/// Length of the sample of a line or a colour, and room behind it and behind the text, points.
const SAMPLE: f64 = 12.0;
const BEHIND_SAMPLE: f64 = 3.0;
const BEHIND_TEXT: f64 = 9.0;

/// Sample of an entry.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Mark {
    /// The trace of this number, with a band or without.
    Trace(usize, bool),
    /// A level.
    Level,
    /// A stretch of this colour.
    TimeSpan(usize),
}

impl Mark {
    fn is_like(self, other: Self) -> bool {
        match (self, other) {
            (Self::Trace(one, _), Self::Trace(other, _)) => one == other,
            _ => self == other,
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
struct Entry {
    mark: Mark,
    text: String,
}

/// A legend.
#[derive(Debug, Clone, Default)]
pub(super) struct Legend {
    entries: Vec<Entry>,
}

impl Legend {
    /// That of a figure: stretches, traces if there is more to one than the axis says, and levels.
    pub(super) fn of_figure(figure: &Figure) -> Self {
        let time_spans = figure.time_spans.iter().map(|time_span| Entry {
            mark: Mark::TimeSpan(time_span.colour),
            text: time_span.name.clone(),
        });
        let is_told = figure.traces.len() > 1 || figure.traces.iter().any(|t| !t.band.is_empty());
        let traces = figure.traces.iter().enumerate().filter(|_| is_told);
        let traces = traces.map(|(place, trace)| Entry {
            mark: Mark::Trace(place, !trace.band.is_empty()),
            text: trace.name.clone(),
        });
        let levels = figure.levels.iter().map(|level| Entry {
            mark: Mark::Level,
            text: level.name.clone(),
        });
        let mut legend = Self::default();
        time_spans
            .chain(traces)
            .chain(levels)
            .for_each(|entry| legend.add(entry));
        legend
    }

    /// One for several figures, if a mark means the same in all of them.
    pub(super) fn shared(figures: &[Figure]) -> Option<Self> {
        let mut own: Vec<Self> = figures.iter().map(Self::of_figure).collect();
        own.retain(|legend| !legend.entries.is_empty());
        let mut shared = Self::default();
        for entry in own.iter().flat_map(|legend| &legend.entries) {
            shared.add(entry.clone());
        }
        let is_level = |entry: &Entry| entry.mark == Mark::Level;
        shared.entries.sort_by_key(is_level);
        let conflict = |one: &Entry| {
            let of_one_mark = |other: &&Entry| one.mark.is_like(other.mark);
            !matches!(one.mark, Mark::TimeSpan(_))
                && shared.entries.iter().filter(of_one_mark).count() > 1
        };
        (own.len() > 1 && !shared.entries.iter().any(conflict)).then_some(shared)
    }

    fn add(&mut self, entry: Entry) {
        if !self.entries.contains(&entry) {
            self.entries.push(entry);
        }
    }

    /// Line and distance from the left of each entry.
    fn places(&self, room: f64) -> Vec<(usize, f64)> {
        let (mut line, mut x) = (0, 0.0);
        let place = |entry: &Entry| {
            let length = SAMPLE + BEHIND_SAMPLE + width(&entry.text, SMALL);
            if x > 0.0 && x + length > room {
                line += 1;
                x = 0.0;
            }
            let place = (line, x);
            x += length + BEHIND_TEXT;
            place
        };
        self.entries.iter().map(place).collect()
    }

    /// Its height in this width.
    pub(super) fn height(&self, room: f64) -> f64 {
        let lines = self.places(room).last().map_or(0, |(line, _)| line + 1);
        lines as f64 * LINE
    }

    /// Draws it from its left upper corner.
    pub(super) fn draw(&self, canvas: &mut Canvas, (left, top): (f64, f64), room: f64) {
        /// Distance of the base line below a line's top, and of the middle of samples.
        const BASE: f64 = 7.0;
        const MIDDLE: f64 = 4.5;
        for (entry, (line, x)) in self.entries.iter().zip(self.places(room)) {
            let (x, y) = (left + x, top + line as f64 * LINE);
            let area = Frame {
                left: x,
                top: y + 1.5,
                width: SAMPLE,
                height: 6.0,
            };
            let sample = |canvas: &mut Canvas, stroke: Stroke| {
                canvas.line((x, y + MIDDLE), (x + SAMPLE, y + MIDDLE), stroke);
            };
            match entry.mark {
                Mark::Trace(place, is_banded) => {
                    let stroke = trace_stroke(place);
                    if is_banded {
                        canvas.rectangle(area, stroke.colour, BAND_OPACITY);
                    }
                    sample(canvas, stroke);
                }
                Mark::Level => sample(canvas, LEVEL),
                Mark::TimeSpan(colour) => {
                    canvas.rectangle(area, Colour::TimeSpan(colour), SPAN_OPACITY);
                }
            }
            let at = (x + SAMPLE + BEHIND_SAMPLE, y + BASE);
            canvas.text(at, &entry.text, SMALL, Align::Left);
        }
    }
}
