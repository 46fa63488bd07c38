//! Reports: one page each, whole in one file, for a browser that has no network.
//!
//! An experiment becomes a [`Page`], its panels become [`Figure`]s, and the template sets both. Whatever a user
//! wrote, names of files and texts of scenarios, is escaped where it is set.
//!
//! ```text
//! result ─► content ─► template ─► html
//! panels ─► figure ─┬► data (what the script draws)
//!                   └► drawing (what is seen without a script, and printed)
//! ```

mod commissioning;
mod comparison;
mod experiment;
mod gains;
mod remedies;
mod sweep;
mod tuning;
mod unknowns;

pub use commissioning::{Commissioned, commissioning};
pub use comparison::comparison;
pub use experiment::{Experiment, experiment};
pub use sweep::{Swept, sweep};
pub use tuning::tuning;

use crate::present::{Block, Column, Figure, Page, Section, Table, Tone, Verdict};
