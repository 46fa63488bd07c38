//! What the supervisor orders, and what the interrupt tells.

use drive_link::{Ended, Fault, Noticed};
use identifier_core::identifier;

use crate::closed_loop::Learnt;
use crate::run::Run;

/// What the supervisor orders.
#[derive(Debug)]
pub(crate) enum Order {
    /// Close this loop where the servo stands.
    Run(&'static mut Run),
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
}

/// How things stand in the interrupt.
#[derive(Debug)]
pub(crate) struct Standing {
    /// The fault that holds.
    pub(crate) fault: Option<Fault>,
    /// How the last run ended.
    pub(crate) ended: Option<Ended>,
    /// The run that has ended, or was not begun.
    pub(crate) returned: Option<&'static mut Run>,
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
