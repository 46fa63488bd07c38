//! Tables of values as colours.

use super::canvas::{Align, BLACK, Frame, LETTER, SMALL, Sheet, TINY, WHITE, width};
use super::legend;
use super::plot::{Format, MARGIN, PlotError, Size};

/// A table of values as colours.
#[derive(Debug, Clone)]
pub struct Grid {
    /// Its title, with the unit.
    pub title: String,
    /// The cells, row by row.
    pub cells: Vec<Vec<Cell>>,
}

/// A cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// What is written in it, of few letters.
    pub text: String,
    /// Its colour.
    pub tone: Tone,
}

/// A colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tone {
    /// From 0, dark blue, to 1, yellow. (J. Nuñez, C. Anderton and R. Renslow, "Optimizing colormaps with
    /// consideration for color vision deficiency", PLoS ONE 13(7), 2018: cividis.)
    Graded(f64),
    /// As it should be.
    Good,
    /// Not as it should be.
    Doubtful,
    /// None.
    Bare,
}

/// Grids of the same rows and columns.
#[derive(Debug, Clone)]
pub struct Grids {
    /// Names of the rows, from the top.
    pub rows: Vec<String>,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// The grids.
    pub grids: Vec<Grid>,
    /// What letters in cells mean.
    pub key: String,
}

/// Cividis at even distances.
const CIVIDIS: [[u8; 3]; 5] = [
    [0, 32, 76],
    [65, 77, 107],
    [124, 123, 120],
    [188, 175, 111],
    [255, 234, 70],
];
const GOOD: [u8; 3] = [0, 114, 178];
const DOUBTFUL: [u8; 3] = [230, 159, 0];
const NOTHING: [u8; 3] = [255, 255, 255];

/// Height of a cell, of a grid's name, of the numbers of its columns, and room between grids, points.
const CELL: f64 = 11.0;
const NAME: f64 = 13.0;
const NUMBERS: f64 = 9.0;
const BETWEEN: f64 = 9.0;

/// Draws grids, three side by side on a page, as one picture: the bytes of its file.
///
/// # Errors
/// [`PlotError::Drawing`].
pub fn grids(format: Format, size: Size, all: &Grids) -> Result<Vec<u8>, PlotError> {
    let beside = match size {
        Size::Column => 1,
        Size::Page => 3,
    };
    let names = all
        .rows
        .iter()
        .map(|name| width(name, TINY))
        .fold(0.0, f64::max)
        + 4.0;
    let room = size.width() - 2.0 * MARGIN;
    let count = beside as f64;
    let wide = (room - names - (count - 1.0) * BETWEEN) / count;
    let tall = NAME + NUMBERS + all.rows.len() as f64 * CELL + BETWEEN;
    let lines = all.grids.len().div_ceil(beside) as f64;
    // The key stands where a grid is wanting, or below.
    let free = match all.grids.len() % beside {
        0 => None,
        taken => Some(MARGIN + names + taken as f64 * (wide + BETWEEN)),
    };
    let key = key(all, if free.is_some() { wide } else { room });
    let below = if free.is_some() {
        0.0
    } else {
        key.len() as f64 * legend::LINE
    };
    let height = 2.0 * MARGIN + lines * tall + below;
    let mut sheet = Sheet::new(size.width(), height);
    for (place, grid) in all.grids.iter().enumerate() {
        let (line, column) = (place / beside, place % beside);
        let top = MARGIN + line as f64 * tall;
        let frame = Frame {
            left: MARGIN + names + column as f64 * (wide + BETWEEN),
            top: top + NAME + NUMBERS,
            width: wide,
            height: tall - NAME - NUMBERS - BETWEEN,
        };
        if column == 0 {
            for (row, name) in all.rows.iter().enumerate() {
                let at = (
                    frame.left - 4.0,
                    frame.top + (row as f64 + 0.5) * CELL + 2.2,
                );
                sheet.words(at, name, TINY, Align::Right, BLACK);
            }
        }
        draw(&mut sheet, frame, grid);
    }
    for (line, text) in key.iter().enumerate() {
        let (left, top) = match free {
            Some(left) => (left, MARGIN + (lines - 1.0) * tall + NAME + NUMBERS),
            None => (MARGIN, MARGIN + lines * tall),
        };
        let y = top + line as f64 * legend::LINE + 7.0;
        sheet.words((left, y), text, SMALL, Align::Left, BLACK);
    }
    sheet.bytes(format)
}

fn draw(sheet: &mut Sheet, frame: Frame, grid: &Grid) {
    sheet.words(
        (frame.left, frame.top - NUMBERS - 4.0),
        &grid.title,
        LETTER,
        Align::Left,
        BLACK,
    );
    for (row, cells) in grid.cells.iter().enumerate() {
        let wide = frame.width / cells.len() as f64;
        for (column, cell) in cells.iter().enumerate() {
            let middle = frame.left + (column as f64 + 0.5) * wide;
            if row == 0 {
                let number = (column + 1).to_string();
                sheet.words(
                    (middle, frame.top - 3.0),
                    &number,
                    TINY,
                    Align::Middle,
                    BLACK,
                );
            }
            let place = Frame {
                left: frame.left + column as f64 * wide,
                top: frame.top + row as f64 * CELL,
                // A white line between cells.
                width: wide - 0.6,
                height: CELL - 0.6,
            };
            let colour = colour(cell.tone);
            let [red, green, blue] = colour;
            sheet.rectangle(place, &format!("#{red:02X}{green:02X}{blue:02X}"), 1.0);
            let base = place.top + 0.5 * CELL + 2.0;
            sheet.words(
                (middle, base),
                &cell.text,
                TINY,
                Align::Middle,
                readable_on(colour),
            );
        }
    }
}

fn colour(tone: Tone) -> [u8; 3] {
    match tone {
        Tone::Graded(part) => {
            let last = CIVIDIS.len() - 1;
            let place = part.clamp(0.0, 1.0) * last as f64;
            let below = (place as usize).min(last - 1);
            let part = place - below as f64;
            std::array::from_fn(|k| {
                let [low, high] = [CIVIDIS[below][k], CIVIDIS[below + 1][k]].map(f64::from);
                (low + part * (high - low)).round() as u8
            })
        }
        Tone::Good => GOOD,
        Tone::Doubtful => DOUBTFUL,
        Tone::Bare => NOTHING,
    }
}

/// White on what is dark. (Relative luminance, Web Content Accessibility Guidelines 2.2, the gamma taken as 2.2.)
fn readable_on(colour: [u8; 3]) -> &'static str {
    /// Where black and white are told from it alike.
    const MIDDLE: f64 = 0.18;
    let weights = [0.2126, 0.7152, 0.0722];
    let light = colour.map(|part| (f64::from(part) / 255.0).powf(2.2));
    let luminance: f64 = weights
        .iter()
        .zip(light)
        .map(|(weight, part)| weight * part)
        .sum();
    if luminance < MIDDLE { WHITE } else { BLACK }
}

/// What numbers and letters mean, in lines of so much room.
fn key(all: &Grids, room: f64) -> Vec<String> {
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
    use super::{BLACK, CIVIDIS, Tone, WHITE, colour, readable_on};

    #[test]
    fn figures_are_light_on_dark_and_dark_on_light() {
        assert_eq!(colour(Tone::Graded(0.0)), CIVIDIS[0]);
        assert_eq!(colour(Tone::Graded(2.0)), CIVIDIS[4]);
        assert_eq!(readable_on(colour(Tone::Graded(0.0))), WHITE);
        assert_eq!(readable_on(colour(Tone::Graded(1.0))), BLACK);
    }
}
