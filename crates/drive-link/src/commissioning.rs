use core::fmt;

use commissioning::{Phase, TrialResult};
use identifier_core::parameters::IdentifiedServo;
use identifier_core::reason::Reason;
use identifier_core::settings::ControllerSettings;
use identifier_core::tuning::{Tuning, TuningError};
use serde::{Deserialize, Serialize};

use crate::settings::Name;

/// The reason for which a commissioning found no gains, with the sufficient figure.
pub type NoGains = TuningError<Name>;

/// A commissioning under way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Its phase.
    pub phase: Phase,
    /// Samples since it began.
    pub sample: u32,
    /// Position, rad from where it began.
    pub position: f32,
    /// The command that acts, command units; none while the servo is disabled.
    pub command: Option<f32>,
    /// Blocks of the record of this motion so far.
    pub recorded: u16,
    /// b and its standard error, rad/s² per command unit, once there is a fit.
    pub gain: Option<[f32; 2]>,
}

/// Phase, or end, of a commissioning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Commissioning {
    /// Its phase.
    pub phase: Phase,
    /// The reason for an end without new gains.
    pub reason: Option<Reason>,
}

/// The outcome of a commissioning.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Its end and the reason.
    pub commissioning: Commissioning,
    /// The servo, if it was identified.
    pub servo: Option<IdentifiedServo>,
    /// The gains that were found, with their predicted response.
    pub tuning: Option<Tuning>,
    /// The reason for no gains, with the possible figure.
    pub no_gains: Option<NoGains>,
    /// The predicted figures as measured in the trial.
    pub trial: Option<TrialResult>,
    /// Standard deviation of the encoder's noise at rest before the first motion, rad; 0 where rounding hides it.
    pub noise: f64,
    /// True once the gains survive a loss of power: they are saved when the servo is disabled.
    pub kept: bool,
}

/// The gains in force: a start closes the loop with them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Gains {
    /// The PID with its limits.
    pub controller: ControllerSettings,
    /// The cut-off of its velocity estimate, rad/s.
    pub cutoff: f64,
    /// Where they are from.
    pub origin: Origin,
}

/// Where gains come from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Origin {
    /// They were configured.
    Given,
    /// A commissioning found and validated them.
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
        let own = &self.controller;
        write!(
            f,
            "kp {:.5}, kd {:.5}, ki {:.5}, velocity cut-off {:.1} rad/s, ",
            own.kp, own.kd, own.ki, self.cutoff
        )?;
        if own.reference_filter > 0.0 {
            write!(f, "reference filter {:.5} s, ", own.reference_filter)?;
        }
        if own.notch > 0.0 {
            write!(f, "notch {:.1} rad/s, ", own.notch)?;
        }
        if let Some(led) = own.feed_forward {
            write!(f, "feed-forward at {:.1} rad/s, ", led.bandwidth)?;
        }
        write!(f, "{}", self.origin)
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
