//! The effects that may explain the output error that a model leaves.

use std::collections::BTreeMap;

use identifier_core::parameters::Unknown;
use serde::{Serialize, Serializer};

use crate::verdict::Cause;

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
