//! What a result means to a reader: each verb's verdict, tables, figures and notes, put together once.
//!
//! Every renderer reads the same [`Page`]. A terminal prints its brief sections, without headings and figures, and
//! then the verdict as `status: detail`; tables lose their dispensable columns where a line is too short. A report
//! shows all of it. A picture shows its figures.

mod document;
mod envelope;
mod figure;
mod heat_map;
mod log;
pub(crate) mod number;
pub mod traces;

pub use document::{Block, Column, Page, Progress, Section, Table, Tone, Verdict};
pub use envelope::Envelope;
pub use figure::{Axis, Figure, Level, Stretch, TIME, Trace};
pub use heat_map::{HeatCell, HeatMap, HeatMaps, Tint};
