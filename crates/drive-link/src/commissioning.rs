use core::fmt;

use identifier_core::ControllerSettings;
use identifier_core::commission::{IdentifiedServo, Phase, Reason, TrialResult};
use identifier_core::tuning::Tuning;
use serde::{Deserialize, Serialize};

use crate::no_gains::NoGains;

/// A commissioning under way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Where it stands.
    pub phase: Phase,
    /// Samples since it began.
    pub sample: u32,
    /// Position, rad from where it began.
    pub position: f32,
    /// The command that acts, command units; none: the servo is let go.
    pub command: Option<f32>,
    /// Pieces of the record of this motion so far.
    pub recorded: u16,
    /// b and its standard error, rad/s² per command unit, once there is a fit.
    pub gain: Option<[f32; 2]>,
}

/// How a commissioning stands or ended, in short.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Commissioning {
    /// Where it stands.
    pub phase: Phase,
    /// Why it ended without new gains, if it did.
    pub reason: Option<Reason>,
}

/// What the last commissioning came to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Its end and the reason.
    pub commissioning: Commissioning,
    /// The servo, as far as it became known.
    pub servo: Option<IdentifiedServo>,
    /// The gains that were found, with what they promise.
    pub tuning: Option<Tuning>,
    /// Why there are none, where that is the reason, and which would do.
    pub no_gains: Option<NoGains>,
    /// What was measured of that in the trial.
    pub trial: Option<TrialResult>,
    /// Whether the gains survive a loss of power: they are kept when the servo is let go.
    pub kept: bool,
}

/// The gains that hold: with them a start closes the loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Gains {
    /// The PID with its limits.
    pub controller: ControllerSettings,
    /// The cut-off of its velocity estimate, rad/s.
    pub cutoff: f64,
    /// Where they come from.
    pub origin: Origin,
}

/// Where gains come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Origin {
    /// Somebody gave them.
    Given,
    /// A commissioning found and proved them.
    Commissioned,
}

impl fmt::Display for Commissioning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.reason {
            Some(reason) => write!(f, "{}: {reason}", self.phase.name()),
            None => f.write_str(self.phase.name()),
        }
    }
}

impl fmt::Display for Gains {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            controller: ControllerSettings { kp, kd, ki, .. },
            cutoff,
            origin,
        } = self;
        write!(
            f,
            "kp {kp:.5}, kd {kd:.5}, ki {ki:.5}, velocity cut-off {cutoff:.1} rad/s, {origin}"
        )
    }
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Given => "as given",
            Self::Commissioned => "as commissioned",
        })
    }
}
