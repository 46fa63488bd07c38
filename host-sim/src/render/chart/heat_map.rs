//! Heat maps side by side.

use super::canvas::{Align, Canvas, Colour, Frame, LETTER, SMALL, TINY};
use super::font::width;
use super::{MARGIN, Size, legend};
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
    let key = key(all, free.map_or(room, |_| map_width));
    let key_at = match free {
        Some(taken) => (left(taken), (lines - 1.0) * map_height + TITLE + NUMBERS),
        None => (MARGIN, lines * map_height),
    };
    let below = match free {
        Some(_) => 0.0,
        None => key.len() as f64 * legend::LINE,
    };
    let mut canvas = Canvas::new(size.width(), 2.0 * MARGIN + lines * map_height + below);
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
    for (line, text) in key.iter().enumerate() {
        let base = MARGIN + key_at.1 + line as f64 * legend::LINE + 7.0;
        canvas.text((key_at.0, base), text, SMALL, Align::Left, Colour::Ink);
    }
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

/// Meaning of numbers and letters, in lines of this width.
fn key(all: &HeatMaps, room: f64) -> Vec<String> {
    let numbered = all.columns.iter().enumerate();
    let names = numbered.map(|(place, name)| format!("{} {name}", place + 1));
    let words = names.chain(all.key.split("; ").map(str::to_owned));
    let mut lines: Vec<String> = Vec::new();
    for word in words.filter(|word| !word.is_empty()) {
        match lines.last_mut() {
            Some(line) if width(line, SMALL) + width(&word, SMALL) + 12.0 < room => {
                line.push_str(", ");
                line.push_str(&word);
            }
            _ => lines.push(word),
        }
    }
    lines
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
