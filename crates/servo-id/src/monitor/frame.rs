use std::mem::discriminant;

use drive_link::{Progress, Report, Snapshot};

/// A frame of telemetry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Frame {
    /// The snapshot of a closed loop.
    Running(Snapshot),
    /// For a commissioning.
    Commissioning(Progress),
}

impl Frame {
    /// The frame in a report, if it is one.
    #[must_use]
    pub fn from_report(report: &Report) -> Option<Self> {
        match report {
            Report::Snapshot(snapshot) => Some(Self::Running(*snapshot)),
            Report::Progress(progress) => Some(Self::Commissioning(*progress)),
            _ => None,
        }
    }

    /// True if it is of the same motion as a frame before it.
    pub(super) fn continues(&self, before: &Self) -> bool {
        discriminant(self) == discriminant(before) && self.sample() > before.sample()
    }

    /// Samples since the motion began.
    #[must_use]
    pub fn sample(&self) -> u32 {
        match self {
            Self::Running(snapshot) => snapshot.sample,
            Self::Commissioning(progress) => progress.sample,
        }
    }

    /// Position, rad from where the motion began.
    #[must_use]
    pub fn position(&self) -> f64 {
        f64::from(match self {
            Self::Running(snapshot) => snapshot.position,
            Self::Commissioning(progress) => progress.position,
        })
    }

    /// Reference, rad from where the motion began; a commissioning has none.
    #[must_use]
    pub fn reference(&self) -> Option<f64> {
        match self {
            Self::Running(snapshot) => Some(snapshot.reference.into()),
            Self::Commissioning(_) => None,
        }
    }

    /// Command that acts, command units; none while the stage is disabled.
    #[must_use]
    pub fn command(&self) -> Option<f64> {
        match self {
            Self::Running(snapshot) => Some(snapshot.command.into()),
            Self::Commissioning(progress) => progress.command.map(f64::from),
        }
    }

    /// Output error, rad; a commissioning has none.
    #[must_use]
    pub fn output_error(&self) -> Option<f64> {
        match self {
            Self::Running(snapshot) => Some(snapshot.output_error.into()),
            Self::Commissioning(_) => None,
        }
    }
}
