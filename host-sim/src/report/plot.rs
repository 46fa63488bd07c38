//! Pictures: lines over time in panels, as PNG or SVG.

use std::path::Path;

use kuva::backend::png::PngBackend;
use kuva::backend::svg::SvgBackend;
use kuva::plot::{Heatmap, LegendPosition, LinePlot};
use kuva::render::figure::Figure;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::Scene;

/// The horizontal axis of what happens over time.
pub const TIME: &str = "time [s]";

/// One panel: curves, perhaps with a line to compare them to.
#[derive(Debug, Clone)]
pub struct Panel {
    /// Its title.
    pub title: String,
    /// Name and unit of the horizontal axis.
    pub abscissa: String,
    /// Name and unit of the vertical axis.
    pub axis: String,
    /// Whether the vertical axis is logarithmic.
    pub logarithmic: bool,
    /// The curves, the first in front.
    pub curves: Vec<Curve>,
    /// A constant to compare with: its name and value.
    pub nominal: Option<(String, f64)>,
    /// The range of the vertical axis; none to fit the curves.
    pub range: Option<(f64, f64)>,
}

/// A line.
#[derive(Debug, Clone)]
pub struct Curve {
    /// Its name in the legend; none where the panel has only this one.
    pub name: Option<String>,
    /// Places, from zero up, and values, every one of which is drawn: of a long curve an
    /// [`Envelope`](super::Envelope).
    pub points: Vec<(f64, f64)>,
    /// Half-width of the confidence band at each point; empty for none.
    pub band: Vec<f64>,
}

/// Why there is no picture.
#[derive(Debug)]
pub enum PlotError {
    /// The name ends neither in .png nor in .svg.
    Format,
    /// The picture could not be drawn.
    Drawing(String),
}

impl std::fmt::Display for PlotError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Format => f.write_str("a picture's name must end in .png or .svg"),
            Self::Drawing(error) => write!(f, "the picture could not be drawn: {error}"),
        }
    }
}

impl std::error::Error for PlotError {}

/// Size of a panel, pixels before scaling.
const PANEL: (f64, f64) = (560.0, 250.0);

/// Size of a grid, likewise.
const GRID: (f64, f64) = (760.0, 480.0);

/// Scale of a PNG against the size of its panels.
const PNG_SCALE: f32 = 1.5;

/// Colours of the curves, in their order; the line to compare with is black. (Okabe and Ito, "Color
/// universal design", 2008: told apart by colour-blind readers too.)
pub(super) const COLOURS: [&str; 4] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7"];
const NOMINAL: &str = "#000000";

/// What a picture is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Pixels.
    Png,
    /// Lines.
    Svg,
}

impl Format {
    /// The format that a file's name ends in.
    ///
    /// # Errors
    /// [`PlotError::Format`] unless it ends in .png or .svg.
    pub fn of(path: &Path) -> Result<Self, PlotError> {
        match path.extension().and_then(|end| end.to_str()) {
            Some("png") => Ok(Self::Png),
            Some("svg") => Ok(Self::Svg),
            _ => Err(PlotError::Format),
        }
    }
}

/// Draws panels, row by row, as one picture: the bytes of its file.
///
/// # Errors
/// [`PlotError::Drawing`].
pub fn panels(
    format: Format,
    title: &str,
    columns: usize,
    panels: &[Panel],
) -> Result<Vec<u8>, PlotError> {
    let rows = panels.len().div_ceil(columns);
    let (plots, layouts): (Vec<_>, Vec<_>) = panels.iter().map(draw).unzip();
    let scene = Figure::new(rows, columns)
        .with_plots(plots)
        .with_layouts(layouts)
        .with_title(title)
        .with_cell_size(PANEL.0, PANEL.1)
        .render();
    bytes(format, &scene)
}

/// A table of values as colours.
#[derive(Debug, Clone)]
pub struct Grid {
    /// Its title.
    pub title: String,
    /// Names of the rows, from the top.
    pub rows: Vec<String>,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// The values, row by row.
    pub values: Vec<Vec<f64>>,
}

/// Draws grids side by side as one picture: the bytes of its file.
///
/// # Errors
/// [`PlotError::Drawing`].
pub fn grids(format: Format, grids: &[Grid]) -> Result<Vec<u8>, PlotError> {
    let (plots, layouts): (Vec<_>, Vec<_>) = grids
        .iter()
        .map(|grid| {
            // The lowest row is the first to be drawn.
            let upwards: Vec<String> = grid.rows.iter().rev().cloned().collect();
            // One digit is what the eye can take in of a colour.
            let rounded = grid.values.iter().rev().map(|row| {
                row.iter()
                    .map(|value| (value * 10.0).round() / 10.0 + 0.0)
                    .collect()
            });
            let heatmap = Heatmap::new()
                .with_data::<f64, Vec<f64>, _>(rounded)
                .with_values()
                .with_labels(upwards.clone(), grid.columns.clone());
            let plots = vec![Plot::Heatmap(heatmap)];
            let layout = Layout::auto_from_plots(&plots)
                .with_title(grid.title.clone())
                .with_x_categories(grid.columns.clone())
                .with_y_categories(upwards)
                .with_x_tick_rotate(-30.0)
                .with_title_size(13)
                .with_tick_size(11);
            (plots, layout)
        })
        .unzip();
    let scene = Figure::new(1, grids.len())
        .with_plots(plots)
        .with_layouts(layouts)
        .with_cell_size(GRID.0, GRID.1)
        .render();
    bytes(format, &scene)
}

pub(super) fn bytes(format: Format, scene: &Scene) -> Result<Vec<u8>, PlotError> {
    match format {
        Format::Png => PngBackend::new()
            .with_scale(PNG_SCALE)
            .render_scene(scene)
            .map_err(PlotError::Drawing),
        Format::Svg => Ok(SvgBackend::new()
            .with_embedded_font(true)
            .render_scene(scene)
            .into_bytes()),
    }
}

pub(super) fn draw(panel: &Panel) -> (Vec<Plot>, Layout) {
    let mut plots = Vec::new();
    let end = panel
        .curves
        .iter()
        .filter_map(|curve| curve.points.last())
        .fold(0.0_f64, |end, point| end.max(point.0));
    for (k, curve) in panel.curves.iter().enumerate().rev() {
        let colour = COLOURS[k % COLOURS.len()];
        let inside = |value: f64| match panel.range {
            Some((low, high)) => value.clamp(low, high),
            None => value,
        };
        let points = curve.points.iter().map(|&(x, y)| (x, inside(y)));
        let mut line = LinePlot::new()
            .with_data(points)
            .with_color(colour)
            .with_stroke_width(1.4);
        if curve.band.len() == curve.points.len() && !curve.band.is_empty() {
            let edge = |sign: f64| {
                let edges = curve.points.iter().zip(&curve.band);
                edges
                    .map(|((_, value), half)| inside(value + sign * half))
                    .collect::<Vec<f64>>()
            };
            line = line.with_band(edge(-1.0), edge(1.0));
        }
        if let Some(name) = &curve.name {
            line = line.with_legend(name.clone());
        }
        plots.push(Plot::Line(line));
    }
    if let Some((name, value)) = &panel.nominal {
        let line = LinePlot::new()
            .with_data([(0.0, *value), (end, *value)])
            .with_color(NOMINAL)
            .with_stroke_width(1.2)
            .with_dashed()
            .with_legend(name.clone());
        plots.push(Plot::Line(line));
    }
    let mut layout = Layout::auto_from_plots(&plots)
        .with_title(panel.title.clone())
        .with_x_label(panel.abscissa.clone())
        .with_y_label(panel.axis.clone())
        .with_x_axis_min(0.0)
        .with_x_axis_max(end)
        .with_title_size(13)
        .with_label_size(12)
        .with_tick_size(11)
        .with_legend_position(LegendPosition::InsideTopRight);
    if panel.logarithmic {
        layout = layout.with_log_y();
    }
    if let Some((low, high)) = panel.range {
        layout = layout.with_y_axis_min(low).with_y_axis_max(high);
    }
    (plots, layout)
}
