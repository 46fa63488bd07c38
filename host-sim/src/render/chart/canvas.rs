//! Lines, areas and words on a sheet. Lengths are points, 1/72 inch, from the upper left corner.

use std::fmt::Write as _;

use kuva::backend::png::PngBackend;
use kuva::backend::svg::SvgBackend;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor};

use super::plot::{Format, PlotError};

/// Pixels of a PNG to a point: 216 to an inch.
const PIXELS: f32 = 3.0;

/// Points of a letter.
pub(super) const LETTER: u32 = 8;
/// Points of a letter at a tick and in a legend.
pub(super) const SMALL: u32 = 7;
/// Points of a letter where there is little room.
pub(super) const TINY: u32 = 6;

pub(super) const BLACK: &str = "#000000";
pub(super) const WHITE: &str = "#FFFFFF";
/// Lines behind curves.
pub(super) const GRID: &str = "#E4E4E4";

/// Which point of a text a place is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Align {
    Left,
    Middle,
    Right,
}

/// A line's look.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stroke {
    pub(super) colour: &'static str,
    pub(super) width: f64,
    /// How long a dash is, and the gap behind it, points; only of straight lines.
    pub(super) dashes: Option<(f64, f64)>,
}

impl Stroke {
    pub(super) const fn solid(colour: &'static str, width: f64) -> Self {
        Self {
            colour,
            width,
            dashes: None,
        }
    }
}

/// A part of the sheet.
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

/// A sheet.
#[derive(Debug)]
pub(super) struct Sheet {
    scene: Scene,
    clips: usize,
}

impl Sheet {
    pub(super) fn new(width: f64, height: f64) -> Self {
        let mut scene = Scene::new(width, height);
        scene.font_family = Some(FONTS.to_owned());
        Self { scene, clips: 0 }
    }

    /// Words on a base line. A circumflex on a tall letter stands above it: the font's own would cross it.
    pub(super) fn words(
        &mut self,
        (x, y): (f64, f64),
        words: &str,
        size: u32,
        align: Align,
        colour: &str,
    ) {
        /// How far above the base line of its letter a circumflex of its own stands, and half its width, in
        /// letters' sizes.
        const RAISED: f64 = 0.22;
        const HALF: f64 = 0.25;
        let left = match align {
            Align::Left => x,
            Align::Middle => x - 0.5 * width(words, size),
            Align::Right => x - width(words, size),
        };
        let mut plain = String::new();
        for letter in words.chars() {
            if letter == CIRCUMFLEX && plain.ends_with(['b', 'd']) {
                let behind = width(&plain, size);
                let wide = behind - width(&plain[..plain.len() - 1], size);
                let to_middle = behind - 0.5 * wide - HALF * f64::from(size);
                let at = (left + to_middle, y - RAISED * f64::from(size));
                self.text(at, "ˆ".to_owned(), size, colour);
            } else {
                plain.push(letter);
            }
        }
        self.text((left, y), plain, size, colour);
    }

    fn text(&mut self, (x, y): (f64, f64), content: String, size: u32, colour: &str) {
        self.scene.add(Primitive::Text {
            x,
            y,
            content,
            size,
            anchor: TextAnchor::Start,
            rotate: None,
            bold: false,
            color: Some(colour.into()),
        });
    }

    pub(super) fn line(&mut self, from: (f64, f64), to: (f64, f64), stroke: Stroke) {
        let Some((dash, gap)) = stroke.dashes else {
            return self.dash(from, to, stroke);
        };
        // Drawn one by one: as pixels, the library's are of another length.
        let (x, y) = (to.0 - from.0, to.1 - from.1);
        let length = x.hypot(y);
        let at = |way: f64| {
            let part = (way / length).min(1.0);
            (from.0 + part * x, from.1 + part * y)
        };
        let mut begin = 0.0;
        while begin < length {
            self.dash(at(begin), at(begin + dash), stroke);
            begin += dash + gap;
        }
    }

    fn dash(&mut self, from: (f64, f64), to: (f64, f64), stroke: Stroke) {
        self.scene.add(Primitive::Line {
            x1: from.0,
            y1: from.1,
            x2: to.0,
            y2: to.1,
            stroke: stroke.colour.into(),
            stroke_width: stroke.width,
            stroke_dasharray: None,
        });
    }

    pub(super) fn curve(&mut self, points: Vec<(f64, f64)>, stroke: Stroke) {
        self.scene.add(Primitive::PolyLine {
            points,
            stroke: stroke.colour.into(),
            stroke_width: stroke.width,
            stroke_dasharray: None,
        });
    }

    /// What a line around it encloses.
    pub(super) fn area(&mut self, outline: &[(f64, f64)], colour: &str, opacity: f64) {
        let mut path = String::new();
        for (place, (x, y)) in outline.iter().enumerate() {
            let step = if place == 0 { 'M' } else { 'L' };
            // Writing into a text cannot fail.
            let _ = write!(path, "{step}{x:.2},{y:.2}");
        }
        path.push('Z');
        self.scene.add(Primitive::Path(Box::new(PathData {
            d: path,
            fill: Some(colour.into()),
            stroke: kuva::render::color::Color::None,
            stroke_width: 0.0,
            opacity: Some(opacity),
            stroke_dasharray: None,
        })));
    }

    pub(super) fn rectangle(&mut self, frame: Frame, colour: &str, opacity: f64) {
        self.scene.add(Primitive::Rect {
            x: frame.left,
            y: frame.top,
            width: frame.width,
            height: frame.height,
            fill: colour.into(),
            stroke: None,
            stroke_width: None,
            opacity: Some(opacity),
        });
    }

    /// Draws what is seen inside a frame alone.
    pub(super) fn inside(&mut self, frame: Frame, draw: impl FnOnce(&mut Self)) {
        self.clips += 1;
        let id = format!("frame{}", self.clips);
        let Frame {
            left: x,
            top: y,
            width,
            height,
        } = frame;
        // A PNG is clipped by the primitive, an SVG by this definition.
        self.scene.defs.push(format!(
            r#"<clipPath id="{id}"><rect x="{x:.2}" y="{y:.2}" width="{width:.2}" height="{height:.2}"/></clipPath>"#
        ));
        self.scene.add(Primitive::ClipStart {
            x,
            y,
            width,
            height,
            id,
        });
        draw(self);
        self.scene.add(Primitive::ClipEnd);
    }

    /// The bytes of its file.
    pub(super) fn bytes(&self, format: Format) -> Result<Vec<u8>, PlotError> {
        match format {
            Format::Png => PngBackend::new()
                .with_scale(PIXELS)
                .render_scene(&self.scene)
                .map_err(PlotError::Drawing),
            Format::Svg => Ok(self.svg().into_bytes()),
        }
    }

    /// The drawing, as large as it is meant: what has no unit is a pixel, 1/96 inch.
    fn svg(&self) -> String {
        let (width, height) = (self.scene.width, self.scene.height);
        let drawing = SvgBackend::new().render_scene(&self.scene);
        let in_pixels = format!(r#"width="{width}" height="{height}""#);
        let in_points =
            format!(r#"width="{width}pt" height="{height}pt" viewBox="0 0 {width} {height}""#);
        drawing.replacen(&in_pixels, &in_points, 1)
    }
}

/// The font that widths are of, and one with such widths where that is not installed.
const FONTS: &str = "DejaVu Sans, Verdana, sans-serif";

/// A circumflex on the letter before.
const CIRCUMFLEX: char = '\u{302}';

/// Advances of the letters from space to tilde of DejaVu Sans, which kuva brings, thousandths of their size.
const ADVANCES: [u16; 95] = [
    318, 401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361, 318, 337, 636, 636, 636,
    636, 636, 636, 636, 636, 636, 636, 337, 337, 838, 838, 838, 531, 1000, 684, 686, 698, 770, 632,
    575, 775, 752, 295, 295, 656, 557, 863, 748, 787, 603, 787, 695, 635, 611, 732, 684, 989, 685,
    611, 685, 390, 337, 390, 838, 500, 500, 613, 635, 550, 635, 615, 352, 635, 634, 278, 278, 579,
    278, 974, 634, 612, 635, 635, 411, 521, 392, 634, 592, 818, 592, 592, 525, 636, 337, 636, 838,
];

/// How wide words are, points.
pub(super) fn width(words: &str, size: u32) -> f64 {
    let thousandths: f64 = words.chars().map(advance).sum();
    thousandths * f64::from(size) / 1000.0
}

fn advance(letter: char) -> f64 {
    let place = (letter as usize).wrapping_sub(' ' as usize);
    match (ADVANCES.get(place), letter) {
        (Some(&advance), _) => f64::from(advance),
        (None, '\u{300}'..='\u{36f}') => 0.0,
        (None, '²' | '³' | '¹' | '⁰'..='⁹') => 401.0,
        (None, '⁻' | 'ĉ' | 'ε' | '–') => 530.0,
        (None, '±' | '−' | '×' | '≠' | '≤' | 'ω') => 838.0,
        (None, '·') => 318.0,
        _ => 613.0,
    }
}

#[cfg(test)]
mod tests {
    use super::{Align, BLACK, Frame, Sheet, Stroke, width};

    #[test]
    fn a_drawing_says_how_large_it_is_in_which_letters_and_where_it_is_cut() {
        let mut sheet = Sheet::new(252.0, 100.5);
        sheet.words((4.0, 12.0), "q̇ [rad/s]", 8, Align::Left, BLACK);
        let frame = Frame {
            left: 10.0,
            top: 20.0,
            width: 200.0,
            height: 60.0,
        };
        for _ in 0..2 {
            let points = vec![(0.0, 0.0), (250.0, 100.0)];
            sheet.inside(frame, |sheet| {
                sheet.curve(points, Stroke::solid(BLACK, 1.0))
            });
        }
        let drawing = sheet.svg();
        assert!(drawing.contains(r#"width="252pt" height="100.5pt" viewBox="0 0 252 100.5""#));
        assert!(
            drawing.contains(r#"font-family="DejaVu Sans, "#),
            "{drawing}"
        );
        let cuts: Vec<_> = drawing.split("url(#").skip(1).collect();
        assert_eq!(cuts.len(), 2, "{drawing}");
        for cut in cuts {
            let (name, _) = cut.split_once(')').expect("a reference");
            let defined = format!(r#"<clipPath id="{name}"><rect x="10.00" y="20.00""#);
            assert_eq!(drawing.matches(&defined).count(), 1, "{drawing}");
        }
        assert!(drawing.len() < 2000, "{} bytes", drawing.len());
    }

    #[test]
    fn a_mark_above_a_letter_takes_no_room() {
        assert!((width("b\u{302}", 8) - width("b", 8)).abs() < 1e-12);
        assert!(width("command", 8) > width("limit", 8));
    }
}
