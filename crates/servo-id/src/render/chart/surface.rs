//! The elements of a picture: colours, strokes, labels, and a format that takes them.

/// A colour by its use, so that a page can choose it for light and dark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Colour {
    /// Text, axes and levels.
    Ink,
    /// Ground.
    Paper,
    /// Lines behind traces.
    Grid,
    /// The trace of this number.
    Trace(usize),
    /// The stretch of this number.
    TimeSpan(usize),
}

/// Colours of traces. (Okabe and Ito, "Color universal design", 2008: told apart by colour-blind readers too.)
pub(in crate::render) const TRACES: [[u8; 3]; 4] =
    [[0, 114, 178], [230, 159, 0], [0, 158, 115], [204, 121, 167]];

/// Colours of stretches. (Paul Tol, "Colour schemes", 2021, light: told apart by colour-blind readers, and under
/// lines.)
pub(in crate::render) const SPANS: [[u8; 3]; 9] = [
    [221, 221, 221],
    [238, 136, 102],
    [153, 221, 255],
    [238, 221, 136],
    [187, 204, 51],
    [170, 170, 0],
    [119, 170, 221],
    [255, 170, 187],
    [68, 187, 153],
];

impl Colour {
    /// Its parts in print, and on a page without colours of its own.
    pub(super) fn rgb(self) -> [u8; 3] {
        match self {
            Self::Ink => [0; 3],
            Self::Paper => [255; 3],
            Self::Grid => [228; 3],
            Self::Trace(number) => TRACES[number % TRACES.len()],
            Self::TimeSpan(number) => SPANS[number % SPANS.len()],
        }
    }

    /// Its name in a style sheet.
    pub(super) fn variable(self) -> String {
        match self {
            Self::Ink => "var(--ink)".to_owned(),
            Self::Paper => "var(--paper)".to_owned(),
            Self::Grid => "var(--grid)".to_owned(),
            Self::Trace(number) => format!("var(--trace-{})", number % TRACES.len()),
            Self::TimeSpan(number) => format!("var(--stretch-{})", number % SPANS.len()),
        }
    }

    pub(super) fn hexadecimal(self) -> String {
        let [red, green, blue] = self.rgb();
        format!("#{red:02x}{green:02x}{blue:02x}")
    }
}

/// Alignment of a text at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Align {
    Left,
    Middle,
    Right,
}

/// Style of a line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stroke {
    pub(super) colour: Colour,
    pub(super) width: f64,
    /// Length of a dash and of the gap behind it, points.
    pub(super) dashes: Option<[f32; 2]>,
}

impl Stroke {
    pub(super) const fn solid(colour: Colour, width: f64) -> Self {
        Self {
            colour,
            width,
            dashes: None,
        }
    }
}

/// A part of the canvas.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

impl Frame {
    pub(super) fn right(&self) -> f64 {
        self.left + self.width
    }

    pub(super) fn bottom(&self) -> f64 {
        self.top + self.height
    }
}

/// A text on its base line, in ink.
#[derive(Debug)]
pub(super) struct Label {
    pub(super) at: (f64, f64),
    pub(super) text: String,
    pub(super) size: u32,
    pub(super) align: Align,
}

/// A format that shapes are written in, one after the other.
pub(super) trait Surface {
    fn area(&mut self, path: &str, colour: Colour, opacity: f64);
    fn line(&mut self, path: &str, stroke: Stroke);
    fn text(&mut self, label: &Label);
    /// Cuts the shapes that follow at a frame; none ends that.
    fn cut(&mut self, frame: Option<Frame>);
}
