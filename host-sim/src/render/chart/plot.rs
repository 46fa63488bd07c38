//! A figure in its frame: grid, stretches, traces and axes.

use super::canvas::{Align, Canvas, Colour, Frame, SMALL, Stroke};
use super::scale::Scale;
use crate::present::{Figure, Trace};

/// Room of what is written to the left of the frame, to its right and below it, points.
pub(super) const LEFT: f64 = 30.0;
pub(super) const RIGHT: f64 = 9.0;
pub(super) const BELOW: f64 = 27.0;

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
pub(super) const STRETCH_OPACITY: f64 = 0.35;

/// Widths of traces in their order, points: one that lies under the first is seen beside it.
const WIDTHS: [f64; 4] = [0.7, 1.4, 2.2, 0.7];

/// Length of a tick.
const TICK: f64 = 2.5;

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

    /// The power of ten of the figures at the vertical axis, to be written above it where no heading has it.
    pub(super) fn draw_power(&self, canvas: &mut Canvas) {
        if let Some(power) = self.vertical.power() {
            let at = (self.frame.left, self.frame.top - 3.0);
            canvas.text(at, &format!("× {power}"), SMALL, Align::Left, Colour::Ink);
        }
    }

    /// Draws it; `is_lowest` where no figure below has the same horizontal axis.
    pub(super) fn draw(&self, canvas: &mut Canvas, is_lowest: bool) {
        self.ground(canvas);
        canvas.inside(self.frame, |canvas| self.traces(canvas));
        self.axes(canvas, is_lowest);
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
        for stretch in &self.figure.stretches {
            let inside = |place| self.x(place).clamp(frame.left, frame.right());
            let [left, right] = stretch.extent.map(inside);
            let part = Frame {
                left,
                width: right - left,
                ..frame
            };
            canvas.rectangle(part, Colour::Stretch(stretch.colour), STRETCH_OPACITY);
        }
        for (part, _) in self.vertical.ticks() {
            let y = frame.bottom() - part * frame.height;
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

    fn axes(&self, canvas: &mut Canvas, is_lowest: bool) {
        let Frame { left, top, .. } = self.frame;
        let (right, bottom) = (self.frame.right(), self.frame.bottom());
        canvas.curve([(left, top), (left, bottom), (right, bottom)], AXIS);
        for (part, text) in self.vertical.ticks() {
            let y = bottom - part * self.frame.height;
            canvas.line((left - TICK, y), (left, y), AXIS);
            let at = (left - TICK - 2.0, y + 2.5);
            canvas.text(at, &text, SMALL, Align::Right, Colour::Ink);
        }
        for (part, text) in self.horizontal.ticks() {
            let x = left + part * self.frame.width;
            canvas.line((x, bottom), (x, bottom + TICK), AXIS);
            if is_lowest {
                let at = (x, bottom + TICK + 7.5);
                canvas.text(at, &text, SMALL, Align::Middle, Colour::Ink);
            }
        }
        if is_lowest {
            let at = (0.5 * (left + right), bottom + 20.0);
            let name = self.horizontal.named(&self.figure.horizontal.name);
            canvas.text(at, &name, super::canvas::LETTER, Align::Middle, Colour::Ink);
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
    match figure.horizontal.is_logarithmic && first > 0.0 {
        true => Scale::decades(first, last),
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
    fn undefined_values_are_left_out() {
        let points = [(0.0, f64::NAN), (0.5, 1.0), (1.0, f64::INFINITY)];
        assert_eq!(drawn(&points), [(0.5, 1.0)]);
    }
}
