//! Pictures as a paper has them: panels of curves, in the width of a column or a page, as PNG or SVG.

use std::path::Path;

use super::axes::{Axes, LEFT, Row};
use super::canvas::{Align, BLACK, LETTER, Sheet};
use super::legend::{self, Entry};

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
    /// Whether the horizontal axis is logarithmic.
    pub logarithmic_abscissa: bool,
    /// The curves, the first in front.
    pub curves: Vec<Curve>,
    /// A constant to compare with: its name and value.
    pub nominal: Option<(String, f64)>,
    /// The range of the vertical axis; none to fit the curves, up to ticks.
    pub range: Option<(f64, f64)>,
}

/// A line.
#[derive(Debug, Clone)]
pub struct Curve {
    /// Its name in the legend, with the level of its band; none where the panel has only this one.
    pub name: Option<String>,
    /// Places, from zero up, and values, every one of which is drawn: of a long curve an
    /// [`Envelope`](crate::present::Envelope).
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

/// How wide a picture is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Size {
    /// A column of a paper of two, 3.5 inches.
    Column,
    /// A page of such a paper, 7.16 inches.
    #[default]
    Page,
}

impl Size {
    /// Its width, points of 1/72 inch.
    #[must_use]
    pub(super) const fn width(self) -> f64 {
        match self {
            Self::Column => 252.0,
            Self::Page => 516.0,
        }
    }
}

/// Height of the curves of a panel, points.
const HEIGHT: f64 = 82.0;
/// Room between panels side by side, and around the picture.
const BETWEEN: f64 = 10.0;
pub(super) const MARGIN: f64 = 4.0;
/// Height of a title.
const TITLE: f64 = 16.0;

/// Draws panels, row by row, as one picture: the bytes of its file. A column has them one below the other.
/// The last of an odd number is as wide as two.
///
/// # Errors
/// [`PlotError::Drawing`].
pub fn panels(
    format: Format,
    size: Size,
    title: &str,
    columns: usize,
    panels: &[Panel],
) -> Result<Vec<u8>, PlotError> {
    let columns = match size {
        Size::Column => 1,
        Size::Page => columns,
    };
    let axes: Vec<Axes<'_>> = panels
        .iter()
        .map(|panel| Axes::plain(panel, HEIGHT))
        .collect();
    let rows: Vec<&[Axes<'_>]> = axes.chunks(columns).collect();
    let heading = Heading {
        title,
        legend: shared(&axes),
    };
    sheet(size, &heading, &rows).bytes(format)
}

/// What stands above all panels.
#[derive(Debug)]
pub(super) struct Heading<'a> {
    pub(super) title: &'a str,
    /// The legend of all panels; empty where each has its own.
    pub(super) legend: Vec<Entry>,
}

/// The legend of all panels, where those that have one have the same.
fn shared(axes: &[Axes<'_>]) -> Vec<Entry> {
    let legends = axes.iter().map(Axes::legend);
    let legends: Vec<_> = legends.filter(|legend| !legend.is_empty()).collect();
    let words = |legend: &[Entry]| {
        legend
            .iter()
            .map(|entry| entry.words.clone())
            .collect::<Vec<_>>()
    };
    match legends.split_first() {
        Some((first, others)) if !others.is_empty() => {
            let is_same = |other: &Vec<Entry>| words(other) == words(first);
            match others.iter().all(is_same) {
                true => first.clone(),
                false => Vec::new(),
            }
        }
        _ => Vec::new(),
    }
}

/// Rows of panels below a heading, their curves one below the other.
pub(super) fn sheet(size: Size, heading: &Heading<'_>, rows: &[&[Axes<'_>]]) -> Sheet {
    let room = size.width() - 2.0 * MARGIN;
    let wide = |row: &[Axes<'_>]| (room + BETWEEN) / row.len() as f64 - BETWEEN;
    let own = |axes: &Axes<'_>| match heading.legend.is_empty() {
        true => axes.legend(),
        false => Vec::new(),
    };
    let laid: Vec<Row> = rows
        .iter()
        .enumerate()
        .map(|(place, row)| {
            let room = wide(row) - LEFT;
            let lines = row.iter().map(|axes| legend::lines(&own(axes), room));
            let continued = rows.get(place + 1).is_some_and(|below| {
                let mut pairs = below.iter().zip(*row);
                below.len() == row.len() && pairs.all(|(below, above)| below.continues(above))
            });
            Row {
                legend: lines.max().unwrap_or(0),
                abscissa: !continued,
            }
        })
        .collect();
    let tall = |row: &[Axes<'_>]| row.iter().map(|axes| axes.height).fold(0.0, f64::max);
    let title = if heading.title.is_empty() { 0.0 } else { TITLE };
    let lines = legend::lines(&heading.legend, room - LEFT);
    let above = MARGIN + title + lines as f64 * legend::LINE;
    let below: f64 = rows
        .iter()
        .zip(&laid)
        .map(|(row, laid)| laid.height(tall(row)))
        .sum();

    let mut sheet = Sheet::new(size.width(), above + below + MARGIN);
    if !heading.title.is_empty() {
        let at = (MARGIN, MARGIN + 9.0);
        sheet.words(at, heading.title, LETTER + 1, Align::Left, BLACK);
    }
    let at = (MARGIN + LEFT, MARGIN + title);
    legend::draw(&mut sheet, at, room - LEFT, &heading.legend);
    let mut top = above;
    for (row, laid) in rows.iter().zip(laid) {
        let mut left = MARGIN;
        for axes in *row {
            axes.draw(&mut sheet, (left, top), wide(row), laid, &own(axes));
            left += wide(row) + BETWEEN;
        }
        top += laid.height(tall(row));
    }
    sheet
}
