//! The tables of a scenario that a log has, in SI: encoder, amplifier, controller, identifier, and the log itself.
//!
//! A text is read in steps that each do one thing. `source` parses it. Then `read` writes its values, key by key, into a
//! [`Document`]. Last, its check rejects settings that contradict each other. The table of a document's keys has all of
//! them, from which reading, errors, help and [`schema`] follow. A key's `kind` reads and describes its value. A crate
//! with further tables has a document of its own, whose keys are [`keys::of_log`] and its own.

mod check;
mod dispatch;
mod document;
mod error;
mod estimator;
mod inner;
mod key;
pub mod keys;
mod kind;
mod log;
mod log_quantity;
mod log_units;
mod names;
mod of_origin;
mod options;
mod physical;
mod range;
mod read;
pub mod schema;
mod set;
mod source;

pub use document::Document;
pub use error::{Fault, ScenarioError};
pub use estimator::{Estimator, LoopKind, RivalSettings};
pub use inner::{InnerLoop, Integrator};
pub use key::examples;
pub use kind::{Choice, Default, Entries, Key, Kind, MAX_COLUMNS, MAX_ENTRIES, When};
pub(crate) use log::in_order;
pub use log::{Column, LogSettings};
pub use log_quantity::LogQuantity;
pub use log_units::{LogUnits, PositionUnit, TimeUnit};
pub use options::{Arithmetic, Identification, Options, Velocity};
pub use physical::{CommandUnit, PhysicalSettings};
pub use range::Range;
pub use set::ModelSet;
pub use source::fetch;

/// All tables of a scenario, in the order in which they are read: what a later one needs stands before it.
pub const TABLES: [&str; 13] = [
    "plant",
    "encoder",
    "amplifier",
    "controller",
    "excitation",
    "identifier",
    "run",
    "fault",
    "compare",
    "commission",
    "inner",
    "physical",
    "log",
];
