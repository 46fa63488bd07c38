//! The reports of a drive while a verb waits for it.

use std::ops::DerefMut;
use std::time::Duration;

use drive_link::{Progress, Report, Snapshot, State, Status};

use super::fault;
use crate::cli::fault::Fault;
use crate::drive::{Client, DriveError, Silence};

/// Longest time from one call of the observer to the next: how long an interruption may have to wait.
const TICK: Duration = Duration::from_millis(50);

/// A report of a drive at work.
#[expect(
    clippy::large_enum_variant,
    reason = "one at a time, some hundred a second"
)]
pub(super) enum Event {
    Snapshot(Snapshot),
    Progress(Progress),
    Status(Status),
    Fault(drive_link::Fault),
}

impl Event {
    fn from_report(report: &Report) -> Option<Self> {
        Some(match report {
            Report::Snapshot(snapshot) => Self::Snapshot(*snapshot),
            Report::Progress(progress) => Self::Progress(*progress),
            Report::Fault(fault) => Self::Fault(*fault),
            Report::Status { status, .. } => match status.state {
                State::Faulted(fault) => Self::Fault(fault),
                _ => Self::Status(*status),
            },
            _ => return None,
        })
    }
}

/// The samples in a time, s, at least one, as a drive takes them for the period of its reports.
pub(super) fn samples_in(time: f64, sample_time: f64) -> u16 {
    (time / sample_time).clamp(1.0, f64::from(u16::MAX)) as u16
}

/// Passes every report of a drive, or of a [`Driven`](crate::drive::Driven), to `observe`, and `None` where none comes for
/// a while, until it returns a value.
///
/// # Errors
/// If the line breaks, the drive falls silent, or `observe` fails.
pub(super) fn follow<T, D: DerefMut<Target = Client>>(
    drive: &mut D,
    mut observe: impl FnMut(&mut D, Option<Event>) -> Result<Option<T>, Fault>,
) -> Result<T, Fault> {
    let mut silence = Silence::begin();
    loop {
        let event = drive.next_within(TICK, Event::from_report).map_err(fault)?;
        if event.is_some() {
            silence.end();
        } else if silence.is_too_long() {
            return Err(fault(DriveError::Silent));
        }
        if let Some(end) = observe(drive, event)? {
            return Ok(end);
        }
    }
}
