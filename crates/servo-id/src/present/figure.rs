//! Figures of a result, each described once. Pictures draw this description, pages embed the drawing, and the script of
//! a page reads the description as JSON.

use serde::Serialize;

/// The horizontal axis of a course in time.
pub const TIME: &str = "time [s]";

/// Traces over one horizontal axis. Figures of the same horizontal axis are zoomed together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// Title; may be empty.
    pub title: String,
    /// The horizontal axis.
    pub horizontal: Axis,
    /// The vertical axis.
    pub vertical: Axis,
    /// The traces, the first in front.
    pub traces: Vec<Trace>,
    /// Constants to compare the traces with.
    pub levels: Vec<Level>,
    /// Named stretches of the horizontal axis.
    #[serde(rename = "stretches")]
    pub time_spans: Vec<TimeSpan>,
    /// The settled part, which has a scale of its own where it would be a flat line on the whole's.
    pub settled: Option<Settled>,
}

/// The settled part of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Settled {
    /// Its begin on the horizontal axis; it lasts to the end.
    pub from: f64,
    /// The range of its values, bands and levels, with room around it.
    pub range: [f64; 2],
}

/// An axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Axis {
    /// Name and unit, as `ε [rad]`.
    pub name: String,
    /// Logarithmic, where all places are positive; else linear.
    pub is_logarithmic: bool,
    /// The range that is shown; none to fit the traces.
    pub range: Option<[f64; 2]>,
    /// The names of its places 1, 2 and so on; none where places are numbers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub names: Vec<String>,
}

/// A line.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trace {
    /// Name, with the meaning of its band.
    pub name: String,
    /// Places in ascending order, and values.
    pub points: Vec<(f64, f64)>,
    /// Half-width of the confidence band at each point; empty for none.
    pub band: Vec<f64>,
}

/// A constant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Level {
    /// Name.
    pub name: String,
    /// Value on the vertical axis.
    pub value: f64,
}

/// A stretch of the horizontal axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TimeSpan {
    /// Name.
    pub name: String,
    /// Begin and end.
    pub extent: [f64; 2],
    /// Number of its colour.
    pub colour: usize,
}

impl Figure {
    /// Traces over linear axes that fit them.
    #[must_use]
    pub fn new(title: &str, horizontal: &str, vertical: &str, traces: Vec<Trace>) -> Self {
        Self {
            title: title.to_owned(),
            horizontal: Axis::new(horizontal),
            vertical: Axis::new(vertical),
            traces,
            levels: Vec::new(),
            time_spans: Vec::new(),
            settled: None,
        }
    }

    /// With this range of the vertical axis.
    #[must_use]
    pub fn within(mut self, range: Option<[f64; 2]>) -> Self {
        self.vertical.range = range;
        self
    }

    /// With a vertical axis from zero to somewhat beyond the highest value and level, whatever the bands are.
    #[must_use]
    pub fn from_zero(mut self) -> Self {
        /// Room above the highest value, a part of it.
        const ROOM: f64 = 0.1;
        let highest = self.values().map_or(1.0, |(_, high)| high);
        self.vertical.range = Some([0.0, (1.0 + ROOM) * highest]);
        self
    }

    /// With a constant to compare with.
    #[must_use]
    pub fn with_level(mut self, name: &str, value: f64) -> Self {
        let name = name.to_owned();
        self.levels.push(Level { name, value });
        self
    }

    /// With a separate scale for the second half, if it would be only a line on the scale of the whole.
    #[must_use]
    pub fn with_settled_part(mut self) -> Self {
        /// Part of the whole range from which on the settled part can be seen without a scale of its own.
        const MAX_SHARE: f64 = 1.0 / 6.0;
        /// Part below which it is a constant but for rounding.
        const MIN_SHARE: f64 = 1e-9;
        /// Room above and below, a part of its range.
        const ROOM: f64 = 0.15;
        let (first, last) = self.extent();
        let from = 0.5 * (first + last);
        let edges = self.traces.iter().flat_map(|trace| {
            let bands = trace.band.iter().copied().chain(std::iter::repeat(0.0));
            let settled = trace.points.iter().zip(bands);
            let settled = settled.filter(move |((place, _), _)| *place >= from);
            settled.flat_map(|(&(_, value), half)| {
                let half = if half.is_finite() { half } else { 0.0 };
                [value - half, value + half]
            })
        });
        let levels = self.levels.iter().map(|level| level.value);
        let settled = range_of(edges.chain(levels));
        let whole = self.vertical.range.map(|[low, high]| (low, high));
        self.settled = settled
            .zip(whole.or_else(|| self.values()))
            .filter(|((low, high), whole)| {
                let length = high - low;
                let share = length / (whole.1 - whole.0);
                (MIN_SHARE..MAX_SHARE).contains(&share)
            })
            .map(|((low, high), _)| {
                let room = ROOM * (high - low);
                let range = [low - room, high + room];
                Settled { from, range }
            });
        self
    }

    /// The first and the last place of its traces.
    #[must_use]
    pub fn extent(&self) -> (f64, f64) {
        let ends = |trace: &Trace| [trace.points.first().copied(), trace.points.last().copied()];
        let places = self.traces.iter().flat_map(ends).flatten();
        range_of(places.map(|(place, _)| place)).unwrap_or((0.0, 0.0))
    }

    /// The lowest and the highest value of its traces and levels; none where there is none.
    #[must_use]
    pub fn values(&self) -> Option<(f64, f64)> {
        let points = self.traces.iter().flat_map(|trace| &trace.points);
        let levels = self.levels.iter().map(|level| level.value);
        range_of(points.map(|(_, value)| *value).chain(levels))
    }

    /// The same with numbers as short as they may be without a difference that can be seen.
    #[must_use]
    pub fn shortened(&self) -> Self {
        let (begin, end) = self.extent();
        let place = match self.horizontal.is_logarithmic {
            true => Rounding::NONE,
            false => Rounding::to_range(end - begin),
        };
        let shown = self.vertical.range.map(|[low, high]| (low, high));
        let (low, high) = shown.or_else(|| self.values()).unwrap_or((0.0, 0.0));
        let value = match self.settled {
            Some(Settled {
                range: [low, high], ..
            }) => Rounding::to_range(100.0 * (high - low)),
            None => Rounding::to_range(high - low),
        };
        let mut short = self.clone();
        for trace in &mut short.traces {
            for point in &mut trace.points {
                *point = (place.apply(point.0), value.apply(point.1));
            }
            for half_width in &mut trace.band {
                *half_width = value.apply(*half_width);
            }
        }
        short
    }
}

impl Axis {
    fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            is_logarithmic: false,
            range: None,
            names: Vec::new(),
        }
    }
}

impl Trace {
    /// A line without a band.
    #[must_use]
    pub fn new(name: &str, points: Vec<(f64, f64)>) -> Self {
        Self {
            name: name.to_owned(),
            points,
            band: Vec::new(),
        }
    }
}

/// The lowest and the highest finite value.
fn range_of(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values
        .filter(|value| value.is_finite())
        .map(|value| (value, value))
        .reduce(|(low, high), (value, _)| (low.min(value), high.max(value)))
}

/// Decimal places that are kept.
#[derive(Debug, Clone, Copy)]
struct Rounding {
    /// A power of ten; infinite where all are kept.
    scale: f64,
}

impl Rounding {
    const NONE: Self = Self {
        scale: f64::INFINITY,
    };

    /// Enough to resolve a range far more finely than a zoomed figure has pixels.
    fn to_range(range: f64) -> Self {
        const RESOLVED_PARTS: f64 = 1e6;
        if range > 0.0 && range.is_finite() {
            Self {
                scale: 10_f64.powf((RESOLVED_PARTS / range).log10().ceil()),
            }
        } else {
            Self::NONE
        }
    }

    fn apply(self, value: f64) -> f64 {
        let scaled = value * self.scale;
        if scaled.is_finite() {
            scaled.round() / self.scale
        } else {
            value
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_undefined_ones_are_null() {
        let mut trace = Trace::new("", vec![(0.0, 1.0 / 3.0), (60.0, 5000.0 / 3.0)]);
        trace.band = vec![f64::INFINITY, 0.012_345_678_9];
        let figure = Figure::new("", TIME, "", vec![trace]).within(Some([0.2, 0.3]));
        let text = serde_json::to_string(&figure.shortened()).expect("JSON");
        assert!(
            text.contains(r#""points":[[0.0,0.3333333],[60.0,1666.6666667]]"#),
            "{text}"
        );
        assert!(text.contains(r#""band":[null,0.0123457]"#), "{text}");
    }

    #[test]
    fn a_settled_part_has_a_scale_of_its_own_where_it_would_be_a_line() {
        let points = [(0.0, 0.0), (1.0, 100.0), (6.0, 101.0), (10.0, 99.0)];
        let mut trace = Trace::new("", points.to_vec());
        trace.band = vec![50.0, 50.0, 1.0, f64::INFINITY];
        let figure = Figure::new("", TIME, "", vec![trace.clone()]).with_level("true", 98.0);
        let settled = figure.with_settled_part().settled;
        assert_eq!(settled.map(|settled| settled.from), Some(5.0));
        let [low, high] = settled.expect("it is flat").range;
        assert!((low - 97.4).abs() < 1e-12 && (high - 102.6).abs() < 1e-12);
        let seen = Figure::new("", TIME, "", vec![trace.clone()]).within(Some([92.0, 108.0]));
        assert_eq!(seen.with_settled_part().settled, None);
        let constant = Trace::new("", vec![(0.0, 1.0), (1.0, 1.0)]);
        let constant = Figure::new("", TIME, "", vec![constant]).with_settled_part();
        assert_eq!(constant.settled, None);
    }

    #[test]
    fn a_range_counts_levels_and_leaves_undefined_values_out() {
        let trace = Trace::new("", vec![(0.5, f64::NAN), (1.0, 3.0), (2.0, 1.0)]);
        let figure = Figure::new("", TIME, "", vec![trace]).with_level("limit", 7.0);
        assert_eq!(figure.values(), Some((1.0, 7.0)));
        assert_eq!(figure.extent(), (0.5, 2.0));
    }
}
