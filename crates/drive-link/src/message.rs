use core::fmt;

use identifier_core::commission::CommissionSettings;
use identifier_core::commission::Reason;
use identifier_core::parameters::{PerParameter, ServoParameters};
use serde::{Deserialize, Serialize};

use crate::commissioning::{Commissioning, Gains, Outcome, Progress};
use crate::settings::{NotAllowed, Settings};

/// The version of these messages: a host and a drive of different versions do not talk.
pub const PROTOCOL: u8 = 8;

/// A [`Reason`] for which a drive disables its stage until it is cleared.
pub type Fault = Reason;

/// What the host says: a command, and the number that the answer will carry.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// The host's number for it.
    pub id: u8,
    /// What is asked for. Saying it twice does what saying it once does.
    pub command: Command,
}

/// What a drive can be asked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[expect(
    clippy::large_enum_variant,
    reason = "settings are sent rarely, and there is no heap to put them on"
)]
pub enum Command {
    /// Who is there? Answered by [`Report::Status`].
    Hello,
    /// Take these settings; only while the servo is let go.
    Configure(Settings),
    /// What are the settings? Answered by [`Report::Settings`].
    Show,
    /// Close the loop where the servo stands, and identify.
    Start,
    /// Send the servo to a target, rad from where it started.
    Target(f64),
    /// Let the servo go, at once: nothing that was asked before it still moves the servo.
    Stop,
    /// Forget a fault, and let the self-test decide.
    Clear,
    /// Report every so many samples; 0 for never.
    Watch(u16),
    /// Keep settings and estimates through a loss of power; only while the servo is let go.
    Save,
    /// Come to know the servo, tune to a goal, prove it and keep it, from rest or in place of the loop that
    /// runs, which goes on at the end. The delay that is given adds to the drive's own. From rest, settings
    /// and estimates are kept first.
    Commission(CommissionSettings),
    /// What did the last commissioning come to? Answered by [`Report::Outcome`].
    Outcome,
}

/// What a drive says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[expect(
    clippy::large_enum_variant,
    reason = "settings are sent rarely, and there is no heap to put them on"
)]
pub enum Report {
    /// A request was done.
    Done {
        /// The request's number.
        id: u8,
    },
    /// A request was not done, and nothing changed.
    Refused {
        /// The request's number.
        id: u8,
        /// Why.
        refusal: Refusal,
    },
    /// Who is there, and how.
    Status {
        /// The request's number; none for a report of its own accord.
        id: Option<u8>,
        /// How.
        status: Status,
    },
    /// The settings that hold.
    Settings {
        /// The request's number.
        id: u8,
        /// They.
        settings: Settings,
    },
    /// The loop in motion.
    Snapshot(Snapshot),
    /// A commissioning under way.
    Progress(Progress),
    /// What the last commissioning came to.
    Outcome {
        /// The request's number.
        id: u8,
        /// It.
        outcome: Outcome,
    },
    /// The drive let its servo go.
    Fault(Fault),
}

/// Who is there, and how.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// [`PROTOCOL`] of the drive.
    pub protocol: u8,
    /// What it does.
    pub state: State,
    /// What the store holds.
    pub kept: Kept,
    /// Whether somebody has said what the servo is, now or before the last save. Without that the
    /// drive does not start.
    pub configured: bool,
    /// How the last run ended since the drive was switched on.
    pub ended: Option<Ended>,
    /// How the last commissioning stands or ended.
    pub commissioning: Option<Commissioning>,
    /// The gains that hold, if there are any.
    pub gains: Option<Gains>,
    /// From the reading of the encoder to the change of the output, s.
    pub command_delay: f32,
    /// What the last run found, or the one that was kept.
    pub estimates: Option<Estimates>,
    /// What the identifier noticed since the start, as last told.
    pub noticed: Noticed,
    /// Samples that ended too late since the start, as last told.
    pub overruns: u32,
    /// Samples that were to be shown and found no room.
    pub dropped: u32,
    /// Frames that were not understood.
    pub garbled: u32,
}

/// How often an identifier noticed something besides learning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Noticed {
    /// First fits that were found good.
    pub started: u32,
    /// Steps of the load.
    pub load_steps: u32,
    /// Samples in which the servo did not follow its command, or a beginning of that.
    pub not_following: u32,
    /// Times that the model's friction was too large and was lowered.
    pub friction_lowered: u32,
    /// Times that the model had to be started again.
    pub restarted: u32,
}

/// What the store holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Kept {
    /// Nothing: the settings are the built-in ones.
    Nothing,
    /// A record, which holds now.
    Record,
    /// A record of another version: left alone, the built-in settings hold.
    OtherVersion,
    /// Damaged records only: the built-in settings hold.
    Damaged,
}

impl fmt::Display for Kept {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Nothing => "nothing is kept yet",
            Self::Record => "a record is kept",
            Self::OtherVersion => {
                "the record that is kept is of another version: the built-in settings hold, and a \
                 save replaces it"
            }
            Self::Damaged => {
                "what is kept is damaged: the built-in settings hold, and a save replaces it"
            }
        })
    }
}

/// What a drive does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum State {
    /// The servo is let go, and everything is ready.
    Released,
    /// The loop is closed.
    Running,
    /// A commissioning moves or holds the servo.
    Commissioning,
    /// The servo is let go, and stays so until the fault is cleared.
    Faulted(Fault),
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Released => f.write_str("released: the servo coasts"),
            Self::Running => f.write_str("running: the loop is closed"),
            Self::Commissioning => f.write_str("commissioning: it moves on its own"),
            Self::Faulted(fault) if fault.needs_reset() => fault.fmt(f),
            Self::Faulted(fault) => write!(f, "{fault}, then clear"),
        }
    }
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Ended {
    /// Somebody asked for it.
    Stopped,
    /// Its time was over: it came to rest and was let go.
    Over,
    /// By a fault.
    Faulted(Fault),
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stopped => f.write_str("the last run was stopped"),
            Self::Over => f.write_str("the last run ended when its time was over"),
            Self::Faulted(fault) => write!(f, "the last run ended by fault {}", fault.number()),
        }
    }
}

/// Why a request was not done.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Refusal {
    /// Nobody has said yet what the servo is: configure first.
    NotConfigured,
    /// A stop came after it, and before it was done.
    Overtaken,
    /// It needs the servo let go: stop first.
    Running,
    /// It needs the loop closed: start first.
    NotRunning,
    /// A commissioning ran and was ended for it: ask again when the servo is at rest.
    EndedCommissioning,
    /// There was no commissioning.
    NeverCommissioned,
    /// The fault must be cleared first.
    Faulted(Fault),
    /// A setting is not allowed.
    Setting(NotAllowed),
    /// The target is too far from where the servo started, rad.
    TooFar {
        /// How far it may be.
        most: f64,
    },
    /// The interrupt has not yet done what was asked before: ask again.
    Busy,
    /// The store did not take the record; the one before it still holds.
    NotKept,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotConfigured => {
                f.write_str("nobody has told the drive yet what its servo is: configure it first")
            }
            Self::Overtaken => f.write_str("a stop came right after it: ask again"),
            Self::Running => f.write_str("the servo must be let go first: stop"),
            Self::NotRunning => f.write_str("the loop must be closed first: start"),
            Self::EndedCommissioning => f.write_str(
                "a commissioning ran and was ended for it, the gains before hold: ask again when the \
                 servo is at rest",
            ),
            Self::NeverCommissioned => f.write_str("it was never commissioned"),
            Self::Faulted(fault) => State::Faulted(*fault).fmt(f),
            Self::Setting(refused) => refused.fmt(f),
            Self::TooFar { most } => write!(
                f,
                "the target must be within {most} rad of where the servo started"
            ),
            Self::Busy => f.write_str("it has not done yet what was asked before: ask again"),
            Self::NotKept => {
                f.write_str("the flash did not take the record, and the one before still holds")
            }
        }
    }
}

impl core::error::Error for Refusal {}

/// The loop at one sample, SI.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Samples since the start.
    pub sample: u32,
    /// Reference, rad from where the servo started.
    pub reference: f32,
    /// Position, rad from where the servo started.
    pub position: f32,
    /// Command, command units.
    pub command: f32,
    /// Output error, rad.
    pub output_error: f32,
    /// The estimates.
    pub estimates: Estimates,
}

/// Estimates of a servo, SI.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Estimates {
    /// a, 1/s.
    pub a: f64,
    /// b, rad/s² per command unit.
    pub b: f64,
    /// c, rad/s².
    pub coulomb: f64,
    /// d, rad/s².
    pub load: f64,
    /// Which of them stand at a bound: such a value is no result.
    pub at_bounds: PerParameter<bool>,
    /// Their standard errors, where they are known; a snapshot has none.
    pub standard_errors: Option<ServoParameters>,
}
