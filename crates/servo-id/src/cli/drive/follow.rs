//! The reports of a drive while a verb waits for it.

use std::ops::DerefMut;
use std::time::Duration;

use drive_link::{Report, State};

use crate::cli::fault::Fault;
use crate::drive::{Client, DriveError, Silence};

/// Longest time from one call of the observer to the next: how long an interruption may have to wait.
const TICK: Duration = Duration::from_millis(50);

/// A report on the work of a drive; a status with a fault is the report of that fault.
fn of_work(report: &Report) -> Option<Report> {
    match report {
        Report::Status { status, .. } => Some(match status.state {
            State::Faulted(fault) => Report::Fault(fault),
            _ => report.clone(),
        }),
        Report::Snapshot(_) | Report::Progress(_) | Report::Fault(_) => Some(report.clone()),
        _ => None,
    }
}

/// The samples in a time, s, at least one, as a drive takes them for the period of its reports.
pub(super) fn samples_in(time: f64, sample_time: f64) -> u16 {
    (time / sample_time).clamp(1.0, f64::from(u16::MAX)) as u16
}

/// Passes every report of the work of a drive, or of a [`Driven`](crate::drive::Driven), to `observe`, and `None` where none comes for
/// a while, until it returns a value.
///
/// # Errors
/// If the line breaks, the drive falls silent, or `observe` fails.
pub(super) fn follow<T, D: DerefMut<Target = Client>>(
    drive: &mut D,
    mut observe: impl FnMut(&mut D, Option<Report>) -> Result<Option<T>, Fault>,
) -> Result<T, Fault> {
    let mut silence = Silence::begin();
    loop {
        let event = drive.next_within(TICK, of_work)?;
        if event.is_some() {
            silence.end();
        } else if silence.is_too_long() {
            return Err(DriveError::Silent.into());
        }
        if let Some(end) = observe(drive, event)? {
            return Ok(end);
        }
    }
}
