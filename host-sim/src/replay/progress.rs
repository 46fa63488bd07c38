//! The identifier on its way through the samples of logs, segment by segment.

use identifier_core::error::StepError;
use identifier_core::measurement::VelocityEstimate;

use super::declared::Declared;
use super::scaled::RowScaler;
use super::settling::settling_in_motion;
use crate::experiment::{Outcome, Sample};
use identifier_log::log::Row;
use crate::loops::DynIdentifier;
use crate::scenario::Scenario;

/// State that lasts from segment to segment.
pub(super) struct Progress<V: VelocityEstimate<f64>> {
    pub(super) identifier: Box<dyn DynIdentifier + Send>,
    pub(super) declared: Option<Declared<V>>,
    pub(super) filter: V,
    /// A position unit, rad.
    pub(super) unit: f64,
    /// Travel of a revolution, rad.
    pub(super) revolution: f64,
    pub(super) outcome: Outcome,
    /// Time before this segment, s.
    pub(super) time: f64,
    /// True once the identifier has had a sample.
    pub(super) begun: bool,
}

/// State within a segment.
pub(super) struct InSegment<V: VelocityEstimate<f64>> {
    scaler: RowScaler,
    /// When it began, s, of the log.
    from: f64,
    filtered: V::State,
    velocity: f64,
    /// Samples in which the velocity settles.
    settling: u64,
    /// Samples so far.
    pub(super) samples: u64,
    /// Samples in which the velocity settles behind a bridged gap.
    settling_in_motion: u64,
    /// The sample from which on that is done.
    settled_again: u64,
}

/// The input of the identifier in a sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Input {
    /// Motion since the last sample, position units.
    pub(super) increment: f64,
    /// The command that acts from now on.
    pub(super) command: f64,
    /// True in the first sample of a segment that is learnt from.
    begins: bool,
}

impl<V: VelocityEstimate<f64>> InSegment<V> {
    pub(super) fn new(scenario: &Scenario, first: &Row, unit: f64, settling: u64) -> Self {
        Self {
            scaler: RowScaler::new(scenario, first.position, unit),
            from: first.time,
            filtered: V::State::default(),
            velocity: 0.0,
            settling,
            samples: 0,
            settling_in_motion: settling_in_motion(scenario),
            settled_again: 0,
        }
    }
}

impl<V: VelocityEstimate<f64>> Progress<V> {
    /// Begins a segment, and with `anew` the declared controller, too.
    pub(super) fn begin(&mut self, anew: bool) {
        if let Some(declared) = self.declared.as_mut().filter(|_| anew) {
            declared.begin();
        }
    }

    pub(super) fn time_of(&self, segment: &InSegment<V>, row: &Row) -> f64 {
        self.time + row.time - segment.from
    }

    /// The input of the identifier in a sample of a log; none while the velocity settles.
    pub(super) fn input(
        &mut self,
        segment: &mut InSegment<V>,
        row: &Row,
        log: usize,
        pass: u32,
    ) -> Result<Option<Input>, StepError> {
        let scaled = segment.scaler.scale(*row);
        let settled = segment.samples >= segment.settling;
        let begins = segment.samples == segment.settling;
        if row.bridged {
            segment.settled_again = segment.samples + segment.settling_in_motion;
        }
        let comparable = settled && segment.samples >= segment.settled_again;
        segment.samples += 1;
        let command = match (row.command, &mut self.declared) {
            (Some(command), declared) => {
                if let Some(declared) = declared.as_mut().filter(|_| pass == 0) {
                    declared.compare(&scaled, log, comparable);
                }
                command
            }
            (None, Some(declared)) => declared.process(&scaled)?,
            // It has been refused when the scenario was read.
            (None, None) => return Err(StepError::CommandNotFinite),
        };
        if !settled {
            segment.velocity = self.filter.process(&mut segment.filtered, scaled.increment);
            return Ok(None);
        }
        if begins {
            if self.begun || segment.settling > 0 {
                self.identifier.resume_moving(segment.velocity);
            }
            let angle = row.position.rem_euclid(self.revolution) / self.unit;
            self.identifier.place(angle - scaled.increment);
        }
        self.begun = true;
        Ok(Some(Input {
            increment: scaled.increment,
            command,
            begins,
        }))
    }

    /// A sample of a log; nothing comes of it while the velocity settles.
    pub(super) fn process(
        &mut self,
        segment: &mut InSegment<V>,
        row: &Row,
        log: usize,
        pass: u32,
    ) -> Result<Option<Sample>, StepError> {
        let Some(input) = self.input(segment, row, log, pass)? else {
            return Ok(None);
        };
        let step = self.identifier.step(input.increment, input.command, None)?;
        self.outcome.count(step.event);
        let time = self.time_of(segment, row);
        let reference = row.reference.unwrap_or(f64::NAN);
        let sample = step.sample(time, input.begins, reference, row.position, self.unit);
        Ok(Some(sample))
    }
}
