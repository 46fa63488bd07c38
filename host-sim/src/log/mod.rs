//! Recorded logs: rows in SI from CSV files, or from columns in memory, in even time.
//!
//! A file is never in memory: [`Log::read`] reads the file once to judge it, and [`Log::rows`] reads it again,
//! row by row. The folder `csv` makes rows of a file, behind the trait `Rows`; `spacing`
//! puts them in even time. Where a range of time is left out, and where a log ends, a stretch ends: nothing is
//! carried over such a break but the estimates.

mod clock;
#[cfg(feature = "experiments")]
mod columns;
mod csv;
mod error;
mod excerpt;
mod file;
mod inner;
mod row;
#[cfg(feature = "experiments")]
mod source;
#[cfg(not(feature = "experiments"))]
#[path = "in_memory.rs"]
mod source;
mod spacing;
mod times;
mod wrap;

pub use clock::Jitter;
#[cfg(feature = "experiments")]
pub use columns::Columns;
pub use csv::{Table, TableColumn};
pub use error::LogError;
pub(crate) use excerpt::{Segment, extremes};
pub(crate) use file::Stretch;
pub use file::{Found, Log};
pub use row::Row;
#[cfg(not(feature = "experiments"))]
pub use source::hold;
pub use spacing::Wrapped;
pub use times::{Gap, Times};
pub(crate) use wrap::{Jumps, Period};
