//! Heat maps side by side.

use super::canvas::{Canvas, LETTER, SMALL, TINY};
use super::font::width;
use super::surface::{Align, Colour, Frame};
use super::{MARGIN, Size};
use crate::present::{HeatMap, HeatMaps, Tint};

/// Cividis at even distances, dark blue to yellow. (J. Nuñez, C. Anderton and R. Renslow, "Optimizing colormaps with
/// consideration for color vision deficiency", PLoS ONE 13(7), 2018.)
const CIVIDIS: [[u8; 3]; 5] = [
    [0, 32, 76],
    [65, 77, 107],
    [124, 123, 120],
    [188, 175, 111],
    [255, 234, 70],
];
const GOOD: [u8; 3] = [0, 114, 178];
const DOUBTFUL: [u8; 3] = [230, 159, 0];

/// Heights of a cell, of a map's title and of the numbers of its columns, and room between maps, points.
const CELL: f64 = 11.0;
const TITLE: f64 = 13.0;
const NUMBERS: f64 = 9.0;
const BETWEEN: f64 = 9.0;
/// Largest width of the key.
const MAX_KEY_WIDTH: f64 = 200.0;
/// Room between rows' names and cells.
const BEHIND_NAME: f64 = 4.0;

/// Draws maps, three side by side on a page, as one picture.
#[must_use]
pub fn heat_maps(size: Size, all: &HeatMaps) -> Canvas {
    let beside = match size {
        Size::Column => 1,
        Size::Page => 3,
    };
    let names = all.rows.iter().map(|name| width(name, TINY));
    let names = names.fold(0.0, f64::max) + BEHIND_NAME;
    let room = size.width() - 2.0 * MARGIN;
    let map_width = (room - names + BETWEEN) / beside as f64 - BETWEEN;
    let map_height = TITLE + NUMBERS + all.rows.len() as f64 * CELL + BETWEEN;
    let lines = all.maps.len().div_ceil(beside) as f64;
    let left = |column: usize| MARGIN + names + column as f64 * (map_width + BETWEEN);
    // The key stands in the last line's free place, or below.
    let free = Some(all.maps.len() % beside).filter(|taken| *taken > 0);
    let key = Key {
        of: all,
        width: free.map_or(room, |_| map_width).min(MAX_KEY_WIDTH),
    };
    let key_at = match free {
        Some(taken) => (left(taken), MARGIN + (lines - 1.0) * map_height + TITLE),
        None => (MARGIN, MARGIN + lines * map_height),
    };
    let height = (MARGIN + lines * map_height).max(key_at.1 + key.height());
    let mut canvas = Canvas::new(size.width(), height + MARGIN);
    for (place, map) in all.maps.iter().enumerate() {
        let (line, column) = (place / beside, place % beside);
        let frame = Frame {
            left: left(column),
            top: MARGIN + line as f64 * map_height + TITLE + NUMBERS,
            width: map_width,
            height: map_height - TITLE - NUMBERS - BETWEEN,
        };
        if column == 0 {
            for (row, name) in all.rows.iter().enumerate() {
                let base = frame.top + (row as f64 + 0.5) * CELL + 2.2;
                let at = (frame.left - BEHIND_NAME, base);
                canvas.text(at, name, TINY, Align::Right, Colour::Ink);
            }
        }
        draw(&mut canvas, frame, map);
    }
    key.draw(&mut canvas, key_at);
    canvas
}

fn draw(canvas: &mut Canvas, frame: Frame, map: &HeatMap) {
    let at = (frame.left, frame.top - NUMBERS - 4.0);
    canvas.text(at, &map.title, LETTER, Align::Left, Colour::Ink);
    for (row, cells) in map.cells.iter().enumerate() {
        let cell_width = frame.width / cells.len() as f64;
        for (column, cell) in cells.iter().enumerate() {
            let place = Frame {
                left: frame.left + column as f64 * cell_width,
                top: frame.top + row as f64 * CELL,
                // A white line between cells.
                width: cell_width - 0.6,
                height: CELL - 0.6,
            };
            let middle = place.left + 0.5 * cell_width;
            if row == 0 {
                let number = (column + 1).to_string();
                let at = (middle, frame.top - 3.0);
                canvas.text(at, &number, TINY, Align::Middle, Colour::Ink);
            }
            let colour = colour(cell.tint);
            canvas.rectangle(place, colour, 1.0);
            let at = (middle, place.top + 0.5 * CELL + 2.0);
            canvas.text(at, &cell.text, TINY, Align::Middle, readable_on(colour));
        }
    }
}

fn colour(tint: Tint) -> Colour {
    match tint {
        Tint::Graded(part) => {
            let last = CIVIDIS.len() - 1;
            let place = part.clamp(0.0, 1.0) * last as f64;
            let below = (place as usize).min(last - 1);
            let part = place - below as f64;
            Colour::Value(std::array::from_fn(|k| {
                let [low, high] = [CIVIDIS[below][k], CIVIDIS[below + 1][k]].map(f64::from);
                (low + part * (high - low)).round() as u8
            }))
        }
        Tint::Good => Colour::Value(GOOD),
        Tint::Doubtful => Colour::Value(DOUBTFUL),
        Tint::Bare => Colour::Paper,
    }
}

/// White on dark colours. (Relative luminance, Web Content Accessibility Guidelines 2.2, the gamma taken as 2.2.)
fn readable_on(colour: Colour) -> Colour {
    /// Luminance at which black and white have the same contrast.
    const MIDDLE: f64 = 0.18;
    let weights = [0.2126, 0.7152, 0.0722];
    let light = colour.rgb().map(|part| (f64::from(part) / 255.0).powf(2.2));
    let luminance: f64 = weights
        .iter()
        .zip(light)
        .map(|(weight, part)| weight * part)
        .sum();
    match luminance < MIDDLE {
        true => Colour::Paper,
        false => Colour::Ink,
    }
}

/// Meaning of numbers, letters and colours: lists beside one another, and below them the colours of errors.
#[derive(Debug)]
struct Key<'a> {
    of: &'a HeatMaps,
    width: f64,
}

impl Key<'_> {
    /// Height of a line, width of the sample of a letter, and room behind it, points.
    const LINE: f64 = CELL;
    const SAMPLE: f64 = 12.0;
    const BEHIND: f64 = 4.0;
    /// Room between the lists.
    const BETWEEN: f64 = 8.0;

    fn height(&self) -> f64 {
        // A heading above the lists; the colours, and room above them.
        let lines = self.of.columns.len().max(self.of.key.len()) + 1;
        (lines as f64 + 2.5) * Self::LINE
    }

    fn draw(&self, canvas: &mut Canvas, (left, top): (f64, f64)) {
        let names = self.of.columns.iter().map(|name| width(name, TINY));
        let names = names.fold(width("Cases", SMALL), f64::max);
        let right = left + Self::SAMPLE + Self::BEHIND + names + Self::BETWEEN;
        self.list(
            canvas,
            (left, top),
            "Cases",
            self.of
                .columns
                .iter()
                .enumerate()
                .map(|(place, name)| (None, (place + 1).to_string(), name.as_str())),
        );
        self.list(
            canvas,
            (right, top),
            "Status",
            self.of
                .key
                .iter()
                .map(|(cell, meaning)| (Some(cell.tint), cell.text.clone(), *meaning)),
        );
        self.colours(canvas, (left, top + self.height() - 2.0 * Self::LINE));
    }

    fn list<'b>(
        &self,
        canvas: &mut Canvas,
        (left, top): (f64, f64),
        heading: &str,
        rows: impl Iterator<Item = (Option<Tint>, String, &'b str)>,
    ) {
        let base = |line: usize| top + line as f64 * Self::LINE + 7.5;
        canvas.text((left, base(0)), heading, SMALL, Align::Left, Colour::Ink);
        for (line, (tint, letter, meaning)) in rows.enumerate() {
            let sample = Frame {
                left,
                top: top + (line + 1) as f64 * Self::LINE,
                width: Self::SAMPLE,
                height: Self::LINE - 0.6,
            };
            let ground = tint.map_or(Colour::Paper, colour);
            canvas.rectangle(sample, ground, 1.0);
            let at = (left + 0.5 * Self::SAMPLE, base(line + 1));
            canvas.text(at, &letter, TINY, Align::Middle, readable_on(ground));
            let at = (left + Self::SAMPLE + Self::BEHIND, base(line + 1));
            canvas.text(at, meaning, TINY, Align::Left, Colour::Ink);
        }
    }

    /// The colours of errors, from small to large.
    fn colours(&self, canvas: &mut Canvas, (left, top): (f64, f64)) {
        const STEPS: u32 = 24;
        let [small, large] = ["small error", "large error"];
        let before = width(small, SMALL) + Self::BEHIND;
        let bar = self.width - before - width(large, SMALL) - Self::BEHIND;
        let step = bar / f64::from(STEPS);
        for i in 0..STEPS {
            let part = Frame {
                left: left + before + f64::from(i) * step,
                top,
                // Without a line between two steps.
                width: step + 0.2,
                height: Self::LINE - 0.6,
            };
            let tint = Tint::Graded(f64::from(i) / f64::from(STEPS - 1));
            canvas.rectangle(part, colour(tint), 1.0);
        }
        let base = top + 7.5;
        canvas.text((left, base), small, SMALL, Align::Left, Colour::Ink);
        let at = (left + self.width, base);
        canvas.text(at, large, SMALL, Align::Right, Colour::Ink);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_light_on_dark_and_dark_on_light() {
        let [dark, light] = [0.0, 2.0].map(|part| colour(Tint::Graded(part)));
        assert_eq!(dark.rgb(), CIVIDIS[0]);
        assert_eq!(light.rgb(), CIVIDIS[4]);
        assert_eq!(readable_on(dark), Colour::Paper);
        assert_eq!(readable_on(light), Colour::Ink);
    }
}
