use identifier_core::commission::{
    CommissionReading, CommissionSettings, HoldingGains, StopReason,
};
use identifier_core::identifier::Event;
use serde::{Deserialize, Serialize};

use crate::message::Estimates;
use crate::no_gains::NoGains;
use crate::settings::{LoopSettings, NotAllowed};

/// What a host asks of a processor in the loop: the plant is on the host, the loop on the chip.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[expect(
    clippy::large_enum_variant,
    reason = "settings are sent once, and there is no heap to put them on"
)]
pub enum Question {
    /// Begin anew with these settings, at rest at count zero. Answered by [`Answer::Ready`].
    Begin(LoopSettings),
    /// The next sample. Answered by [`Answer::Command`]; said again with the number of the sample
    /// before, the same answer comes again and nothing moves.
    Sample {
        /// Number of the sample, from 0.
        number: u32,
        /// Where the servo is to be: counts, wrapping at 32 bits as the encoder's do.
        setpoint: i32,
        /// What is added to them, counts: a double, which every format's offset fits.
        offset: f64,
        /// The encoder's count.
        count: i32,
    },
    /// Begin a commissioning anew, where the servo stands at its first sample. Answered by
    /// [`Answer::Ready`].
    BeginCommission {
        /// What it is told.
        settings: CommissionSettings,
        /// The gains that hold the servo before, if there are any.
        before: Option<HoldingGains>,
        /// The command that they hold it with, command units.
        held: Option<f64>,
    },
    /// The next sample of a commissioning. Answered by [`Answer::Commissioned`], as a sample is.
    CommissionSample {
        /// Number of the sample, from 0.
        number: u32,
        /// The encoder's count; none if it gave no valid reading.
        count: Option<i32>,
        /// Whether the sample before ended too late.
        late: bool,
        /// What somebody wants it to end for.
        stop: Option<StopReason>,
    },
}

/// What the chip answers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[expect(
    clippy::large_enum_variant,
    reason = "what was found is told rarely, and there is no heap to put it on"
)]
pub enum Answer {
    /// The loop is built.
    Ready,
    /// The loop was not built, or the sample is not the next one.
    Refused(Refused),
    /// What the loop did in a sample.
    Command {
        /// Number of the sample.
        number: u32,
        /// What it did.
        reading: Reading,
    },
    /// What a commissioning did in a sample.
    Commissioned {
        /// Number of the sample.
        number: u32,
        /// What it did.
        step: CommissionReading,
        /// Why it found no gains, if that is why it has ended.
        no_gains: Option<NoGains>,
    },
}

/// Why a question was not answered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Refused {
    /// A setting is not allowed.
    Setting(NotAllowed),
    /// There is no loop yet: begin first.
    NotBegun,
    /// It was begun as a loop and not as a commissioning, or the other way round.
    BegunOtherwise,
    /// Not the sample that comes next.
    OutOfStep {
        /// The one that does.
        next: u32,
    },
    /// Controller or identifier refuse setpoint or count.
    OutOfReach,
}

/// What a loop did in a sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// Command, command units.
    pub command: f64,
    /// Output error, counts.
    pub output_error: f64,
    /// The estimates, SI.
    pub estimates: Estimates,
    /// What the identifier noticed besides.
    pub event: Event,
}
