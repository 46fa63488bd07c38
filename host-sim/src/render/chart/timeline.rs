//! Panels over one time, in which the same stretches are shaded and limits are drawn, with one legend
//! above them all.

use super::axes::Axes;
use super::canvas::{BLACK, Stroke};
use super::legend::{Entry, Mark};
use super::plot::{self, Format, Heading, Panel, PlotError, Size};

/// A picture of what happens in stretches of time.
#[derive(Debug, Clone)]
pub struct Timeline {
    /// The stretches, in their order.
    pub stretches: Vec<Shade>,
    /// What is drawn over them.
    pub tracks: Vec<Track>,
    /// What the dashed lines of the tracks are called.
    pub limit: String,
    /// Panels below, over a time of their own.
    pub below: Vec<Panel>,
}

/// A stretch of time with a name.
#[derive(Debug, Clone)]
pub struct Shade {
    /// Its name.
    pub name: String,
    /// From when to when, s.
    pub time: [f64; 2],
    /// Its place among the colours of stretches.
    pub colour: usize,
}

/// A panel with the limits that its curves keep.
#[derive(Debug, Clone)]
pub struct Track {
    /// The panel.
    pub panel: Panel,
    /// The limits.
    pub limits: Vec<f64>,
}

/// Colours of the stretches. (Paul Tol, "Colour schemes", 2021, light: told apart by colour-blind readers,
/// and under lines.)
const SHADES: [&str; 8] = [
    "#DDDDDD", "#EE8866", "#99DDFF", "#EEDD88", "#BBCC33", "#77AADD", "#FFAABB", "#44BB99",
];

/// How much of a shade is seen.
pub(super) const OPACITY: f64 = 0.35;

/// A limit.
pub(super) const LIMIT: Stroke = Stroke {
    colour: BLACK,
    width: 0.7,
    dashes: Some((4.0, 2.5)),
};

/// Heights of the curves of a panel over the stretches, and of one below, points.
const HEIGHTS: [f64; 2] = [62.0, 96.0];

/// Draws it: the bytes of its file.
///
/// # Errors
/// [`PlotError::Drawing`].
pub fn timeline(format: Format, size: Size, timeline: &Timeline) -> Result<Vec<u8>, PlotError> {
    let tracks = timeline.tracks.iter().map(|track| Axes {
        panel: &track.panel,
        stretches: &timeline.stretches,
        limits: &track.limits,
        height: HEIGHTS[0],
    });
    let below = timeline
        .below
        .iter()
        .map(|panel| Axes::plain(panel, HEIGHTS[1]));
    let axes: Vec<Axes<'_>> = tracks.chain(below).collect();
    let rows: Vec<&[Axes<'_>]> = axes.chunks(1).collect();
    let heading = Heading {
        title: "",
        legend: legend(timeline, &axes),
    };
    plot::sheet(size, &heading, &rows).bytes(format)
}

pub(super) fn shade(stretch: &Shade) -> &'static str {
    SHADES[stretch.colour % SHADES.len()]
}

/// The stretches once each, then the curves by their names, then the limits.
fn legend(timeline: &Timeline, axes: &[Axes<'_>]) -> Vec<Entry> {
    let stretches = timeline.stretches.iter().map(|stretch| Entry {
        mark: Mark::Area(shade(stretch), OPACITY),
        words: stretch.name.clone(),
    });
    let mut entries: Vec<Entry> = stretches.collect();
    entries.extend(axes.iter().flat_map(Axes::legend));
    entries.push(Entry {
        mark: Mark::Line(LIMIT),
        words: timeline.limit.clone(),
    });
    let mut seen = std::collections::HashSet::new();
    entries.retain(|entry| seen.insert(entry.words.clone()));
    entries
}
