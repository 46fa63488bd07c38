//! Gains in the form of a drive's firmware.

use identifier_core::tuning::PredictedSample;
use serde::Serialize;

/// The same loop as a firmware takes it, with margins and step of what it stores.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FormResult {
    /// Name of the form.
    pub name: &'static str,
    /// The firmware and mode that it is for.
    pub firmware: &'static str,
    /// The parameters as the firmware stores them.
    pub parameters: Vec<FormParameter>,
    /// "exact", "needs ki cut" where a cascade has no such integral gain, or "P only".
    pub exactness: &'static str,
    /// Period of the firmware's loop, s.
    pub sample_time: f64,
    /// Margins of the stored parameters, at the worst corner of the servo's uncertainty.
    pub margins: FormMargins,
    /// Step of the target. If it overshoots, also the same through a filter in the sending program. Both are without
    /// friction and limits.
    pub steps: Vec<FormStep>,
    /// The parameters to begin with, for a quarter of the bandwidth; empty where there are none.
    pub first_trial: Vec<FormParameter>,
    /// Limits of the firmware, and the assumptions behind the numbers.
    pub remarks: Vec<String>,
    /// The last of the steps.
    #[serde(skip)]
    pub response: Vec<PredictedSample>,
}

/// A parameter of a firmware.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FormParameter {
    /// Its name in the firmware.
    pub name: &'static str,
    /// The stored value.
    pub value: f64,
    /// Its unit.
    pub unit: String,
}

/// Margins of a loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FormMargins {
    /// Mₛ, the largest sensitivity.
    pub sensitivity: f64,
    /// The factors by which the gain may fall and rise; up to 50 is looked for.
    pub gain_margins: [f64; 2],
}

/// A step of the target.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FormStep {
    /// Time constant of the first-order filter that the target passes before, s; zero for none.
    pub smoothing: f64,
    /// From 10 to 90 %, s; none where it does not get there.
    pub rise_time: Option<f64>,
    /// Beyond the step, a part of it.
    pub overshoot: f64,
}
