//! Samples as the interrupt reports them, machine units.

use commissioning::{CommissionStep, Phase};
use drive_link::Noticed;
use identifier_core::identifier;

use crate::closed_loop::Learnt;

/// The samples that are reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ReportTimer {
    /// Samples from one to the next; 0 for none.
    interval: u16,
    left: u32,
}

impl ReportTimer {
    pub(crate) const NEVER: Self = Self::every(0);

    /// The next sample, and from then on at this interval.
    pub(crate) const fn every(interval: u16) -> Self {
        Self {
            interval,
            left: if interval == 0 { u32::MAX } else { 1 },
        }
    }

    /// True if this sample is to be reported.
    #[inline]
    pub(crate) fn is_due(&mut self) -> bool {
        self.left -= 1;
        self.left == 0 && self.restart()
    }

    #[cold]
    fn restart(&mut self) -> bool {
        let is_due = self.interval > 0;
        self.left = if is_due {
            self.interval.into()
        } else {
            u32::MAX
        };
        is_due
    }
}

/// Events that are no faults.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Counts {
    /// Events of the identifier since the start.
    pub(crate) noticed: Noticed,
    /// Samples that were not reported for want of room since the drive was switched on.
    pub(crate) dropped: u32,
}

impl Counts {
    /// A run or a commissioning counts from zero.
    pub(crate) fn start(&mut self) {
        *self = Self {
            dropped: self.dropped,
            ..Self::default()
        };
    }

    #[inline]
    pub(crate) fn count(&mut self, event: identifier::Event) {
        let Noticed {
            started,
            load_steps,
            not_following,
            friction_lowered,
            restarted,
        } = &mut self.noticed;
        let count = match event {
            identifier::Event::Started => started,
            identifier::Event::LoadStep => load_steps,
            identifier::Event::NotFollowing => not_following,
            identifier::Event::FrictionLowered => friction_lowered,
            identifier::Event::Restarted => restarted,
            _ => return,
        };
        *count = count.saturating_add(1);
    }
}

/// A sample of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RunSample {
    /// Samples since the start.
    pub(crate) sample: u32,
    /// State of the identifier.
    pub(crate) learnt: Learnt,
    /// Position error, counts.
    pub(crate) error: f32,
    /// Counts from the start of the run.
    pub(crate) count: i32,
    /// Command, command units.
    pub(crate) command: f32,
    /// Output error, counts.
    pub(crate) output_error: f32,
    /// Events that are no faults.
    pub(crate) counts: Counts,
}

/// A sample of a commissioning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CommissionSample {
    /// Phase.
    pub(crate) phase: Phase,
    /// Samples since it began.
    pub(crate) sample: u32,
    /// The last count from the start of the commissioning.
    pub(crate) count: i32,
    /// The command that acts, command units; none while the servo is disabled.
    pub(crate) command: Option<f32>,
    /// Blocks of the record of this motion.
    pub(crate) recorded: u16,
}

impl CommissionSample {
    /// Before it begins.
    pub(crate) const IDLE: Self = Self {
        phase: Phase::Idle,
        sample: 0,
        count: 0,
        command: None,
        recorded: 0,
    };

    /// Takes in a sample.
    #[inline]
    pub(crate) fn update(&mut self, step: &CommissionStep<f32>, count: Option<i32>) {
        self.phase = step.phase;
        self.sample = self.sample.wrapping_add(1);
        self.count = count.unwrap_or(self.count);
        self.command = step.command;
        if let Some(event) = &step.finding {
            self.recorded = event.recorded(self.recorded);
        }
    }
}
