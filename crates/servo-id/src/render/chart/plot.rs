//! A figure in its frame: grid, stretches, traces and axes.

use std::ops::RangeInclusive;

use super::canvas::{Canvas, SMALL, TINY};
use super::font::width;
use super::scale::Scale;
use super::surface::{Align, Colour, Frame, Stroke};
use crate::present::{Figure, Trace};

/// Room for text to the left of the frame, to its right and below it, points. The left one is a minimum.
const MIN_LEFT: f64 = 30.0;
pub(super) const RIGHT: f64 = 9.0;
pub(super) const BELOW: f64 = 27.0;

/// The most lines of names there, and the height of one.
const MAX_LINES: usize = 3;
const LINE: f64 = 8.0;

/// A constant to compare with.
pub(super) const LEVEL: Stroke = Stroke {
    colour: Colour::Ink,
    width: 0.8,
    dashes: Some([3.0, 2.0]),
};
const AXIS: Stroke = Stroke::solid(Colour::Ink, 0.6);
const GRID: Stroke = Stroke::solid(Colour::Grid, 0.5);

/// Opacity of bands and stretches.
pub(super) const BAND_OPACITY: f64 = 0.25;
pub(super) const SPAN_OPACITY: f64 = 0.35;

/// Widths of traces in their order, points: one that lies under the first is seen beside it.
const WIDTHS: [f64; 4] = [0.7, 1.4, 2.2, 0.7];

/// Length of a tick.
const TICK: f64 = 2.5;

/// Room between a tick and its text.
const BEHIND_TICK: f64 = 2.0;

/// Room that the figures at the left of frames take where these begin at one place, points.
pub(super) fn room_at_left<'a>(figures: impl IntoIterator<Item = &'a Figure>) -> f64 {
    let widths = figures
        .into_iter()
        .map(|figure| widest(&vertical(figure), SMALL));
    widths.fold(MIN_LEFT, |room: f64, width| {
        room.max(width + TICK + BEHIND_TICK)
    })
}

/// Width of the widest text at the ticks of a scale.
fn widest(scale: &Scale, size: u32) -> f64 {
    let texts = scale.ticks().map(|(_, text)| width(&text, size));
    texts.fold(0.0, f64::max)
}

pub(super) fn trace_stroke(place: usize) -> Stroke {
    Stroke::solid(Colour::Trace(place), WIDTHS[place % WIDTHS.len()])
}

/// A figure with its scales.
#[derive(Debug)]
pub(super) struct Plot<'a> {
    figure: &'a Figure,
    frame: Frame,
    horizontal: Scale,
    vertical: Scale,
}

impl<'a> Plot<'a> {
    pub(super) fn new(figure: &'a Figure, frame: Frame) -> Self {
        Self {
            figure,
            frame,
            horizontal: horizontal(figure, frame.width),
            vertical: vertical(figure),
        }
    }

    /// Title and vertical axis in one line.
    pub(super) fn heading(&self) -> String {
        let axis = self.vertical.named(&self.figure.vertical.name);
        match self.figure.title.as_str() {
            "" => axis,
            title => format!("{title}: {axis}"),
        }
    }

    /// The power of ten of the figures at the vertical axis. It is written above the axis unless a heading has it.
    pub(super) fn draw_power(&self, canvas: &mut Canvas) {
        if let Some(power) = self.vertical.power() {
            let at = (self.frame.left, self.frame.top - 3.0);
            canvas.text(at, &format!("× {power}"), SMALL, Align::Left);
        }
    }

    /// Draws it; `is_lowest` where no figure below has the same horizontal axis.
    pub(super) fn draw(&self, canvas: &mut Canvas, is_lowest: bool) {
        self.ground(canvas);
        canvas.inside(self.frame, |canvas| self.traces(canvas));
        self.axes(canvas, is_lowest);
        if let Some(inset) = self.inset() {
            inset.draw_as_inset(canvas);
        }
    }

    /// The settled part on a scale of its own, under or above its trace and over the same places.
    fn inset(&self) -> Option<Self> {
        /// Height, a part of the frame's: the largest, and the smallest that can be read.
        const HEIGHT: RangeInclusive<f64> = 0.28..=0.5;
        /// Room between the inset and trace or frame, a part of the frame's height.
        const ROOM: f64 = 0.05;
        /// Height of its name, points.
        const NAME: f64 = 8.0;
        /// Largest numbers of steps of its scale, the coarsest with two ticks is taken.
        const STEPS: [u32; 4] = [3, 4, 5, 6];
        let settled = self.figure.settled?;
        let [low, high] = settled.range;
        let [below, above] = [low, high].map(|value| self.vertical.part(value).clamp(0.0, 1.0));
        let is_above = 1.0 - above > below;
        let height = (below.max(1.0 - above) - 2.0 * ROOM).min(*HEIGHT.end());
        if height < *HEIGHT.start() || self.horizontal.is_logarithmic() {
            return None;
        }
        // Above the trace there is a line of text.
        let high = high + (high - low) * NAME / (height * self.frame.height - NAME);
        let scales = STEPS.map(|steps| Scale::between(low, high, steps));
        let vertical = scales.into_iter().find(|scale| scale.ticks().count() > 1)?;
        let labels = widest(&vertical, TINY) + 2.0 * BEHIND_TICK;
        let left = self.x(settled.from) + labels;
        let bottom = if is_above { 1.0 - ROOM - height } else { ROOM };
        let frame = Frame {
            left,
            top: self.frame.bottom() - (bottom + height) * self.frame.height,
            width: self.frame.right() - left,
            height: height * self.frame.height,
        };
        let from = (left - self.frame.left) / self.frame.width;
        Some(Self {
            figure: self.figure,
            frame,
            horizontal: self.horizontal.beginning_at(self.horizontal.value(from)),
            vertical,
        })
    }

    fn draw_as_inset(&self, canvas: &mut Canvas) {
        let labels = widest(&self.vertical, TINY) + BEHIND_TICK;
        let ground = Frame {
            left: self.frame.left - labels,
            width: self.frame.width + labels,
            ..self.frame
        };
        canvas.rectangle(ground, Colour::Paper, 1.0);
        self.grid(canvas);
        canvas.inside(self.frame, |canvas| self.traces(canvas));
        let Frame { left, top, .. } = self.frame;
        let (right, bottom) = (self.frame.right(), self.frame.bottom());
        let corners = [(left, top), (right, top), (right, bottom), (left, bottom)];
        canvas.curve(corners.into_iter().chain([(left, top)]), AXIS);
        for (y, text) in self.vertical_ticks() {
            let at = (left - BEHIND_TICK, y + 2.0);
            canvas.text(at, &text, TINY, Align::Right);
        }
        let power = self.vertical.power();
        let power = power.map_or_else(String::new, |power| format!(", × {power}"));
        let at = (left + BEHIND_TICK, top + 6.0);
        let name = format!("enlarged{power}");
        canvas.text(at, &name, TINY, Align::Left);
    }

    /// Heights and texts of the ticks.
    fn vertical_ticks(&self) -> impl Iterator<Item = (f64, String)> {
        let frame = self.frame;
        let ticks = self.vertical.ticks();
        ticks.map(move |(part, text)| (frame.bottom() - part * frame.height, text))
    }

    fn x(&self, place: f64) -> f64 {
        self.frame.left + self.horizontal.part(place) * self.frame.width
    }

    /// Values far outside are drawn a little outside.
    fn y(&self, value: f64) -> f64 {
        self.frame.bottom() - self.vertical.part(value).clamp(-1.0, 2.0) * self.frame.height
    }

    fn ground(&self, canvas: &mut Canvas) {
        let frame = self.frame;
        for time_span in &self.figure.time_spans {
            let inside = |place| self.x(place).clamp(frame.left, frame.right());
            let [left, right] = time_span.extent.map(inside);
            let part = Frame {
                left,
                width: right - left,
                ..frame
            };
            canvas.rectangle(part, Colour::TimeSpan(time_span.colour), SPAN_OPACITY);
        }
        self.grid(canvas);
    }

    fn grid(&self, canvas: &mut Canvas) {
        let frame = self.frame;
        for (y, _) in self.vertical_ticks() {
            canvas.line((frame.left, y), (frame.right(), y), GRID);
        }
        for (part, _) in self.horizontal.ticks() {
            let x = frame.left + part * frame.width;
            canvas.line((x, frame.top), (x, frame.bottom()), GRID);
        }
    }

    fn traces(&self, canvas: &mut Canvas) {
        for (place, trace) in self.figure.traces.iter().enumerate().rev() {
            let stroke = trace_stroke(place);
            let points = self.thinned(trace);
            let edge = |sign: f64| {
                move |point: &Point| {
                    (
                        self.x(point.place),
                        self.y(point.value + sign * point.half_width),
                    )
                }
            };
            if points.iter().any(|point| point.half_width > 0.0) {
                let upper = points.iter().map(edge(1.0));
                let lower = points.iter().rev().map(edge(-1.0));
                canvas.area(upper.chain(lower), stroke.colour, BAND_OPACITY);
            }
            canvas.curve(points.iter().map(edge(0.0)), stroke);
        }
        for level in self
            .figure
            .levels
            .iter()
            .filter(|level| level.value.is_finite())
        {
            let y = self.y(level.value);
            canvas.line((self.frame.left, y), (self.frame.right(), y), LEVEL);
        }
    }

    /// The lowest and the highest point of each column, in their order: more would not be seen.
    fn thinned(&self, trace: &Trace) -> Vec<Point> {
        /// Columns to a point: each is narrower than the thinnest line.
        const COLUMNS_PER_POINT: f64 = 2.0;
        let bands = trace.band.iter().copied().chain(std::iter::repeat(0.0));
        let points = trace.points.iter().zip(bands);
        let points: Vec<Point> = points
            .filter(|((place, value), _)| place.is_finite() && value.is_finite())
            .map(|(&(place, value), half_width)| Point {
                place,
                value,
                half_width: if half_width.is_finite() {
                    half_width
                } else {
                    0.0
                },
            })
            .collect();
        let column = |point: &Point| (self.x(point.place) * COLUMNS_PER_POINT).floor() as i64;
        points
            .chunk_by(|one, next| column(one) == column(next))
            .flat_map(|chunk| {
                let order =
                    |one: &usize, other: &usize| chunk[*one].value.total_cmp(&chunk[*other].value);
                let lowest = (0..chunk.len()).min_by(order);
                let highest = (0..chunk.len()).max_by(order);
                // In their order in the trace: a step is two values at one place.
                let mut ends: Vec<usize> = lowest.into_iter().chain(highest).collect();
                ends.sort_unstable();
                ends.dedup();
                ends.into_iter().map(|end| chunk[end])
            })
            .collect()
    }

    /// The lines over which names at ticks are spread so that none lies on another.
    fn lines(&self, ticks: &[(f64, String)]) -> usize {
        let is_apart = |lines: &usize| {
            let pairs = ticks.iter().zip(ticks.iter().skip(*lines));
            let mut rooms = pairs.map(|((left, one), (right, other))| {
                let middle = 0.5 * (width(one, SMALL) + width(other, SMALL));
                (right - left) * self.frame.width - middle
            });
            rooms.all(|room| room > BEHIND_TICK)
        };
        match self.figure.horizontal.names.is_empty() {
            true => 1,
            false => (1..MAX_LINES).find(is_apart).unwrap_or(MAX_LINES),
        }
    }

    fn axes(&self, canvas: &mut Canvas, is_lowest: bool) {
        let Frame { left, top, .. } = self.frame;
        let (right, bottom) = (self.frame.right(), self.frame.bottom());
        canvas.curve([(left, top), (left, bottom), (right, bottom)], AXIS);
        for (y, text) in self.vertical_ticks() {
            canvas.line((left - TICK, y), (left, y), AXIS);
            let at = (left - TICK - BEHIND_TICK, y + 2.5);
            canvas.text(at, &text, SMALL, Align::Right);
        }
        let ticks: Vec<_> = self.horizontal.ticks().collect();
        let lines = self.lines(&ticks);
        for (place, (part, text)) in ticks.iter().enumerate() {
            let x = left + part * self.frame.width;
            canvas.line((x, bottom), (x, bottom + TICK), AXIS);
            if is_lowest {
                let line = (place % lines) as f64;
                let at = (x, bottom + TICK + 7.5 + line * LINE);
                canvas.text(at, text, SMALL, Align::Middle);
            }
        }
        if is_lowest {
            let at = (0.5 * (left + right), bottom + 20.0);
            let name = self.horizontal.named(&self.figure.horizontal.name);
            canvas.text(at, &name, super::canvas::LETTER, Align::Middle);
        }
    }
}

/// A point with half the width of its band.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    place: f64,
    value: f64,
    half_width: f64,
}

/// True if two figures, one below the other, have the same horizontal axis.
pub(super) fn have_one_axis(one: &Figure, other: &Figure) -> bool {
    one.horizontal == other.horizontal && horizontal(one, 1.0) == horizontal(other, 1.0)
}

fn horizontal(figure: &Figure, width: f64) -> Scale {
    /// Shortest length of a step, points.
    const MIN_STEP: f64 = 32.0;
    let (first, last) = figure.extent();
    let names = &figure.horizontal.names;
    if !names.is_empty() {
        return Scale::between(first, last, 1).named_by(names);
    }
    match figure.horizontal.is_logarithmic && first > 0.0 {
        true => Scale::logarithmic(first, last),
        false => Scale::between(first.min(0.0), last, (width / MIN_STEP).max(1.0) as u32),
    }
}

fn vertical(figure: &Figure) -> Scale {
    const MAX_STEPS: u32 = 5;
    let levels = figure.levels.iter().map(|level| level.value);
    match (figure.vertical.range, figure.values()) {
        (Some([low, high]), _) => {
            let levels = levels.filter(|value| value.is_finite());
            let (low, high) = levels.fold((low, high), |(low, high), value| {
                (low.min(value), high.max(value))
            });
            Scale::between(low, high, MAX_STEPS)
        }
        (None, Some((low, high))) => Scale::around(low, high, MAX_STEPS),
        (None, None) => Scale::around(0.0, 1.0, MAX_STEPS),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
        let trace = Trace::new("", points.to_vec());
        let figure = Figure::new("", "", "", vec![trace.clone()]);
        let frame = Frame {
            left: 0.0,
            top: 0.0,
            width: 100.0,
            height: 10.0,
        };
        let points = Plot::new(&figure, frame).thinned(&trace).into_iter();
        points.map(|point| (point.place, point.value)).collect()
    }

    #[test]
    fn a_step_stands_upright_whichever_way_it_goes() {
        let up = [(0.0, 0.0), (0.5, 0.0), (0.5, 1.0), (1.0, 1.0)];
        assert_eq!(drawn(&up), up);
        let down = [(0.0, 1.0), (0.5, 1.0), (0.5, 0.0), (1.0, 0.0)];
        assert_eq!(drawn(&down), down);
    }

    #[test]
    fn a_trace_too_dense_to_be_seen_is_drawn_by_its_extremes() {
        let dense: Vec<(f64, f64)> = (0..100_000)
            .map(|step| {
                let place = f64::from(step) * 1e-5;
                (place, (1e4 * place).sin())
            })
            .collect();
        let drawn = drawn(&dense);
        assert!(drawn.len() <= 2 * 201, "{}", drawn.len());
        assert!(drawn.is_sorted_by(|one, next| one.0 <= next.0));
        let highest = drawn
            .iter()
            .fold(0.0, |most: f64, &(_, value)| most.max(value));
        assert!(highest > 0.999, "{highest}");
    }

    #[test]
    fn a_settled_part_is_enlarged_beside_its_trace() {
        for (settled, is_above) in [(0.2, true), (0.5, false), (0.8, false)] {
            let points = vec![
                (0.0, 0.0),
                (0.1, 1.0),
                (0.6, settled),
                (1.0, settled + 0.01),
            ];
            let figure = Figure::new("", "", "", vec![Trace::new("", points)]);
            let figure = figure.with_settled_part();
            let frame = Frame {
                left: 0.0,
                top: 0.0,
                width: 200.0,
                height: 80.0,
            };
            let plot = Plot::new(&figure, frame);
            let inset = plot.inset().expect("it is flat");
            let ends = [inset.frame.top, inset.frame.bottom()];
            let [top, bottom] = [settled + 0.01, settled].map(|value| plot.y(value));
            assert!(ends[0] >= 0.0 && ends[1] <= 80.0, "{ends:?}");
            assert_eq!(ends[1] < top, is_above, "{settled}: {ends:?}");
            assert_eq!(ends[0] > bottom, !is_above, "{settled}: {ends:?}");
            // A place has one abscissa in both.
            assert!((inset.x(0.9) - plot.x(0.9)).abs() < 1e-9);
            assert!(inset.y(settled + 0.01) < inset.frame.bottom());
            assert!(inset.y(settled) > inset.frame.top);
        }
    }

    #[test]
    fn names_at_ticks_are_spread_over_lines_where_they_would_lie_on_each_other() {
        let lines = |names: &[&str]| {
            let points = vec![(0.5, 0.0), (names.len() as f64 + 0.5, 0.0)];
            let mut figure = Figure::new("", "", "", vec![Trace::new("", points)]);
            figure.horizontal.names = names.iter().map(ToString::to_string).collect();
            let frame = Frame {
                left: 0.0,
                top: 0.0,
                width: 200.0,
                height: 80.0,
            };
            let plot = Plot::new(&figure, frame);
            let ticks: Vec<_> = plot.horizontal.ticks().collect();
            plot.lines(&ticks)
        };
        assert_eq!(lines(&["a", "b", "coulomb", "load"]), 1);
        let many = [
            "a",
            "b",
            "coulomb",
            "load",
            "gravity-sine",
            "gravity-cosine",
        ];
        assert_eq!(lines(&many), 2);
        let more = [many, many].concat();
        assert_eq!(lines(&more), 3);
    }

    #[test]
    fn undefined_values_are_left_out() {
        let points = [(0.0, f64::NAN), (0.5, 1.0), (1.0, f64::INFINITY)];
        assert_eq!(drawn(&points), [(0.5, 1.0)]);
    }
}
