use core::fmt;

use identifier_core::tuning::{Cap, TuningError};
use serde::{Deserialize, Serialize};

use crate::settings::NotAllowed;

/// The reason for which a commissioning found no gains, with the sufficient figure. It is the core's [`TuningError`] as
/// a message.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum NoGains {
    /// A setting is out of the range that the identified servo leaves it.
    NotAllowed(NotAllowed),
    /// The bandwidth is higher than the servo tolerates.
    TooFast {
        /// The requested bandwidth, rad/s.
        bandwidth: f64,
        /// The largest possible one, rad/s.
        most: f64,
        /// The cause of that limit.
        cap: Cap,
    },
    /// The servo is not known well enough to tune for.
    NotKnown,
    /// Friction holds the servo through the step.
    DoesNotArrive,
}

impl From<&TuningError> for NoGains {
    fn from(error: &TuningError) -> Self {
        match *error {
            TuningError::OutOfRange(ref error) => Self::NotAllowed(error.into()),
            TuningError::TooFast {
                bandwidth,
                most,
                cap,
            } => Self::TooFast {
                bandwidth,
                most,
                cap,
            },
            TuningError::DoesNotArrive => Self::DoesNotArrive,
            TuningError::NotKnown => Self::NotKnown,
        }
    }
}

impl fmt::Display for NoGains {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NotAllowed(ref refused) => refused.fmt(f),
            Self::TooFast {
                bandwidth,
                most,
                cap,
            } => TuningError::TooFast {
                bandwidth,
                most,
                cap,
            }
            .fmt(f),
            Self::NotKnown => TuningError::NotKnown.fmt(f),
            Self::DoesNotArrive => TuningError::DoesNotArrive.fmt(f),
        }
    }
}
