//! Logs as text: `.csv` and `.csv.gz`, in the dialects of spreadsheets and data loggers.

mod cell;
mod dialect;
mod line;
mod stamp;
mod table;
mod text;

pub use table::{Table, TableColumn};
