//! The effects that a commissioning of five numbers did not explain, by the fit of all that it recorded.

use identifier_core::reason::Reason;
use log_fit::fit::Values;
use log_fit::{Cause, Logged, ModelDemand, Recording, identify};

use super::Sample;

/// A sample as the fit takes it; none without a reading.
pub(super) fn logged(sample: &Sample, begins: bool) -> Option<Logged> {
    Some(Logged {
        position: sample.measured?,
        command: sample.command.unwrap_or(0.0),
        begins,
    })
}

/// The effects of a motion beside a, b, c, d and a delay, if its commissioning ended for want of a model that explains it.
/// Position of a count and of a revolution are in rad.
pub(super) fn effects(
    reason: Option<Reason>,
    moved: &[Logged],
    resolution: f64,
    revolution: f64,
) -> Vec<Cause> {
    /// The most effects that are named.
    const MOST: usize = 2;
    let is_unexplained = matches!(
        reason,
        Some(
            Reason::PartlyExplained
                | Reason::ResonanceOrBacklash
                | Reason::TooLittleEvidence
                | Reason::PredictionMissed
                | Reason::DoesNotMove
                | Reason::NeverAtRest
                | Reason::ActuatorWeak
                | Reason::Oscillating
                | Reason::TravelLeft
                | Reason::SpeedExceeded
        )
    );
    if !is_unexplained {
        return Vec::new();
    }
    let recording = Recording::new(moved, 1.0 / resolution, revolution);
    let demand = ModelDemand {
        known: Values::NONE,
        required: Vec::new(),
        max_effects: MOST,
    };
    let found = identify(&recording, &demand, &|| true);
    found.map_or_else(Vec::new, |found| {
        found.entered.iter().map(|entered| entered.cause).collect()
    })
}
