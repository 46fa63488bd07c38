//! The scan of a log before anything is identified on it.
//!
//! It asks whether the log can be what the scenario says of it: the sign of command and encoder, the unit of the
//! position, the columns, the encoder, and whether the command moves the servo at all. Each finding is one sentence
//! with the key that mends it. Time and positions that begin again after a revolution are seen to where a log is
//! [read](crate::log).
//!
//! The scan neither needs nor makes an estimate: a regression in weak form says which way the command
//! acts, and how surely.

mod controller;
mod grid;
mod motion;
mod remark;
mod units;
mod weak_form;

pub(crate) use grid::Positions;
pub(crate) use motion::explained_by;
pub use remark::{Remark, RemarkKind};
pub(crate) use units::{is_usual, is_whole};

use crate::log::Log;
use crate::scenario::Scenario;

/// Fewest samples that something is identified on, as of the verdict.
const MIN_SAMPLES: u64 = 100;

/// The findings about a log that is to be identified with a scenario, which is [`fitted`](crate::replay::fitted) to it;
/// none about a log in order.
pub(crate) fn scan(scenario: &Scenario, log: &Log) -> Vec<Remark> {
    if log.samples < MIN_SAMPLES {
        let text = format!(
            "the log has {} samples: at least {MIN_SAMPLES} are needed, and seconds are better",
            log.samples
        );
        return vec![Remark::refusing(RemarkKind::TooShort, text)];
    }
    let unit = units::position(scenario, log);
    let mut remarks = motion::remarks(scenario, log);
    let is_sound = unit.is_none() && remarks.iter().all(|remark| !remark.refuses);
    if is_sound {
        remarks.extend(controller::remark(scenario, log).or_else(|| units::reference(log)));
    }
    unit.into_iter().chain(remarks).collect()
}
