//! The output error that a model leaves, and the effects that may explain it.

use std::collections::BTreeMap;

use identifier_core::parameters::Unknown;
use serde::{Serialize, Serializer};

use crate::verdict::Cause;

/// The output error of the model over the end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Residual {
    /// Root mean square, rad.
    pub rms: f64,
    /// Root mean square of rounding to the encoder's resolution alone, rad.
    pub resolution_rms: f64,
    /// Correlation from sample to sample.
    pub correlation: f64,
}

impl Residual {
    /// Output error beyond this many times the encoder's is not the encoder's.
    const MAX_ENCODER_RATIO: f64 = 1.5;
    /// Correlation beyond this is not that of rounding.
    const MAX_CORRELATION: f64 = 0.3;

    /// True if the encoder's resolution accounts for the output error.
    #[must_use]
    pub fn is_the_encoders(&self) -> bool {
        !self.is_large() && !self.is_autocorrelated()
    }

    /// True if it is more than the encoder's resolution leaves.
    #[must_use]
    pub fn is_large(&self) -> bool {
        self.rms > Self::MAX_ENCODER_RATIO * self.resolution_rms
    }

    /// True if it is correlated from sample to sample.
    #[must_use]
    pub fn is_autocorrelated(&self) -> bool {
        self.correlation > Self::MAX_CORRELATION
    }
}

/// An effect that a model may lack.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// The effect.
    #[serde(flatten, serialize_with = "described")]
    pub cause: Cause,
    /// Another effect that explains the record nearly as well; none if this one is distinct.
    #[serde(skip)]
    pub or: Option<Cause>,
    /// The part of the output error's square that it explains.
    pub share: f64,
    /// Its size, of a model that has it.
    pub size: f64,
    /// The unit of the size.
    pub unit: &'static str,
    /// The shift of each unknown in a model that has it, SI.
    #[serde(serialize_with = "by_name")]
    pub shifts: Vec<(Unknown, f64)>,
}

fn described<S: Serializer>(cause: &Cause, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Keys {
        name: &'static str,
        meaning: &'static str,
        remedy: &'static str,
    }
    let keys = Keys {
        name: cause.name(),
        meaning: cause.meaning(),
        remedy: cause.remedy(),
    };
    keys.serialize(serializer)
}

fn by_name<S: Serializer>(shifts: &[(Unknown, f64)], serializer: S) -> Result<S::Ok, S::Error> {
    let shifts = shifts.iter();
    let named: BTreeMap<_, _> = shifts.map(|(unknown, by)| (unknown.name(), by)).collect();
    named.serialize(serializer)
}
