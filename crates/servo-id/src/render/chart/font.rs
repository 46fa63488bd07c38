//! The font of pictures: widths for both formats, outlines for PNG. A file of SVG names the font.
//!
//! [`FILE`] is DejaVu Sans 2.37 with the letters of [`LETTERS`] alone. It was made by `pyftsubset DejaVuSans.ttf
//! --no-hinting --notdef-outline --layout-features='' --drop-tables+=GSUB,GPOS,GDEF,kern,FFTM,MATH --unicodes=…`
//! (fonttools 4).

use std::sync::LazyLock;

use ttf_parser::{Face, GlyphId, OutlineBuilder};
use zeno::{Command, Point};

const FILE: &[u8] = include_bytes!("font/DejaVuSans-subset.ttf");

/// The font, and one of such widths where it is not installed.
pub(super) const FAMILIES: &str = "DejaVu Sans, Verdana, sans-serif";

/// A circumflex on the letter before.
pub(super) const CIRCUMFLEX: char = '\u{302}';

static FACE: LazyLock<Option<Face<'static>>> = LazyLock::new(|| Face::parse(FILE, 0).ok());

/// Width of a text, points.
pub(super) fn width(text: &str, size: u32) -> f64 {
    let Some(face) = &*FACE else { return 0.0 };
    let units: f64 = text
        .chars()
        .map(|letter| advance(face, glyph(face, letter)))
        .sum();
    units * f64::from(size) / f64::from(face.units_per_em())
}

/// Outlines of a text that begins at a place, in units of `scale` to a point, downwards.
pub(super) fn outlines((x, y): (f64, f64), text: &str, size: u32, scale: f64) -> Vec<Command> {
    let Some(face) = &*FACE else {
        return Vec::new();
    };
    let mut pen = Pen {
        x: scale * x,
        y: scale * y,
        scale: scale * f64::from(size) / f64::from(face.units_per_em()),
        commands: Vec::new(),
    };
    for letter in text.chars() {
        let glyph = glyph(face, letter);
        // A letter without an outline is a space.
        let _ = face.outline_glyph(glyph, &mut pen);
        pen.x += pen.scale * advance(face, glyph);
    }
    pen.commands
}

fn glyph(face: &Face<'_>, letter: char) -> GlyphId {
    face.glyph_index(letter).unwrap_or_default()
}

/// Units to the next letter: none for a mark above the one before.
fn advance(face: &Face<'_>, glyph: GlyphId) -> f64 {
    f64::from(face.glyph_hor_advance(glyph).unwrap_or(0))
}

struct Pen {
    x: f64,
    y: f64,
    scale: f64,
    commands: Vec<Command>,
}

impl Pen {
    fn point(&self, x: f32, y: f32) -> Point {
        let x = self.x + self.scale * f64::from(x);
        let y = self.y - self.scale * f64::from(y);
        Point::new(x as f32, y as f32)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.commands.push(Command::MoveTo(self.point(x, y)));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.commands.push(Command::LineTo(self.point(x, y)));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (control, end) = (self.point(x1, y1), self.point(x, y));
        self.commands.push(Command::QuadTo(control, end));
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let controls = (self.point(x1, y1), self.point(x2, y2));
        let end = self.point(x, y);
        self.commands
            .push(Command::CurveTo(controls.0, controls.1, end));
    }

    fn close(&mut self) {
        self.commands.push(Command::Close);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_that_figures_use_is_in_the_font() {
        let face = FACE.as_ref().expect("the font is one");
        for letter in "aâĉbd\u{302}q\u{307}ε²⁻³±−×≠≤ω·–“”|%ˆ".chars() {
            assert!(face.glyph_index(letter).is_some(), "{letter}");
        }
    }

    #[test]
    fn a_mark_above_a_letter_takes_no_room() {
        assert!((width("b\u{302}", 8) - width("b", 8)).abs() < 1e-12);
        assert!(width("command", 8) > width("limit", 8));
    }

    /// Corners of a text's outlines.
    fn corners(place: (f64, f64), text: &str, scale: f64) -> impl Iterator<Item = Point> {
        let outline = outlines(place, text, 8, scale).into_iter();
        outline.filter_map(|command| match command {
            Command::MoveTo(point) | Command::LineTo(point) => Some(point),
            _ => None,
        })
    }

    #[test]
    fn letters_stand_one_behind_the_other() {
        let right = |text| corners((0.0, 0.0), text, 1.0).fold(0.0, |x: f32, point| x.max(point.x));
        let further = f64::from(right("II") - right("I"));
        assert!((further - width("I", 8)).abs() < 1e-3, "{further}");
    }

    #[test]
    fn a_letter_stands_on_its_base_line() {
        let corners = corners((10.0, 20.0), "I", 3.0);
        let (lowest, highest) = corners.fold((0.0_f32, 999.0_f32), |(low, high), point| {
            assert!((30.0..40.0).contains(&point.x), "{point:?}");
            (low.max(point.y), high.min(point.y))
        });
        assert!((lowest - 60.0).abs() < 0.01 && (40.0..45.0).contains(&highest));
    }
}
