//! Pictures in the style of a paper, in the width of a column or a page, and drawings in pages of HTML. The same
//! [`Canvas`] is written as SVG and as PNG.

mod canvas;
mod font;
mod legend;
mod plot;
mod raster;
mod scale;
mod surface;

use std::path::Path;

pub use canvas::Canvas;
use canvas::LETTER;
use legend::Legend;
use plot::{BELOW, Plot, RIGHT, room_at_left};
use surface::{Align, Frame};

use crate::present::Figure;

/// Number of colours of traces and of stretches.
pub(super) const TRACE_COLOURS: usize = surface::TRACES.len();
pub(super) const SPAN_COLOURS: usize = surface::SPANS.len();

/// Format of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Pixels.
    Png,
    /// Lines.
    Svg,
}

impl Format {
    /// The format that a file's name ends in; none unless it ends in .png or .svg.
    #[must_use]
    pub fn of_file(path: &Path) -> Option<Self> {
        match path.extension().and_then(|end| end.to_str()) {
            Some("png") => Some(Self::Png),
            Some("svg") => Some(Self::Svg),
            _ => None,
        }
    }
}

impl Canvas {
    /// The bytes of a file of this format.
    #[must_use]
    pub fn bytes(&self, format: Format) -> Vec<u8> {
        match format {
            Format::Png => self.png(),
            Format::Svg => self.svg().into_bytes(),
        }
    }
}

/// Width of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "program", derive(clap::ValueEnum))]
pub enum Size {
    /// A column of a paper of two, 3.5 inches.
    Column,
    /// A page of such a paper, 7.16 inches.
    #[default]
    Page,
}

impl Size {
    /// Its width, points of 1/72 inch.
    const fn width(self) -> f64 {
        match self {
            Self::Column => 252.0,
            Self::Page => 516.0,
        }
    }
}

/// Heights of a figure's frame, and of one under shaded ranges of time if several are one below the other, points.
const HEIGHT: f64 = 82.0;
const HEIGHT_UNDER_SPANS: f64 = 62.0;
/// Room between figures side by side, below those whose axis is continued, and around the picture.
const BETWEEN: f64 = 10.0;
const GAP: f64 = 8.0;
const MARGIN: f64 = 4.0;
/// Height of the picture's title, and of a figure's heading.
const TITLE: f64 = 16.0;
const HEADING: f64 = 15.0;

/// Draws figures, row by row, as one picture. A column has them one below the other; the last of an odd number is
/// as wide as two.
#[must_use]
pub fn figures(size: Size, title: &str, columns: usize, figures: &[Figure]) -> Canvas {
    let columns = match size {
        Size::Column => 1,
        Size::Page => columns,
    };
    let room = size.width() - 2.0 * MARGIN;
    let left = room_at_left(figures);
    let shared = Legend::shared(figures);
    let rows: Vec<&[Figure]> = figures.chunks(columns).collect();
    let rows: Vec<Row<'_>> = rows
        .iter()
        .enumerate()
        .map(|(place, row)| Row::new(row, rows.get(place + 1), (left, room), shared.is_none()))
        .collect();
    let legend = shared.unwrap_or_default();
    let title_height = if title.is_empty() { 0.0 } else { TITLE };
    let above = MARGIN + title_height + legend.height(room - left);
    let below: f64 = rows.iter().map(Row::height).sum();

    let mut canvas = Canvas::new(size.width(), above + below + MARGIN);
    if !title.is_empty() {
        let at = (MARGIN, MARGIN + 9.0);
        canvas.text(at, title, LETTER + 1, Align::Left);
    }
    let at = (MARGIN + left, MARGIN + title_height);
    legend.draw(&mut canvas, at, room - left);
    let mut top = above;
    for row in rows {
        row.draw(&mut canvas, top);
        top += row.height();
    }
    canvas
}

/// Figures side by side.
struct Row<'a> {
    figures: &'a [Figure],
    /// Their own legends; empty where they share one.
    legends: Vec<Legend>,
    /// Width of each, its part to the left of the frame, and heights of the highest legend and the highest frame.
    width: f64,
    left: f64,
    legend_height: f64,
    frame_height: f64,
    /// No row below continues the horizontal axis.
    is_lowest: bool,
}

impl<'a> Row<'a> {
    fn new(
        figures: &'a [Figure],
        below: Option<&&[Figure]>,
        (left, room): (f64, f64),
        own_legends: bool,
    ) -> Self {
        let width = (room + BETWEEN) / figures.len() as f64 - BETWEEN;
        let legends = figures.iter().map(|figure| match own_legends {
            true => Legend::of_figure(figure),
            false => Legend::default(),
        });
        let legends: Vec<Legend> = legends.collect();
        let heights = figures
            .iter()
            .map(|figure| match figure.time_spans.is_empty() {
                true => HEIGHT,
                false => HEIGHT_UNDER_SPANS,
            });
        let is_continued = below.is_some_and(|below| {
            let mut pairs = below.iter().zip(figures);
            below.len() == figures.len()
                && pairs.all(|(below, above)| plot::have_one_axis(below, above))
        });
        Self {
            width,
            left,
            legend_height: legends
                .iter()
                .map(|legend| legend.height(width - left))
                .fold(0.0, f64::max),
            frame_height: heights.fold(0.0, f64::max),
            is_lowest: !is_continued,
            figures,
            legends,
        }
    }

    fn height(&self) -> f64 {
        let below = if self.is_lowest { BELOW } else { GAP };
        HEADING + self.legend_height + self.frame_height + below
    }

    fn draw(&self, canvas: &mut Canvas, top: f64) {
        let mut left = MARGIN;
        for (figure, legend) in self.figures.iter().zip(&self.legends) {
            let frame = Frame {
                left: left + self.left,
                top: top + HEADING + self.legend_height,
                width: self.width - self.left - RIGHT,
                height: self.frame_height,
            };
            let plot = Plot::new(figure, frame);
            let at = (left, top + 8.0);
            canvas.text(at, &plot.heading(), LETTER, Align::Left);
            legend.draw(canvas, (frame.left, top + HEADING - 2.0), frame.width);
            plot.draw(canvas, self.is_lowest);
            left += self.width + BETWEEN;
        }
    }
}

/// Draws a figure without heading and legend, which its page has beside it.
#[must_use]
pub fn embedded(figure: &Figure) -> Canvas {
    /// Size of the drawing and room above its frame, points.
    const WIDTH: f64 = 300.0;
    const HEIGHT: f64 = 130.0;
    const ABOVE: f64 = 11.0;
    let mut canvas = Canvas::new(WIDTH, HEIGHT);
    let left = room_at_left([figure]);
    let frame = Frame {
        left,
        top: ABOVE,
        width: WIDTH - left - RIGHT,
        height: HEIGHT - ABOVE - BELOW,
    };
    let plot = Plot::new(figure, frame);
    plot.draw_power(&mut canvas);
    plot.draw(&mut canvas, true);
    canvas
}
