use core::fmt;

use commissioning::CommissionSettings;
use commissioning::servo_change::ServoChange;
use heapless::String;
use identifier_core::parameters::{PerParameter, ServoParameters};
use identifier_core::reason::{Reason, StopCategory};
use serde::{Deserialize, Serialize, Serializer};

use crate::commissioning::{Commissioning, Gains, Outcome, Progress};
use crate::guidance::Home;
use crate::motion_record::MotionRecord;
use crate::settings::{NotAllowed, Settings};
use crate::term_sizes::TermSizes;

/// The version of these messages, which every request but a stop carries. A drive rejects those of another.
///
/// Above every index that a command had before requests carried it.
pub const PROTOCOL: u8 = 25;

/// The second and last byte of a stop, in every version from 18 on.
pub(crate) const STOP: u8 = 6;

/// A [`Reason`] for which a drive disables its stage until it is cleared.
pub type Fault = Reason;

/// A message of the host: a command, and the number that the answer will carry.
///
/// A command that may move the axis is an order. It has a number of its own, above that of every order before it, and acts
/// once: a frame that comes late or twice has one of before.
///
/// | byte | of a stop | of any other request |
/// |---|---|---|
/// | 0 | its number | its number |
/// | 1 | 6 | [`PROTOCOL`] |
/// | 2–… | | the number of the order, 0 of what moves nothing; the command |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// The host's number for it.
    pub id: u8,
    /// The number of an order: that after [`Status::order`], or after the last that the host has given since.
    pub order: u32,
    /// The command.
    pub command: Command,
}

impl Request {
    /// One that moves nothing.
    #[must_use]
    pub const fn without_order(id: u8, command: Command) -> Self {
        let order = 0;
        Self { id, order, command }
    }
}

/// Commands of the host.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[expect(
    clippy::large_enum_variant,
    reason = "settings are sent rarely, and there is no heap to put them on"
)]
pub enum Command {
    /// Reports the state: answered by [`Report::Status`].
    Hello,
    /// Configures the drive; only while the servo is disabled.
    Configure(Settings),
    /// Reports the settings: answered by [`Report::Settings`].
    Show,
    /// Closes the loop at the servo's position, and identifies.
    Start,
    /// Sends the servo to a target, rad from home, or from where the run started if homing is not configured.
    Target(f64),
    /// Drives the axis home, in a run: targets and travel count from its origin afterwards.
    Home,
    /// Clears a fault whose cause is gone.
    Clear,
    /// Reports a sample at this interval, samples; 0 for never.
    Watch(u16),
    /// Saves settings and estimates, so that they survive a loss of power; only while the servo is disabled.
    Save,
    /// Identifies the servo, tunes the gains to a goal, validates them on the servo and saves them. It begins from
    /// rest, or suspends the running loop, which resumes at the end. The delay that is given adds to the drive's own.
    /// From rest, settings and estimates are saved first.
    Commission(CommissionSettings),
    /// Reports the last commissioning: answered by [`Report::Outcome`].
    Outcome,
    /// Reports the record of its last probing motion from a block on: answered by [`Report::MotionRecord`].
    MotionRecord(u16),
    /// Reports the test of the board: answered by [`Report::BoardTest`].
    BoardTest,
    /// Sends the servo to a target, rad from where the run started, whether it was homed or not.
    RelativeTarget(f64),
    /// The host that drives the servo is still there: the link timeout begins anew. Answered as [`Hello`](Self::Hello).
    KeepAlive,
    /// Disables the servo at once: no command before it still moves the servo. Its bytes are those of a [`Request`].
    #[serde(skip)]
    Stop,
}

impl Command {
    /// True if it comes from a host that drives the servo: it begins the link timeout anew. A look at the drive does not.
    #[must_use]
    pub const fn keeps_alive(&self) -> bool {
        matches!(self, Self::KeepAlive) || self.may_move()
    }

    /// True if it may move the axis: only the last and whole request of an undisturbed line does.
    #[must_use]
    pub const fn may_move(&self) -> bool {
        match self {
            Self::Start
            | Self::Target(_)
            | Self::RelativeTarget(_)
            | Self::Home
            | Self::Commission(_) => true,
            Self::Hello
            | Self::Configure(_)
            | Self::Show
            | Self::Clear
            | Self::Watch(_)
            | Self::Save
            | Self::Outcome
            | Self::MotionRecord(_)
            | Self::BoardTest
            | Self::KeepAlive
            | Self::Stop => false,
        }
    }
}

impl Serialize for Request {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.command {
            Command::Stop => (self.id, STOP).serialize(serializer),
            command => (self.id, PROTOCOL, self.order, command).serialize(serializer),
        }
    }
}

/// Messages of a drive.
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
        /// The reason.
        refusal: Refusal,
    },
    /// The state of the drive.
    Status {
        /// The request's number; none for a report of its own accord.
        id: Option<u8>,
        /// The state.
        status: Status,
    },
    /// The settings in force.
    Settings {
        /// The request's number.
        id: u8,
        /// The settings.
        settings: Settings,
    },
    /// A sample of a run.
    Snapshot(Snapshot),
    /// A sample of a commissioning.
    Progress(Progress),
    /// The outcome of the last commissioning.
    Outcome {
        /// The request's number.
        id: u8,
        /// The outcome.
        outcome: Outcome,
    },
    /// A part of the record of the last commissioning.
    MotionRecord {
        /// The request's number.
        id: u8,
        /// The part.
        part: MotionRecord,
    },
    /// The drive disabled its servo for a fault.
    Fault(Fault),
    /// The test of the board.
    BoardTest {
        /// The request's number.
        id: u8,
        /// Its result at the last boot.
        test: BoardTest,
    },
}

/// A known computation as the drive's chip did it at its boot, before anything interrupts: samples of controller and
/// identifier over a fixed motion.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct BoardTest {
    /// The board, by the name of its feature in the firmware.
    pub board: String<24>,
    /// The servo is simulated on the chip, and no output is driven.
    pub servo_on_chip: bool,
    /// The bits of the estimates a, b and Coulomb friction as doubles, the same on every machine.
    pub bits: [u64; 3],
    /// Cycles of a sample; none where no counter runs.
    pub cycles: Option<Cycles>,
}

/// Cycles of a sample of the [`BoardTest`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cycles {
    /// Their mean.
    pub mean: u32,
    /// Their maximum.
    pub most: u32,
}

/// Cycles of the sample interrupt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct InterruptCycles {
    /// Those of the last one.
    pub last: u32,
    /// Those of the longest one since the start.
    pub longest: u32,
}

/// The state of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// Disabled, running, commissioning or faulted.
    pub state: State,
    /// The record in the store.
    pub kept: Kept,
    /// The servo is simulated, and no output is driven.
    pub simulated: bool,
    /// True if the drive was configured for its servo, now or before the last save. Without that it
    /// does not start.
    pub configured: bool,
    /// The number of the last order since the drive was switched on; 0 before the first.
    pub order: u32,
    /// How the last run ended since the drive was switched on.
    pub ended: Option<Ended>,
    /// Phase, or end, of the last commissioning.
    pub commissioning: Option<Commissioning>,
    /// The gains in force, if there are any.
    pub gains: Option<Gains>,
    /// From the reading of the encoder to the change of the output, s.
    pub command_delay: f32,
    /// The origin of targets and travel.
    pub home: Home,
    /// From the edge of the home switch to the index pulse, rad, by the last homing that found both. Within an eighth of a
    /// revolution it is refused.
    pub index_from_edge: Option<f32>,
    /// Estimates of the last run, or those that were saved.
    pub estimates: Option<Estimates>,
    /// Why the estimator of the last run has no first fit after a second of motion.
    #[serde(rename = "first_fit_rejection")]
    pub rejection_reason: Option<Reason>,
    /// Standard deviation of the encoder's noise in motion, counts, by the first fit of the last run. It is 0.29, that
    /// of rounding alone, unless it is clearly larger.
    pub noise: Option<f32>,
    /// The difference between the servo of this run, or of the last, and the one for which its gains were commissioned.
    /// [`Settings::servo_changes`] enables it.
    pub servo_change: Option<ServoChange>,
    /// Events of the identifier since the start, as last reported.
    pub noticed: Noticed,
    /// Samples that ended too late since the start.
    pub overruns: u32,
    /// Samples that were not reported for want of room on the line.
    pub dropped: u32,
    /// Frames that could not be decoded.
    pub garbled: u32,
    /// Findings of the boot that are no faults.
    pub boot: BootChecks,
    /// Disturbances of the line: bytes that were lost, framing errors and breaks.
    pub disturbed: u32,
    /// Cycles of the sample interrupt; none where no counter runs.
    pub interrupt_cycles: Option<InterruptCycles>,
}

/// Findings of the boot that are no faults.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct BootChecks {
    /// The chip resets itself before its supply is too low for it. If not, its option bytes are to be set.
    pub resets_in_time: bool,
    /// The program in the flash was checked against its seal, which it has.
    pub image_checked: bool,
}

impl BootChecks {
    /// Nothing found.
    pub const PASSED: Self = Self {
        resets_in_time: true,
        image_checked: true,
    };
}

/// Counts of an identifier's events.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Noticed {
    /// First fits that were accepted.
    pub started: u32,
    /// Steps of the load.
    pub load_steps: u32,
    /// Samples in which the servo did not follow its command or, by some estimators, times that this began.
    pub not_following: u32,
    /// Times that the model's friction was too large and was lowered.
    pub friction_lowered: u32,
    /// Times that the model had to be started again.
    pub restarted: u32,
}

/// State of the store.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Kept {
    /// Nothing: the settings are the built-in ones.
    Nothing,
    /// A record, which holds now.
    Record,
    /// A record of the version before, which holds now, but for the loads that runs had learnt.
    WithoutLoads,
    /// A record of another version: left alone, the built-in settings hold.
    OtherVersion,
    /// Damaged records only: the built-in settings hold.
    Damaged,
    /// A record of another board, or of a build with another servo: left alone, the built-in settings hold.
    OtherBuild {
        /// The fingerprint of its build.
        stored: u32,
        /// That of this one.
        own: u32,
    },
}

impl fmt::Display for Kept {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = match self {
            Self::OtherBuild { stored, own } => {
                return write!(
                    f,
                    "the stored record is of build {stored:08x}, another board or another servo, and this is build \
                     {own:08x}: the built-in settings are in use; flash that build again, or configure and save"
                );
            }
            Self::Nothing => "nothing is stored yet",
            Self::Record => "a record is stored",
            Self::WithoutLoads => {
                "the stored record is of the version before: its settings and parameters are in use, the load that a run \
                 had learnt is not; a save replaces it"
            }
            Self::OtherVersion => {
                "the stored record is of another version: the built-in settings are in use, and a save replaces the \
                 record"
            }
            Self::Damaged => {
                "the stored record is damaged: the built-in settings are in use, and a save replaces it"
            }
        };
        f.write_str(text)
    }
}

/// Activity of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum State {
    /// The servo is disabled, and the drive ready.
    #[serde(rename = "Released")]
    Disabled,
    /// The loop is closed.
    Running,
    /// A commissioning moves or holds the servo.
    Commissioning,
    /// The servo is disabled, and stays so until the fault is cleared.
    Faulted(Fault),
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Disabled => f.write_str("disabled: the servo coasts"),
            Self::Running => f.write_str("running: the loop is closed"),
            Self::Commissioning => f.write_str("commissioning: the servo moves by itself"),
            Self::Faulted(fault) if fault.needs_reset() => fault.fmt(f),
            Self::Faulted(fault) => write!(f, "{fault}, then clear"),
        }
    }
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Ended {
    /// By a stop.
    Stopped,
    /// Its time was over: the servo came to rest and was disabled.
    Over,
    /// By a fault.
    Faulted(Fault),
}

impl Ended {
    /// The fault, if it was one.
    #[must_use]
    pub const fn fault(self) -> Option<Fault> {
        match self {
            Self::Stopped | Self::Over => None,
            Self::Faulted(fault) => Some(fault),
        }
    }

    /// An end in which another one came: the graver fault of both, if there is one.
    #[must_use]
    pub fn joined(self, other: Self) -> Self {
        Fault::graver(self.fault(), other.fault()).map_or(self, Self::Faulted)
    }

    /// How an axis with a holding brake is stopped at such an end.
    #[must_use]
    pub const fn stop_category(self) -> StopCategory {
        match self {
            Self::Stopped | Self::Over => StopCategory::Controlled,
            Self::Faulted(fault) => fault.stop_category(),
        }
    }
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stopped => f.write_str("the last run was stopped"),
            Self::Over => f.write_str("the last run ended when its time was over"),
            Self::Faulted(fault) => write!(f, "the last run ended with fault {}", fault.number()),
        }
    }
}

/// Reasons for not carrying out a request.
#[derive(Debug, Clone, PartialEq, thiserror::Error, Serialize, Deserialize)]
pub enum Refusal {
    /// It is of another version, or its command is longer or shorter than in this one. The first, so that a host of any
    /// later version reads it, also with the check of a version up to 21.
    #[error(
        "the drive speaks version {spoken} of the protocol, and the request of {bytes} bytes is of version {given} or \
         damaged: use the program of the firmware's version, or flash the firmware of this one"
    )]
    NotUnderstood {
        /// [`PROTOCOL`] of the drive.
        spoken: u8,
        /// The byte of the request in its place.
        given: u8,
        /// Bytes of the request.
        bytes: u16,
    },
    /// The drive was never configured for its servo: configure first.
    #[error("the drive is not configured yet: configure it first")]
    NotConfigured,
    /// A stop came after it, and before it was done.
    #[error("a stop came directly after the request: send it again")]
    Overtaken,
    /// Bytes were lost on the line around it or after it, and a stop may have been among them.
    #[error(
        "bytes were lost on the line, possibly those of a stop: send the request again; if this returns, check the \
         line's wires, ground and baud rate, and send with pauses"
    )]
    LineDisturbed,
    /// The servo must be disabled: stop first.
    #[error("the servo must be disabled first: stop")]
    Running,
    /// The loop must be closed: start first.
    #[error("the loop must be closed first: start")]
    NotRunning,
    /// A commissioning ran and was ended for it: ask again when the servo is at rest.
    #[error(
        "a commissioning was running and was ended first: send the request again at standstill"
    )]
    EndedCommissioning,
    /// There was no commissioning.
    #[error("the servo was never commissioned")]
    NeverCommissioned,
    /// The fault must be cleared first.
    #[error("{}", State::Faulted(*.0))]
    Faulted(Fault),
    /// A setting is not allowed.
    #[error(transparent)]
    Setting(NotAllowed),
    /// The target is outside the travel.
    #[error("the target must be from {} to {} rad", within[0], within[1])]
    TooFar {
        /// The lowest and the highest target, rad.
        within: [f64; 2],
    },
    /// The settings have no way to the home position: configure it first.
    #[error("homing is not configured: configure it with --home-seek first")]
    NoHoming,
    /// The axis is on its way home: ask again when it is there.
    #[error("the axis is homing: send the request again when it is home")]
    Homing,
    /// Targets come from outside: configure the line as their source first.
    #[error("the targets come from the step input: configure it with --source line first")]
    TargetsFromOutside,
    /// The interrupt has not yet done the command before: ask again.
    #[error("the previous request is not done yet: send this one again")]
    Busy,
    /// The store did not take the record; the one before it still holds.
    #[error("the flash did not store the record; the previous one is still valid")]
    NotKept,
    /// The flash must be erased for the record, and the axis does not stand.
    #[error(
        "the flash must be erased first, which needs standstill: send the request again at standstill"
    )]
    NotAtRest,
    /// The axis has a home position, which is not known.
    #[error(
        "the axis is not homed: home it first, or send a relative target, which counts from where the run started"
    )]
    NotHomed,
    /// The disabled axis moves too fast to be driven.
    #[error(
        "the axis moves at {speed:.1} rad/s, and {most} rad/s are allowed: wait until it is slower, and start then"
    )]
    Moves {
        /// Its speed, rad/s.
        speed: f64,
        /// The largest allowed, rad/s.
        most: f64,
    },
    /// The homed axis is outside the travel.
    #[error(
        "the axis is at {position:.4} rad, outside the travel from {} to {} rad: move it back by hand, or allow more \
         travel",
        travel[0],
        travel[1]
    )]
    OutsideTravel {
        /// Its position, rad from the origin.
        position: f64,
        /// The travel, rad.
        travel: [f64; 2],
    },
    /// An order of this number or a later one was given before: it came twice or late, or another host gave one since.
    #[error(
        "an order of this number or a later one was given before: ask for the state, and send it again with the next number"
    )]
    GivenBefore,
}

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
    /// Its parameters.
    pub servo: ServoParameters,
    /// True for those at a bound: such a value is no result.
    pub at_bounds: PerParameter<bool>,
    /// Their standard errors, where they are known; a snapshot has none.
    pub standard_errors: Option<ServoParameters>,
    /// The sizes of the terms, of a model that has some.
    pub terms: Option<TermSizes>,
}
