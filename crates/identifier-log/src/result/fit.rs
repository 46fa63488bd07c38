//! Findings of a fit to a whole record besides the estimates.

use serde::{Deserialize, Serialize};

/// Findings of a fit to a whole record besides the estimates.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct FitNotes {
    /// Samples that were fitted.
    pub samples: u64,
    /// Samples by which the command was recorded late, in a row after the one from which it acted. None if it was not.
    /// The estimates are those with the command where it acted.
    pub command_recorded_late: Option<f64>,
    /// `sampled` or `averaged` where the command changed between the rows, whose loop is faster than the log.
    pub command_between_rows: Option<&'static str>,
    /// The braking force of a motion in one direction, friction and load together, rad/s². The two are one force then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub braking: Option<BrakingForce>,
    /// The effects that the record shows, in the order in which they entered. A load that steps and the delay follow.
    pub effects: Vec<EnteredEffect>,
    /// What the record says of a second mode beside the model, in the order of the frequencies.
    pub second_modes: Vec<SecondMode>,
}

/// A second mode beside the model, b β/(s² + 2ζωs + ω²) of the command.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SecondMode {
    /// ω, rad/s.
    pub rad_per_s: f64,
    /// β: the load's inertia over the motor's, or −1 for an encoder on the load.
    pub ratio: f64,
    /// Its standard error.
    pub std_error: f64,
}

/// The gain at a time scale.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ScaleEstimate {
    /// Length of the windows over which the equation of motion is integrated, s.
    #[serde(rename = "time_s")]
    pub time: f64,
    /// b there, rad/s² per command unit. A negative one is that of a command of the other sign.
    pub b: f64,
    /// Its standard error: chance, the next scales, and other models that predict as well.
    pub std_error: f64,
    /// The part of the acceleration of left-out windows that is predicted, at most 1.
    pub explained: f64,
}

/// A value and its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BrakingForce {
    /// The value.
    pub value: f64,
    /// Its standard error.
    pub std_error: f64,
}

/// An effect that the record shows beyond friction, load and delay.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EnteredEffect {
    /// Its name.
    pub name: &'static str,
    /// A description.
    pub meaning: &'static str,
    /// Increase of twice the logarithm of the likelihood, counted in independent samples.
    pub gain: f64,
    /// Another effect that explains the record nearly as well. Or this effect is so small a part of it that it may be
    /// the error of its form. None if this one is certain.
    pub or: Option<&'static str>,
    /// Sizes that are no unknown of the model, by name.
    #[serde(serialize_with = "by_name")]
    pub sizes: Vec<(&'static str, f64)>,
    /// Their standard errors, by the same names, of those that were estimated.
    #[serde(serialize_with = "by_name")]
    pub std_errors: Vec<(&'static str, f64)>,
}

fn by_name<S: serde::Serializer>(
    sizes: &[(&'static str, f64)],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_map(sizes.iter().copied())
}
