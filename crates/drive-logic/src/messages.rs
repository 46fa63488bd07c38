//! What the supervisor orders, and what the interrupt tells.

use drive_link::{Ended, Fault, Noticed};
use identifier_core::commission::{CommissionStep, Phase, RecordEvent};
use identifier_core::identifier;

use crate::closed_loop::Learnt;
use crate::commissioning::Commissioning;
use crate::run::Run;

/// What the supervisor orders.
#[derive(Debug)]
pub(crate) enum Order {
    /// Close this loop where the servo stands.
    Run(&'static mut Run),
    /// Commission the servo from where it stands.
    Commission(&'static mut Commissioning),
    /// The same in place of the loop that runs.
    CommissionBeside(&'static mut Commissioning),
    /// Go on with this loop where a commissioning holds the servo.
    GoOn(&'static mut Run),
    /// Send the servo to a target, counts from where it started.
    Target(i32),
    /// Forget a fault, if its cause is gone.
    Clear,
    /// Show a sample every so often; 0 for never.
    Watch(u16),
}

/// What the interrupt tells.
#[derive(Debug)]
pub(crate) enum Event {
    /// How things stand: after every change, and after every order that asks for one.
    Standing(Standing),
    /// A sample.
    Shown(Shown),
    /// A sample of a commissioning.
    Moved(Moved),
}

/// What comes back from the interrupt: it has ended, or was not begun.
#[derive(Debug)]
pub(crate) enum Returned {
    Run(&'static mut Run),
    Commissioning(&'static mut Commissioning),
}

/// How things stand in the interrupt.
#[derive(Debug)]
pub(crate) struct Standing {
    /// The fault that holds.
    pub(crate) fault: Option<Fault>,
    /// How the last run ended.
    pub(crate) ended: Option<Ended>,
    /// What has ended, or was not begun.
    pub(crate) returned: Option<Returned>,
    /// Where a commissioning stands that is under way.
    pub(crate) phase: Option<Phase>,
    /// Whether it is over and holds the servo for a loop to go on.
    pub(crate) waits: bool,
    /// The stops that were obeyed.
    pub(crate) stops: u32,
    /// What happened without being a fault.
    pub(crate) counts: Counts,
}

/// What happened without being a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Counts {
    /// What the identifier noticed since the start.
    pub(crate) noticed: Noticed,
    /// Samples that ended too late since the start.
    pub(crate) overruns: u32,
    /// Events that found no room since the drive was switched on.
    pub(crate) dropped: u32,
}

/// A sample as the interrupt knows it, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shown {
    /// Samples since the start.
    pub(crate) sample: u32,
    /// What the loop has learnt.
    pub(crate) learnt: Learnt,
    /// Position error, counts.
    pub(crate) error: f32,
    /// Counts from where the servo started.
    pub(crate) count: i32,
    /// Command, command units.
    pub(crate) command: f32,
    /// Output error, counts.
    pub(crate) output_error: f32,
    /// What happened without being a fault.
    pub(crate) counts: Counts,
}

/// A sample of a commissioning as the interrupt knows it, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moved {
    /// Where it stands.
    pub(crate) phase: Phase,
    /// Samples since it began.
    pub(crate) sample: u32,
    /// The last count from where it began.
    pub(crate) count: i32,
    /// The command that acts, command units; none: the servo is let go.
    pub(crate) command: Option<f32>,
    /// Blocks of the record of this motion.
    pub(crate) recorded: u16,
}

impl Moved {
    /// Before it begins.
    pub(crate) const NOT_YET: Self = Self {
        phase: Phase::Idle,
        sample: 0,
        count: 0,
        command: None,
        recorded: 0,
    };

    /// Takes in a sample.
    #[inline]
    pub(crate) fn note(&mut self, step: &CommissionStep<f32>, count: Option<i32>) {
        self.phase = step.phase;
        self.sample = self.sample.wrapping_add(1);
        self.count = count.unwrap_or(self.count);
        self.command = step.command;
        match step.finding {
            Some(RecordEvent::Begins(_)) => self.recorded = 0,
            Some(RecordEvent::Block(_)) => self.recorded = self.recorded.saturating_add(1),
            Some(RecordEvent::Ended) | None => {}
        }
    }
}

impl Counts {
    /// Those of a run begin with it.
    pub(crate) fn start(&mut self) {
        *self = Self {
            dropped: self.dropped,
            ..Self::default()
        };
    }

    #[inline]
    pub(crate) fn notice(&mut self, event: identifier::Event) {
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
