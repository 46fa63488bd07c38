//! The effects that a commissioning of five numbers did not explain, by the fit of all that it recorded.

use identifier_core::reason::Reason;
use log_fit::fit::Values;
use log_fit::{Cause, Logged, ModelDemand, Recording, identify};

use super::Sample;
use crate::scenario::Scenario;

/// All that a commissioning has recorded until its end.
#[derive(Debug, Clone, Default)]
pub struct Recorded(Vec<Logged>);

impl Recorded {
    /// Takes a sample in, if it has a reading.
    pub fn add(&mut self, sample: &Sample) {
        if let Some(position) = sample.measured.filter(|_| !sample.phase.is_end()) {
            self.0.push(Logged {
                position,
                command: sample.command.unwrap_or(0.0),
                begins: self.0.is_empty(),
            });
        }
    }

    /// The effects beside a, b, c, d and a delay, if a commissioning ended for this reason because no model explains
    /// the axis. None for a fault. It takes seconds.
    #[must_use]
    pub fn effects(&self, scenario: &Scenario, reason: Option<Reason>) -> Vec<Cause> {
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
        let revolution = scenario.stated.identifier.terms.revolution;
        let recording = Recording::new(&self.0, 1.0 / scenario.stated.resolution, revolution);
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
}
