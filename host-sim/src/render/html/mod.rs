//! Pages of HTML, each whole in one file, for a browser that has no network. Whatever a user wrote, names of files
//! and texts of scenarios, is escaped.

mod data;
mod drawing;
mod template;
mod ticks;

use crate::present::{
    Block, Figure, Page, Progress, Section, Stretch, Stroke, Table, Tone, Trace, Verdict,
};
