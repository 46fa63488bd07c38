//! Text for a terminal.

pub mod style;
pub(crate) mod table;
