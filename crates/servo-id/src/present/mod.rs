//! Results for a reader: the verdict, tables, figures and notes of each verb, put together once.
//!
//! Every renderer reads the same [`Page`]. A terminal prints its brief sections, without headings and figures, and then
//! the verdict as `status: detail`. Tables lose their dispensable columns if a line is too short. A report shows all of
//! it. A picture shows its figures.

mod commissioning;
mod comparison;
mod document;
mod envelope;
mod estimates;
mod experiment;
mod figure;
mod form;
mod formats;
mod log;
pub(crate) mod number;
mod paper;
mod physical;
mod remedies;
mod sensitivity;
mod sweep;
mod tuning;

#[cfg(feature = "operation")]
pub(crate) use commissioning::why;
pub use commissioning::{
    CommissionTraces, Commissioned, commissioning, found_servo, largest_motion, unseen_motion,
};
pub use comparison::comparison;
pub use document::{Block, Column, Page, Section, Table, Tone, Verdict};
pub use envelope::Envelope;
pub use experiment::{Experiment, ExperimentTraces, experiment};
pub use figure::{Axis, Figure, Level, Settled, TIME, TimeSpan, Trace};
pub use formats::formats;
pub use log::introduction;
pub use paper::paper;
pub use sweep::sweep;
pub use tuning::{cost_of_errors, tuned_controller, tuning};
