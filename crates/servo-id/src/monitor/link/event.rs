use drive_link::{Command, Refusal, Report};

use crate::drive::{DriveError, Silence};

/// The state in which the servo was left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// It was released already.
    WasDisabled,
    /// It was released for the end.
    Stopped,
    /// It stays driven.
    Left,
}

/// An event of the line.
#[derive(Debug)]
pub enum LinkEvent {
    /// A report, but for answers.
    Report(Report),
    /// An order was done.
    Done(Command),
    /// An order was refused.
    Refused(Refusal),
    /// No answer came: unknown whether the command was done.
    Unanswered(Command),
    /// The drive is lost.
    Lost(LinkError),
}

/// Why a drive is lost.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// The line broke.
    #[error(transparent)]
    Drive(#[from] DriveError),
    /// The line works, and the drive is silent.
    #[error(
        "the drive has been silent for {} s: is it switched on and connected?",
        Silence::MAX.as_secs()
    )]
    Silent,
    /// The thread of the line has ended by a defect of this program.
    #[error("the thread of the serial line has ended")]
    Ended,
}
