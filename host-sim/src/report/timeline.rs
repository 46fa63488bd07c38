//! Panels over one time, in which the same stretches are shaded and limits are drawn, with one legend
//! beside them all.

use kuva::plot::legend::{LegendEntry, LegendShape};
use kuva::render::annotations::{ReferenceLine, ShadedRegion};
use kuva::render::figure::Figure;

use super::plot::{self, COLOURS, Format, Panel, PlotError};

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
const OPACITY: f64 = 0.35;

const LIMIT: &str = "#000000";
const DASHES: &str = "6 4";

/// Width of a panel, and heights of one that is followed by another over the same time, of the last of
/// these, and of one below, pixels before scaling.
const WIDTH: f64 = 860.0;
const HEIGHTS: [f64; 3] = [170.0, 195.0, 260.0];

/// Margins of a panel: left and right, above, and below where nothing, ticks, or ticks and a name stand.
const SIDES: (f64, f64) = (72.0, 14.0);
const ABOVE: f64 = 10.0;
const BELOW: [f64; 2] = [24.0, 48.0];

/// Draws it: the bytes of its file.
///
/// # Errors
/// [`PlotError::Drawing`].
pub fn timeline(format: Format, timeline: &Timeline) -> Result<Vec<u8>, PlotError> {
    let last = timeline.tracks.len().saturating_sub(1);
    let tracks = timeline.tracks.iter().enumerate().map(|(place, track)| {
        let (plots, layout) = plot::draw(&track.panel);
        let below = BELOW[usize::from(place == last)];
        let mut layout = layout
            .with_force_margins(SIDES.0, SIDES.1)
            .with_force_margins_y(ABOVE, below);
        for stretch in &timeline.stretches {
            let [begin, end] = stretch.time;
            let region = ShadedRegion::vertical(begin, end)
                .with_color(shade(stretch))
                .with_opacity(OPACITY);
            layout = layout.with_shaded_region(region);
        }
        for limit in &track.limits {
            let line = ReferenceLine::horizontal(*limit)
                .with_color(LIMIT)
                .with_dasharray(DASHES);
            layout = layout.with_reference_line(line);
        }
        (plots, layout)
    });
    let below = timeline.below.iter().map(|panel| {
        let (plots, layout) = plot::draw(panel);
        (plots, layout.with_force_margins(SIDES.0, SIDES.1))
    });
    let (plots, layouts): (Vec<_>, Vec<_>) = tracks.chain(below).unzip();
    let mut figure = Figure::new(plots.len(), 1).with_cell_size(WIDTH, HEIGHTS[2]);
    for row in 0..=last {
        figure = figure.with_row_height(row, HEIGHTS[usize::from(row == last)]);
    }
    let scene = figure
        .with_plots(plots)
        .with_layouts(layouts)
        .with_shared_legend_entries(legend(timeline))
        .with_shared_legend_right_top()
        .render();
    plot::bytes(format, &scene)
}

fn shade(stretch: &Shade) -> &'static str {
    SHADES[stretch.colour % SHADES.len()]
}

/// The stretches once each, then the curves by their names, then the limits.
fn legend(timeline: &Timeline) -> Vec<LegendEntry> {
    let entry = |label: &str, colour: &str, shape, dashes: Option<&str>| LegendEntry {
        label: label.to_owned(),
        color: colour.to_owned(),
        shape,
        dasharray: dashes.map(str::to_owned),
    };
    let mut entries: Vec<LegendEntry> = Vec::new();
    for stretch in &timeline.stretches {
        entries.push(entry(
            &stretch.name,
            shade(stretch),
            LegendShape::Rect,
            None,
        ));
    }
    let tracks = timeline.tracks.iter().map(|track| &track.panel);
    for panel in tracks.chain(&timeline.below) {
        for (curve, colour) in panel.curves.iter().zip(COLOURS) {
            if let Some(name) = &curve.name {
                entries.push(entry(name, colour, LegendShape::Line, None));
            }
        }
    }
    entries.push(entry(
        &timeline.limit,
        LIMIT,
        LegendShape::Line,
        Some(DASHES),
    ));
    let mut seen = std::collections::HashSet::new();
    entries.retain(|entry| seen.insert(entry.label.clone()));
    entries
}
