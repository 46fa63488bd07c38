//! Recorded logs: samples in SI and in even time, from CSV files or from columns in memory.
//!
//! A file is read once, into the columns of a [`Table`] (folder `csv`). [`Log::new`] takes the columns that its
//! settings state as rows in SI (`row`). It continues positions that begin again (`wrap`) and puts the rows in even
//! time (`even`). A segment ends at a range of time that is left out, and at a gap. Only the estimates are carried over
//! such a break.

mod clock;
mod code_length;
mod csv;
mod error;
mod even;
mod file;
#[cfg(feature = "files")]
pub(crate) mod fingerprint;
mod inner;
mod other;
mod row;
#[cfg(feature = "files")]
mod source;
mod wrap;

pub use clock::Jitter;
pub(crate) use clock::usual_steps;
pub use csv::{Table, TableColumn};
pub use error::LogError;
pub use even::Clock;
pub(crate) use file::extremes;
pub use file::{Found, Log, Segment};
pub use row::Row;
pub(crate) use wrap::{Jumps, Period};
