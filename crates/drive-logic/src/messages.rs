//! Orders of the background and events of the interrupt.

use commissioning::Phase;
use drive_link::{Ended, Fault, Noticed};

use crate::brake::BrakeTimes;
use crate::built::Part;
use crate::closed_loop::Settled;
use crate::commissioning::Commissioning;
use crate::guide::{Origin, Target};
use crate::run::Run;
use crate::telemetry::{CommissionSample, Counts, RunSample};

/// A mode that drives the servo. The background builds it, the interrupt borrows it, and it returns when it has ended
/// or was not begun.
#[derive(Debug)]
pub(crate) enum Mode {
    /// A loop that is closed.
    Run(&'static mut Run),
    /// A commissioning.
    Commissioning(&'static mut Part<Commissioning>),
}

impl Mode {
    /// The times of the axis's brake, if it has one.
    pub(crate) fn brake(&self) -> Option<BrakeTimes> {
        match self {
            Self::Run(run) => run.brake(),
            Self::Commissioning(commissioning) => commissioning.brake(),
        }
    }

    /// True if its last command holds the servo.
    pub(crate) fn holds(&self) -> bool {
        match self {
            Self::Run(run) => run.has_run(),
            Self::Commissioning(commissioning) => commissioning.holds(),
        }
    }

    /// Holds the servo at rest while its brake opens, for this many samples.
    pub(crate) fn wait(&mut self, samples: u32) {
        match self {
            Self::Run(run) => run.wait(),
            Self::Commissioning(commissioning) => commissioning.wait(samples),
        }
    }

    /// Holds the servo for an end while its brake closes.
    pub(crate) fn hold(&mut self, ended: Ended) {
        match self {
            Self::Run(run) => run.hold(ended),
            Self::Commissioning(commissioning) => commissioning.hold(ended),
        }
    }
}

/// An order of the background.
#[derive(Debug)]
pub(crate) enum Order {
    /// Drive the servo from its place at rest.
    Begin(Mode),
    /// Drive the servo with this mode and end the present one. A commissioning replaces the run, and a run replaces a
    /// commissioning that holds the servo.
    Replace(Mode),
    /// Send the servo to a target.
    Target(Target),
    /// Drive the axis home.
    Home,
    /// Clear a fault, if its cause is gone.
    Clear,
    /// Report samples at this interval; 0 for none.
    Watch(u16),
}

/// An event of the interrupt.
#[derive(Debug)]
pub(crate) enum Event {
    /// The state: after every change, and after every order that asks for it.
    State(InterruptState),
    /// A sample of a run.
    Run(RunSample),
    /// A sample of a commissioning.
    Commissioning(CommissionSample),
    /// An examination of a run's estimates.
    Examined(Examination),
}

/// An examination of a run's estimates.
#[derive(Debug)]
pub(crate) struct Examination {
    /// The estimates; none if they have not settled.
    pub(crate) settled: Option<Settled>,
    /// Events of the identifier since the start.
    pub(crate) noticed: Noticed,
}

/// The state of the interrupt.
#[derive(Debug)]
pub(crate) struct InterruptState {
    /// The fault that holds.
    pub(crate) fault: Option<Fault>,
    /// How the last run ended.
    pub(crate) ended: Option<Ended>,
    /// A mode that has ended, or was not begun.
    pub(crate) returned: Option<Mode>,
    /// The phase of a commissioning that is under way.
    pub(crate) phase: Option<Phase>,
    /// The origin of targets and travel, in a run.
    pub(crate) origin: Option<Origin>,
    /// The distance of the index pulse from the edge of the home switch, counts, if a run has found both.
    pub(crate) index_from_edge: Option<i32>,
    /// The servo is held until its brake has closed.
    pub(crate) closes_brake: bool,
    /// A commissioning is over and holds the servo for a run to resume.
    pub(crate) awaits_resume: bool,
    /// The stops that were obeyed.
    pub(crate) stops: u32,
    /// Events that are no faults.
    pub(crate) counts: Counts,
}
