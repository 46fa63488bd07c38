//! Logs as text: `.csv` and `.csv.gz`, in the dialects of spreadsheets and data loggers.

mod cell;
mod columns;
mod dialect;
mod rows;
mod stamp;
mod table;
mod text;

pub(super) use dialect::Dialect;
pub(super) use rows::TextRows;
pub use table::{Table, TableColumn};
