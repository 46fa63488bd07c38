//! Tables of values as colours.

/// Maps of the same rows and columns.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatMaps {
    /// Names of the rows, from the top.
    pub rows: Vec<String>,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// The maps.
    pub maps: Vec<HeatMap>,
    /// Meaning of the letters in cells.
    pub key: Vec<(HeatCell, &'static str)>,
}

/// A table of values as colours.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatMap {
    /// Title, with the unit.
    pub title: String,
    /// The cells, row by row.
    pub cells: Vec<Vec<HeatCell>>,
}

/// A cell.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatCell {
    /// Its text, of few letters.
    pub text: String,
    /// Its colour.
    pub tint: Tint,
}

/// A colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tint {
    /// From 0, dark blue, to 1, yellow.
    Graded(f64),
    /// A state that is all right.
    Good,
    /// A state that is not.
    Doubtful,
    /// None.
    Bare,
}
