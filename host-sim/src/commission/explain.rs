//! The effects that a commissioning of five numbers did not explain, by the fit of all that it recorded.

use identifier_core::reason::Reason;
use log_fit::fit::Values;
use log_fit::{Axis, Cause, Logged, ModelDemand, Recording, Way, identify};

use super::Sample;
use crate::scenario::Scenario;

/// The record of a commissioning: every sample until its end, or what the drive keeps of it.
#[derive(Debug, Clone, Default)]
pub struct Recorded {
    samples: Vec<Logged>,
    /// Position of a count in the blocks of a drive, rad; none of samples.
    block_resolution: Option<f64>,
}

impl Recorded {
    /// Takes a sample in, if it has a reading.
    pub fn add(&mut self, sample: &Sample) {
        if let Some(position) = sample.measured.filter(|_| !sample.phase.is_end()) {
            self.samples.push(Logged {
                position,
                command: sample.command.unwrap_or(0.0),
                begins: self.samples.is_empty(),
            });
        }
    }

    /// Takes in the next `blocks` of a drive's record: displacement (counts of `resolution`, rad), mean command and first
    /// moment of each. Returns how many there are now.
    pub fn take_blocks(&mut self, resolution: f64, blocks: &[[f32; 3]]) -> usize {
        let last = self.samples.last_chunk::<2>();
        let mut position = last.map_or(0.0, |[first, middle]| {
            2.0 * middle.position - first.position
        });
        for &[travel, command, moment] in blocks {
            let next = position + f64::from(travel) * resolution;
            let moment = -f64::from(moment);
            let halves = Logged::halves([position, next], command.into(), moment);
            self.samples.extend(halves);
            position = next;
        }
        self.block_resolution = Some(resolution);
        self.samples.len() / 2
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
                    | Reason::NoGains
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
        let way = Way::Turn(scenario.stated.identifier.terms.revolution);
        let axis = |resolution: f64| Axis::new(1.0 / resolution, way);
        let recording = match self.block_resolution {
            None => Recording::new(&self.samples, axis(scenario.stated.resolution)),
            Some(resolution) => Recording::of_halves(&self.samples, axis(resolution)),
        };
        let demand = ModelDemand {
            known: Values::NONE,
            required: Vec::new(),
            max_effects: MOST,
        };
        let found = identify(&recording, &recording.scales(), &demand, &|| true);
        found.map_or_else(Vec::new, |found| {
            found.entered.iter().map(|entered| entered.cause).collect()
        })
    }
}
