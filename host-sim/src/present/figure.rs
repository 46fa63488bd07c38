use crate::render::chart::plot::Panel;
use crate::render::chart::timeline::Timeline;

/// A plot: traces over one abscissa. Plots of one abscissa are zoomed together.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// What it shows.
    pub title: String,
    /// Name and unit of the horizontal axis.
    pub abscissa: String,
    /// Name and unit of the vertical axis.
    pub axis: String,
    /// Whether the horizontal axis is logarithmic.
    pub logarithmic_abscissa: bool,
    /// The range of the vertical axis; none to fit the traces.
    pub range: Option<(f64, f64)>,
    /// What the bands of its traces are, where a reader is told.
    pub band: Option<&'static str>,
    /// The traces, the first in front.
    pub traces: Vec<Trace>,
    /// Stretches of the abscissa that have a name.
    pub stretches: Vec<Stretch>,
}

/// A line of a plot.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Its name.
    pub name: String,
    /// How it is drawn.
    pub stroke: Stroke,
    /// Places in ascending order, and values.
    pub points: Vec<(f64, f64)>,
    /// Half-width of the confidence band at each point; empty for none.
    pub band: Vec<f64>,
}

/// How a trace is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stroke {
    /// In the colour of this number.
    Colour(usize),
    /// Dashed, as something to compare with.
    Dashed,
}

/// A stretch of the abscissa.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// Its name.
    pub name: String,
    /// From where to where.
    pub extent: [f64; 2],
    /// The number of its colour.
    pub colour: usize,
}

impl Stroke {
    /// Colours that there are.
    pub const COLOURS: usize = 4;
}

impl Stretch {
    /// Colours that there are.
    pub const COLOURS: usize = 8;
}

impl Figure {
    /// The figure of a panel; where a curve has no name it has that of its axis.
    #[must_use]
    pub fn of(panel: &Panel) -> Self {
        let only = |axis: &str| axis.split(" [").next().unwrap_or(axis).to_owned();
        let mut figure = Self {
            title: panel.title.clone(),
            abscissa: panel.abscissa.clone(),
            axis: panel.axis.clone(),
            logarithmic_abscissa: panel.logarithmic_abscissa,
            range: panel.range,
            band: None,
            traces: panel
                .curves
                .iter()
                .enumerate()
                .map(|(place, curve)| Trace {
                    name: curve.name.clone().unwrap_or_else(|| only(&panel.axis)),
                    stroke: Stroke::Colour(place % Stroke::COLOURS),
                    points: curve.points.clone(),
                    band: if curve.band.len() == curve.points.len() {
                        curve.band.clone()
                    } else {
                        Vec::new()
                    },
                })
                .collect(),
            stretches: Vec::new(),
        };
        if let Some((name, value)) = &panel.nominal {
            figure.compare_with(name, *value);
        }
        figure
    }

    /// The figures of panels over stretches of time, then those below.
    #[must_use]
    pub fn of_timeline(timeline: &Timeline, titles: &[&str]) -> Vec<Self> {
        let stretches: Vec<Stretch> = timeline
            .stretches
            .iter()
            .map(|shade| Stretch {
                name: shade.name.clone(),
                extent: shade.time,
                colour: shade.colour % Stretch::COLOURS,
            })
            .collect();
        let tracks = timeline.tracks.iter().zip(titles).map(|(track, title)| {
            let mut figure = Self::of(&track.panel);
            figure.title = (*title).to_owned();
            figure.abscissa = crate::render::chart::plot::TIME.to_owned();
            figure.stretches.clone_from(&stretches);
            for limit in &track.limits {
                figure.compare_with(&timeline.limit, *limit);
            }
            figure
        });
        tracks.chain(timeline.below.iter().map(Self::of)).collect()
    }

    /// The figure of an estimate, which has a band of 95 % and shows how it comes to rest: where it began it may
    /// have been so far off that nothing else would be seen.
    #[must_use]
    pub(crate) fn of_estimate(self) -> Self {
        /// The part of its course that is not looked at, and the room around the rest.
        const BEGINNING: f64 = 0.1;
        const ROOM: f64 = 0.2;
        /// The least that is shown, a part of the estimate.
        const LEAST: f64 = 1e-3;
        let (begin, end) = self.extent();
        let from = begin + BEGINNING * (end - begin);
        let points = self.traces.iter().flat_map(|trace| &trace.points);
        let (low, high) = points.filter(|(place, _)| *place >= from).fold(
            (f64::INFINITY, f64::NEG_INFINITY),
            |(low, high), (_, value)| (low.min(*value), high.max(*value)),
        );
        let room = ROOM * (high - low).max(LEAST * high.abs());
        let is_known = room > 0.0 && room.is_finite();
        Self {
            range: if is_known {
                Some((low - room, high + room))
            } else {
                self.range
            },
            band: Some("95 %"),
            ..self
        }
    }

    /// Adds a constant to compare with.
    fn compare_with(&mut self, name: &str, value: f64) {
        let (begin, end) = self.extent();
        self.traces.push(Trace {
            name: name.to_owned(),
            stroke: Stroke::Dashed,
            points: vec![(begin, value), (end, value)],
            band: Vec::new(),
        });
    }

    /// From where to where its traces go along the abscissa.
    #[must_use]
    pub fn extent(&self) -> (f64, f64) {
        let mut places = self
            .traces
            .iter()
            .flat_map(|trace| [trace.points.first(), trace.points.last()])
            .flatten()
            .map(|(place, _)| *place);
        let first = places.next().unwrap_or(0.0);
        places.fold((first, first), |(low, high), place| {
            (low.min(place), high.max(place))
        })
    }

    /// What its vertical axis shows: the range that is stated, or else that of the traces with some
    /// room.
    #[must_use]
    pub fn shown(&self) -> (f64, f64) {
        /// Room above and below, a part of the range.
        const ROOM: f64 = 0.06;
        if let Some(range) = self.range {
            return range;
        }
        let values = self.traces.iter().flat_map(|trace| &trace.points);
        let (low, high) = values
            .map(|(_, value)| *value)
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
        match (low, high) {
            _ if low > high => (0.0, 1.0),
            _ if high - low > 1e-12 * high.abs() => {
                let room = ROOM * (high - low);
                (low - room, high + room)
            }
            _ => (
                low - 0.1 * low.abs().max(1.0),
                high + 0.1 * high.abs().max(1.0),
            ),
        }
    }
}
