//! Lines, areas and text on a canvas, written as SVG or, from the same paths, as PNG. Lengths are points, 1/72
//! inch, from the upper left corner.

use std::fmt::Write as _;

use super::font;
use super::raster::Pixels;
use super::surface::{Align, Colour, Frame, Label, Stroke, Surface};
use crate::program;

/// Font size, points.
pub(super) const LETTER: u32 = 8;
/// Font size at ticks and in legends, points.
pub(super) const SMALL: u32 = 7;
/// Font size where there is little room, points.
pub(super) const TINY: u32 = 6;

/// A shape; paths are those of SVG.
#[derive(Debug)]
enum Shape {
    Area {
        path: String,
        colour: Colour,
        opacity: f64,
    },
    Line {
        path: String,
        stroke: Stroke,
    },
    Text(Label),
    /// Shapes that are cut at a frame.
    Cut(Frame, Vec<Shape>),
}

fn write(shapes: &[Shape], surface: &mut impl Surface) {
    for shape in shapes {
        match shape {
            Shape::Area {
                path,
                colour,
                opacity,
            } => surface.area(path, *colour, *opacity),
            Shape::Line { path, stroke } => surface.line(path, *stroke),
            Shape::Text(label) => surface.text(label),
            Shape::Cut(frame, shapes) => {
                surface.cut(Some(*frame));
                write(shapes, surface);
                surface.cut(None);
            }
        }
    }
}

/// A drawing of a width and a height.
#[derive(Debug)]
pub struct Canvas {
    pub(super) width: f64,
    pub(super) height: f64,
    shapes: Vec<Shape>,
}

impl Canvas {
    pub(super) fn new(width: f64, height: f64) -> Self {
        Self {
            width,
            height,
            shapes: Vec::new(),
        }
    }

    /// Text on a base line. A circumflex on a tall letter is drawn above it, because the font's own would cross it.
    pub(super) fn text(&mut self, (x, y): (f64, f64), text: &str, size: u32, align: Align) {
        /// Distance of such a circumflex above its usual place, and half its width, in font sizes.
        const RAISED: f64 = 0.22;
        const HALF_WIDTH: f64 = 0.25;
        let left = x - font::width(text, size) * align.part();
        let mut plain = String::new();
        for letter in text.chars() {
            if letter == font::CIRCUMFLEX && plain.ends_with(['b', 'd']) {
                let behind = font::width(&plain, size);
                let letter = behind - font::width(&plain[..plain.len() - 1], size);
                let to_middle = behind - 0.5 * letter - HALF_WIDTH * f64::from(size);
                let at = (left + to_middle, y - RAISED * f64::from(size));
                self.plain_text(at, "ˆ".to_owned(), size, Align::Left);
            } else {
                plain.push(letter);
            }
        }
        self.plain_text((x, y), plain, size, align);
    }

    fn plain_text(&mut self, at: (f64, f64), text: String, size: u32, align: Align) {
        self.shapes.push(Shape::Text(Label {
            at,
            text,
            size,
            align,
        }));
    }

    pub(super) fn line(&mut self, from: (f64, f64), to: (f64, f64), stroke: Stroke) {
        self.curve([from, to], stroke);
    }

    pub(super) fn curve(&mut self, points: impl IntoIterator<Item = (f64, f64)>, stroke: Stroke) {
        let path = path(points);
        self.shapes.push(Shape::Line { path, stroke });
    }

    /// The area that a line around it encloses.
    pub(super) fn area(
        &mut self,
        outline: impl IntoIterator<Item = (f64, f64)>,
        colour: Colour,
        opacity: f64,
    ) {
        self.shapes.push(Shape::Area {
            path: path(outline) + "Z",
            colour,
            opacity,
        });
    }

    pub(super) fn rectangle(&mut self, frame: Frame, colour: Colour, opacity: f64) {
        let (left, right) = (frame.left, frame.right());
        let (top, bottom) = (frame.top, frame.bottom());
        let outline = [(left, top), (right, top), (right, bottom), (left, bottom)];
        self.area(outline, colour, opacity);
    }

    /// Draws shapes that are cut at a frame.
    pub(super) fn inside(&mut self, frame: Frame, draw: impl FnOnce(&mut Self)) {
        let outside = std::mem::take(&mut self.shapes);
        draw(self);
        let inside = std::mem::replace(&mut self.shapes, outside);
        self.shapes.push(Shape::Cut(frame, inside));
    }

    /// The bytes of a file of SVG at its intended size. A length without unit would be in pixels, 1/96 inch.
    #[must_use]
    pub fn svg(&self) -> String {
        let (width, height) = (self.width, self.height);
        let body = self.on(Svg::new("frame", Colour::hexadecimal)).text;
        format!(
            r##"<svg xmlns="http://www.w3.org/2000/svg" width="{width}pt" height="{height}pt" viewBox="0 0 {width} {height}" font-family="{FONTS}"><metadata>{NAME}</metadata><rect width="100%" height="100%" fill="#ffffff"/>{body}</svg>
"##,
            FONTS = font::FAMILIES,
            NAME = program::NAME
        )
    }

    /// The same for a page, which has the colours and the font in its style sheet. `name` is unlike those of the other
    /// drawings.
    #[must_use]
    pub fn embedded_svg(&self, name: &str, title: &str) -> String {
        let (width, height) = (self.width, self.height);
        let body = self.on(Svg::new(name, Colour::variable)).text;
        let title = escaped(title);
        format!(
            r#"<svg class="drawing" viewBox="0 0 {width} {height}" role="img" aria-label="{title}">{body}</svg>"#
        )
    }

    /// The bytes of a file of PNG.
    #[must_use]
    pub fn png(&self) -> Vec<u8> {
        self.on(Pixels::new(self.width, self.height)).png()
    }

    /// A surface with the shapes on it.
    pub(super) fn on<S: Surface>(&self, mut surface: S) -> S {
        write(&self.shapes, &mut surface);
        surface
    }
}

impl Align {
    /// The part of a text that is to the left of its place.
    pub(super) fn part(self) -> f64 {
        match self {
            Self::Left => 0.0,
            Self::Middle => 0.5,
            Self::Right => 1.0,
        }
    }
}

/// Shapes as SVG.
struct Svg<'a> {
    /// Begin of the names of frames.
    name: &'a str,
    colour: fn(Colour) -> String,
    cuts: usize,
    text: String,
}

impl<'a> Svg<'a> {
    fn new(name: &'a str, colour: fn(Colour) -> String) -> Self {
        Self {
            name,
            colour,
            cuts: 0,
            text: String::new(),
        }
    }

    fn add(&mut self, part: std::fmt::Arguments<'_>) {
        // Writing into memory cannot fail.
        let _ = self.text.write_fmt(part);
    }
}

impl Surface for Svg<'_> {
    fn area(&mut self, path: &str, colour: Colour, opacity: f64) {
        let colour = (self.colour)(colour);
        self.add(format_args!(r#"<path d="{path}" fill="{colour}""#));
        if opacity < 1.0 {
            self.add(format_args!(r#" fill-opacity="{opacity}""#));
        }
        self.add(format_args!("/>"));
    }

    fn line(&mut self, path: &str, stroke: Stroke) {
        let (colour, width) = ((self.colour)(stroke.colour), stroke.width);
        self.add(format_args!(
            r#"<path d="{path}" fill="none" stroke="{colour}" stroke-width="{width}" stroke-linejoin="round""#
        ));
        if let Some([dash, gap]) = stroke.dashes {
            self.add(format_args!(r#" stroke-dasharray="{dash} {gap}""#));
        }
        self.add(format_args!("/>"));
    }

    fn text(&mut self, label: &Label) {
        let anchor = match label.align {
            Align::Left => "",
            Align::Middle => r#" text-anchor="middle""#,
            Align::Right => r#" text-anchor="end""#,
        };
        let ((x, y), size) = (label.at, label.size);
        let (colour, text) = ((self.colour)(Colour::Ink), escaped(&label.text));
        self.add(format_args!(
            r#"<text x="{x:.2}" y="{y:.2}" font-size="{size}" fill="{colour}"{anchor}>{text}</text>"#
        ));
    }

    fn cut(&mut self, frame: Option<Frame>) {
        let Some(frame) = frame else {
            return self.add(format_args!("</g>"));
        };
        let Frame {
            left,
            top,
            width,
            height,
        } = frame;
        self.cuts += 1;
        let name = format!("{}{}", self.name, self.cuts);
        self.add(format_args!(
            r##"<clipPath id="{name}"><rect x="{left:.2}" y="{top:.2}" width="{width:.2}" height="{height:.2}"/></clipPath><g clip-path="url(#{name})">"##
        ));
    }
}

fn path(points: impl IntoIterator<Item = (f64, f64)>) -> String {
    let mut path = String::new();
    for (place, (x, y)) in points.into_iter().enumerate() {
        let step = if place == 0 { 'M' } else { 'L' };
        // Writing into memory cannot fail.
        let _ = write!(path, "{step}{x:.2} {y:.2}");
    }
    path
}

fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drawing_states_its_size_its_font_and_where_it_is_cut() {
        let mut canvas = Canvas::new(252.0, 100.5);
        canvas.text((4.0, 12.0), "q̇ [rad/s] <&", 8, Align::Left);
        let frame = Frame {
            left: 10.0,
            top: 20.0,
            width: 200.0,
            height: 60.0,
        };
        for _ in 0..2 {
            let points = [(0.0, 0.0), (250.0, 100.0)];
            canvas.inside(frame, |canvas| {
                canvas.curve(points, Stroke::solid(Colour::Trace(0), 1.0));
            });
        }
        let drawing = canvas.svg();
        assert!(drawing.contains(r#"width="252pt" height="100.5pt" viewBox="0 0 252 100.5""#));
        assert!(
            drawing.contains(r#"font-family="DejaVu Sans, "#),
            "{drawing}"
        );
        assert!(drawing.contains("q̇ [rad/s] &lt;&amp;"), "{drawing}");
        let embedded = canvas.embedded_svg("figure3-", "a title");
        assert!(embedded.contains("var(--trace-0)"), "{embedded}");
        for drawing in [&drawing, &embedded] {
            let cuts: Vec<_> = drawing.split("url(#").skip(1).collect();
            assert_eq!(cuts.len(), 2, "{drawing}");
            for cut in cuts {
                let (name, _) = cut.split_once(')').expect("a reference");
                let defined = format!(r#"<clipPath id="{name}"><rect x="10.00" y="20.00""#);
                assert_eq!(drawing.matches(&defined).count(), 1, "{drawing}");
            }
            assert!(drawing.len() < 2000, "{} bytes", drawing.len());
        }
    }
}
