//! A plot that needs no script: what a printer draws, and a browser that runs none.

use maud::{Markup, html};

use super::ticks;
use super::{Figure, Stroke, Trace};

/// Size of the drawing and of its margins, px before scaling.
const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 250.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = 14.0;
const ABOVE: f64 = 10.0;
const BELOW: f64 = 40.0;

/// Columns of which a trace's lowest and highest point are drawn.
const COLUMNS: f64 = 320.0;

/// Draws it.
#[must_use]
pub(super) fn drawing(figure: &Figure) -> Markup {
    let frame = Frame::of(figure);
    let across = if figure.logarithmic_abscissa {
        ticks::decades(frame.across)
    } else {
        ticks::linear(frame.across, 8.0)
    };
    let up = ticks::linear(frame.up, 5.0);
    let (right, floor) = (WIDTH - RIGHT, HEIGHT - BELOW);
    html! {
        svg.drawing viewBox=(format!("0 0 {WIDTH} {HEIGHT}")) role="img" aria-label=(figure.title) {
            @for stretch in &figure.stretches {
                @let [begin, end] = stretch.extent.map(|place| frame.x(place));
                rect class=(format!("stretch-{}", stretch.colour)) x=(px(begin)) y=(ABOVE)
                    width=(px(end - begin)) height=(floor - ABOVE) {}
            }
            @for (value, text) in &up {
                @let y = px(frame.y(*value));
                line.grid x1=(LEFT) y1=(y) x2=(right) y2=(y) {}
                text x=(LEFT - 6.0) y=(y) dy="0.32em" text-anchor="end" { (text) }
            }
            @for (value, text) in &across {
                @let x = px(frame.x(*value));
                line.grid x1=(x) y1=(ABOVE) x2=(x) y2=(floor) {}
                text x=(x) y=(floor + 15.0) text-anchor="middle" { (text) }
            }
            @for trace in figure.traces.iter().rev() {
                @let class = stroke(trace.stroke);
                @let columns = frame.columns(trace);
                @if columns.iter().any(|point| point.half > 0.0) {
                    path class=(format!("band {class}")) d=(frame.band(&columns)) {}
                }
                path class=(format!("trace {class}")) d=(frame.line(&columns)) {}
            }
            path.frame d=(format!("M{LEFT} {ABOVE}V{floor}H{right}")) {}
            text.axis x=((LEFT + right) / 2.0) y=(HEIGHT - 6.0) text-anchor="middle" { (figure.abscissa) }
        }
    }
}

/// The class of a trace, in drawing and legend.
#[must_use]
pub(super) fn stroke(stroke: Stroke) -> String {
    match stroke {
        Stroke::Colour(colour) => format!("trace-{colour}"),
        Stroke::Dashed => "trace-dashed".to_owned(),
    }
}

/// What is drawn of a trace at a place.
#[derive(Debug, Clone, Copy)]
struct Point {
    place: f64,
    value: f64,
    half: f64,
}

/// Where values lie in the drawing.
#[derive(Debug)]
struct Frame {
    across: (f64, f64),
    up: (f64, f64),
    logarithmic_abscissa: bool,
}

impl Frame {
    fn of(figure: &Figure) -> Self {
        Self {
            across: figure.extent(),
            up: figure.shown(),
            logarithmic_abscissa: figure.logarithmic_abscissa,
        }
    }

    fn x(&self, place: f64) -> f64 {
        LEFT + self.across(place) * (WIDTH - LEFT - RIGHT)
    }

    /// Where a place is between the frame's sides, 0 to 1.
    fn across(&self, place: f64) -> f64 {
        let scale = |place: f64| {
            if self.logarithmic_abscissa {
                place.max(f64::MIN_POSITIVE).log10()
            } else {
                place
            }
        };
        let (begin, end) = (scale(self.across.0), scale(self.across.1));
        (scale(place) - begin) / (end - begin).max(f64::MIN_POSITIVE)
    }

    /// What lies beyond the frame is drawn at its edge.
    fn y(&self, value: f64) -> f64 {
        let (low, high) = self.up;
        let part = (value - low) / (high - low);
        HEIGHT - BELOW - part.clamp(0.0, 1.0) * (HEIGHT - BELOW - ABOVE)
    }

    /// Of each column the lowest and the highest point, in their order.
    fn columns(&self, trace: &Trace) -> Vec<Point> {
        let halves = trace.band.iter().copied().chain(std::iter::repeat(0.0));
        let points = trace.points.iter().zip(halves);
        let points: Vec<Point> = points
            .map(|(&(place, value), half)| Point { place, value, half })
            .collect();
        let column = |point: &Point| (self.across(point.place) * COLUMNS) as i64;
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

    fn line(&self, points: &[Point]) -> String {
        path(
            points
                .iter()
                .map(|point| (self.x(point.place), self.y(point.value))),
        )
    }

    fn band(&self, points: &[Point]) -> String {
        let edge = |sign: f64| {
            move |point: &Point| (self.x(point.place), self.y(point.value + sign * point.half))
        };
        let above = points.iter().map(edge(1.0));
        let below = points.iter().rev().map(edge(-1.0));
        path(above.chain(below)) + "Z"
    }
}

fn path(points: impl Iterator<Item = (f64, f64)>) -> String {
    use std::fmt::Write as _;
    let mut text = String::new();
    for (place, (x, y)) in points.enumerate() {
        let command = if place == 0 { 'M' } else { 'L' };
        // Nothing can fail that is written into memory.
        let _ = write!(text, "{command}{} {}", px(x), px(y));
    }
    text
}

/// A tenth of a pixel is fine enough.
fn px(value: f64) -> f64 {
    (10.0 * value).round() / 10.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is drawn of points.
    fn drawn(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
        let trace = Trace {
            name: String::new(),
            stroke: Stroke::Dashed,
            points: points.to_vec(),
            band: Vec::new(),
        };
        let frame = Frame {
            across: (0.0, 1.0),
            up: (0.0, 1.0),
            logarithmic_abscissa: false,
        };
        let columns = frame.columns(&trace);
        let drawn = columns.into_iter();
        drawn.map(|point| (point.place, point.value)).collect()
    }

    #[test]
    fn a_step_stands_upright_whichever_way_it_goes() {
        let up = [(0.0, 0.0), (0.5, 0.0), (0.5, 1.0), (1.0, 1.0)];
        assert_eq!(drawn(&up), up);
        let down = [(0.0, 1.0), (0.5, 1.0), (0.5, 0.0), (1.0, 0.0)];
        assert_eq!(drawn(&down), down);
    }

    #[test]
    fn what_is_too_dense_to_be_seen_is_drawn_by_its_extremes() {
        let dense: Vec<(f64, f64)> = (0..100_000)
            .map(|step| {
                let place = f64::from(step) * 1e-5;
                (place, (1e4 * place).sin())
            })
            .collect();
        let drawn = drawn(&dense);
        assert!(drawn.len() <= 2 * (COLUMNS as usize + 1), "{}", drawn.len());
        assert!(drawn.is_sorted_by(|one, next| one.0 <= next.0));
        let highest = drawn
            .iter()
            .fold(0.0, |most: f64, &(_, value)| most.max(value));
        assert!(highest > 0.999, "{highest}");
    }
}
