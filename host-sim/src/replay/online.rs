//! Identification while the samples are taken: there is no log, and no verdict.

use identifier_core::measurement::LowPass;
use identifier_core::parameters::{Parameter, PerParameter, ServoParameters};

use identifier_log::log::Row;
use identifier_log::replay::{InSegment, Player, settling_in_motion};

use super::passes::RecordedReference;
use crate::loops::DynIdentifier;
use crate::scenario::{Fault, LogQuantity, Scenario};
use crate::simulate::identifier;

/// An identifier that takes samples one by one, in the units that a scenario's `[log]` states.
pub struct OnlineIdentifier {
    scenario: Scenario,
    identifier: Box<dyn DynIdentifier + Send>,
    player: Player<LowPass<f64>>,
    segment: Option<InSegment<LowPass<f64>>>,
    sample_time: f64,
    /// SI units for one of the position's and one of the command's.
    scales: [f64; 2],
    samples: u64,
}

impl std::fmt::Debug for OnlineIdentifier {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("OnlineIdentifier")
            .field("samples", &self.samples)
            .field("estimates", &self.estimates())
            .finish_non_exhaustive()
    }
}

impl OnlineIdentifier {
    /// At its start.
    ///
    /// # Errors
    /// The key that is missing or not allowed.
    pub fn new(mut scenario: Scenario) -> Result<Self, Fault> {
        let columns = scenario.log_columns();
        if scenario.identifier.law.takes_whole_record() {
            let why =
                "this estimator needs a whole log: online, use \"gauss-newton\" or \"gradient\"";
            return Err(Fault::new("identifier.law", why));
        }
        let Some(sample_time) = scenario.log_sample_time() else {
            return Err(Fault::new(
                "log.sample_time",
                "is missing: state the time from one sample to the next, in s",
            ));
        };
        if scenario.counts_per_rev.is_none() {
            return Err(Fault::new(
                "encoder.counts_per_rev",
                "is missing: without a log it gives the smallest step of the position",
            ));
        }
        scenario.sample_every(sample_time);
        let scale = |quantity| columns.units.scale(quantity, sample_time);
        let scales = [scale(LogQuantity::Position), scale(LogQuantity::Command)];
        let settings = scenario.settings_for(None::<&RecordedReference<'_>>)?;
        let identifier = identifier(&scenario, &settings)?;
        Ok(Self {
            identifier,
            player: Player::new(&scenario, &settings, false, true)?,
            segment: None,
            sample_time,
            scales,
            samples: 0,
            scenario,
        })
    }

    /// A sample: the position, and the whole command that acts from now to the next.
    ///
    /// # Errors
    /// A number that is not allowed, with the remedy; the sample is left out.
    pub fn learn(&mut self, position: f64, command: f64) -> Result<(), String> {
        let [of_position, of_command] = self.scales;
        let mut row = Row::at(self.samples, self.samples as f64 * self.sample_time);
        row.position = of_position * position;
        row.command = Some(of_command * command);
        for (name, number) in [("position", position), ("command", command)] {
            if !number.is_finite() {
                return Err(format!(
                    "{name} = {number}: it must be a finite number; skip the sample and resume"
                ));
            }
        }
        let segment = self.segment.get_or_insert_with(|| {
            let settling = settling_in_motion(&self.scenario);
            InSegment::new(&self.scenario, &row, self.player.unit(), settling)
        });
        let refused = |error| format!("position = {position}, command = {command}: {error}");
        if let Some(input) = self.player.input(segment, &row, 0, 0).map_err(refused)? {
            self.identifier.join(&input);
            let learnt = self.identifier.update(input.increment, input.command);
            learnt.map_err(refused)?;
        }
        self.samples += 1;
        Ok(())
    }

    /// Joins the motion anew behind a gap between samples; the estimates are kept.
    pub fn resume(&mut self) {
        self.segment = None;
    }

    /// The samples so far.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The parameters that the estimator estimates.
    #[must_use]
    pub fn estimated(&self) -> Vec<Parameter> {
        self.scenario.estimated()
    }

    /// The estimates, SI.
    #[must_use]
    pub fn estimates(&self) -> ServoParameters {
        self.identifier.estimates()
    }

    /// Their standard errors, SI, where the estimator knows them.
    #[must_use]
    pub fn standard_errors(&self) -> Option<ServoParameters> {
        self.identifier.standard_errors()
    }

    /// The estimates at a bound.
    #[must_use]
    pub fn at_bounds(&self) -> PerParameter<bool> {
        self.identifier.at_bounds()
    }
}
