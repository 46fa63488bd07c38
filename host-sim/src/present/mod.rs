//! What a result means to a reader: each verb's verdict, tables, figures and notes, put together once.
//!
//! A [`Page`] is read by the renderers: the terminal shows its brief sections, a report all of them, a picture its
//! figures.

mod document;

pub use document::{Block, Column, Page, Progress, Section, Table, Tone, Verdict};
