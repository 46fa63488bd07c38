//! Settings of what guides a run besides the targets of the host: homing, and commands from outside.

use core::fmt;

use serde::{Deserialize, Serialize};

/// Where the targets of a run come from.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub enum TargetSource {
    /// The host, over the line.
    #[default]
    Line,
    /// Pulses at the step input.
    Steps {
        /// Distance of a pulse while the direction input is high, rad; its opposite while that is low. Negative to
        /// exchange the two.
        step: f64,
    },
}

/// The motion to the home position of an axis. A switch is closed at one end of its travel.
///
/// The axis seeks the switch, or begins on it, and drives off it slowly. With an index pulse, the first one behind the
/// switch is the home position. Without it, the axis approaches slowly, and the home position is where the switch
/// closes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Homing {
    /// Velocity at which the switch is sought, rad/s: negative for one at the lower end.
    pub seek: f64,
    /// Speed at which it is left and approached, rad/s.
    pub approach: f64,
    /// Largest distance in which the switch must open when the axis drives off it, rad.
    pub clearance: f64,
    /// True if the home position is the first index pulse of the encoder behind the switch.
    pub index: bool,
    /// The origin of targets and travel, rad from the home position.
    pub offset: f64,
}

/// The origin of targets and travel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Home {
    /// The place where the run started: the axis was not homed.
    #[default]
    Unknown,
    /// The axis is on its way home.
    Sought,
    /// The home position.
    Known,
}

impl fmt::Display for TargetSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line => f.write_str("targets come from the serial line"),
            Self::Steps { step } => {
                write!(f, "targets come from the step input, {step} rad per step")
            }
        }
    }
}

impl fmt::Display for Homing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            seek,
            approach,
            clearance,
            index,
            offset,
        } = self;
        let place = if *index {
            "the index pulse after the switch"
        } else {
            "the switch"
        };
        write!(
            f,
            "homing: seeks the switch at {seek} rad/s, approaches {place} at {approach} rad/s; the switch opens \
             within {clearance} rad; the origin is {offset} rad from the home position"
        )
    }
}

impl fmt::Display for Home {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unknown => "not homed: positions count from where the run started",
            Self::Sought => "homing",
            Self::Known => "homed: positions count from the origin",
        })
    }
}
