//! Passes of the identifier over a log.

use std::fmt;

use identifier_core::Settings;
use identifier_core::control::{ControlState, Controller};
use identifier_core::error::StepError;
use identifier_core::identifier::IdentifierError;
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::number::Number;

use super::agreement::Comparison;
use super::log::Record;
use super::recorded::RecordedReference;
use super::{Agreement, Log};
use crate::experiment::{Outcome, Sample, learner};
use crate::scenario::{Arithmetic, Scenario, WithVelocity};

/// What a replay found.
#[derive(Debug, Clone, PartialEq)]
pub struct Replayed {
    /// What is known of the run.
    pub outcome: Outcome,
    /// How well the declared controller reproduces the recorded command, where there are both.
    pub agreement: Option<Agreement>,
}

/// Why a log cannot be replayed with a scenario.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReplayError {
    /// The key of the scenario that it is best mended at.
    pub key: String,
    /// What is wrong, and what is allowed.
    pub fault: String,
}

impl fmt::Display for ReplayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.key, self.fault)
    }
}

impl std::error::Error for ReplayError {}

/// The scenario with what only the log knows: the sample time where no controller is declared, the
/// resolution of the position where no encoder is, and the time over which a first fit looks where
/// the log is shorter than what is usual.
#[must_use]
pub fn fitted(mut scenario: Scenario, log: &Log) -> Scenario {
    let stated = &mut scenario.stated;
    if stated.controller.is_none() {
        // The cut-off that follows from a sample time; the resolution is not that of these counts.
        let of_log = Settings::new(log.sample_time, 1.0);
        stated.sample_time = of_log.sample_time;
        stated.cutoff = of_log.cutoff;
    }
    if scenario.counts_per_rev.is_none() {
        stated.resolution = log.resolution();
    }
    let learnt = log.records.len().saturating_sub(SETTLING + 1);
    let most = learnt as f64 * stated.sample_time;
    if (SHORTEST_START..USUAL_START).contains(&most) {
        stated.identifier.start_time.get_or_insert(most);
    }
    scenario
}

/// Samples in which the velocity estimate settles before the identifier joins: a log may begin in
/// motion.
const SETTLING: usize = 10;

/// The time over which the core's first fits look where nobody says, and the least that it takes, s.
const USUAL_START: f64 = 1.0;
const SHORTEST_START: f64 = 1e-4;

/// Runs `passes` passes over a log with a scenario that is [`fitted`] to it and shows every sample to
/// `observe`, with the number of its pass from 0; time goes on from pass to pass.
///
/// # Errors
/// See [`ReplayError`]; nothing has been observed then.
pub fn replay(
    scenario: &Scenario,
    log: &Log,
    passes: u32,
    observe: &mut dyn FnMut(u32, &Sample),
) -> Result<Replayed, ReplayError> {
    let work = Passes {
        scenario,
        log,
        passes,
        observe,
    };
    match scenario.identifier.arithmetic {
        Arithmetic::F32 => scenario.velocity.with::<f32, _>(work),
        Arithmetic::F64 | Arithmetic::Fixed => scenario.velocity.with::<f64, _>(work),
    }
    .map_err(|error| {
        let fault = scenario.fault(&error);
        ReplayError {
            key: fault.key,
            fault: fault.fault,
        }
    })
}

struct Passes<'a> {
    scenario: &'a Scenario,
    log: &'a Log,
    passes: u32,
    observe: &'a mut dyn FnMut(u32, &Sample),
}

impl<N: Number> WithVelocity<N> for Passes<'_> {
    type Output = Result<Replayed, IdentifierError>;

    fn with<V: VelocityEstimate<N> + 'static>(self) -> Self::Output {
        let Self {
            scenario,
            log,
            passes,
            observe,
        } = self;
        let units = scenario.stated.units()?;
        let unit = units.position_unit();
        let played = RecordedReference::new(log, units.position());
        let settings = scenario.settings_for(played.as_ref())?;
        let recording = Recording { log, unit };
        let declared = match (&played, settings.controller) {
            (Some(_), Some(_)) => Some(Declared::<N, V>::new(&settings, log)?),
            _ => None,
        };
        let agreement = declared
            .as_ref()
            .and_then(|declared| declared.agreement(&recording));
        let filter: V = settings.build()?;
        let (mut learner, mut outcome) = learner::<N>(scenario, &settings)?;

        let first = log.records[0].time;
        let length = log.records.len() as f64 * units.sample_time();
        let settling = SETTLING.min(log.records.len() - 1);
        'passes: for pass in 0..passes {
            let mut control = declared.as_ref().map(Declared::start);
            let mut filtered = V::State::default();
            let mut velocity = N::ZERO;
            for (k, record) in log.records.iter().enumerate() {
                let time = f64::from(pass) * length + record.time - first;
                let increment = recording.increment(k);
                let command = match (record.command, &declared, &mut control) {
                    (Some(command), ..) => Ok(N::from_f64(command)),
                    (None, Some(declared), Some(control)) => {
                        declared.process(control, &recording, k)
                    }
                    // It has been refused when the scenario was read.
                    (None, ..) => Err(StepError::CommandNotFinite),
                };
                let seen = if k < settling {
                    velocity = filter.process(&mut filtered, increment);
                    command.map(|_| None)
                } else {
                    if k == settling {
                        learner.join(velocity);
                    }
                    command.and_then(|command| {
                        let seen = learner.learn(increment, command)?;
                        Ok(Some((command, seen)))
                    })
                };
                let (command, seen) = match seen {
                    Ok(None) => continue,
                    Ok(Some(both)) => both,
                    Err(error) => {
                        outcome.end_early(time, error);
                        break 'passes;
                    }
                };
                learner.work();
                outcome.count(seen.map(|seen| seen.event));
                let sample = Sample {
                    time,
                    reference: record.reference.unwrap_or(f64::NAN),
                    position: record.position,
                    command: command.to_f64(),
                    output_error: seen.map(|seen| seen.output_error.to_f64() * unit),
                    estimates: learner.estimates(),
                    standard_errors: learner.standard_errors(),
                    at_bounds: learner.at_bounds(),
                };
                observe(pass, &sample);
            }
        }
        outcome.bandwidth = learner.bandwidth();
        Ok(Replayed { outcome, agreement })
    }
}

/// A log in position units.
struct Recording<'a> {
    log: &'a Log,
    unit: f64,
}

impl Recording<'_> {
    /// How far the position has moved since the last record.
    fn increment<N: Number>(&self, k: usize) -> N {
        let records = &self.log.records;
        let before = records[k.saturating_sub(1)].position;
        N::from_f64((records[k].position - before) / self.unit)
    }

    /// How far it is from the reference.
    fn error<N: Number>(&self, record: &Record) -> N {
        let reference = record.reference.unwrap_or(record.position);
        N::from_f64((reference - record.position) / self.unit)
    }
}

/// The controller that is declared to have run.
struct Declared<N, V> {
    controller: Controller<N, V>,
    integral: f64,
}

impl<N: Number, V: VelocityEstimate<N>> Declared<N, V> {
    fn new(settings: &Settings, log: &Log) -> Result<Self, IdentifierError> {
        let units = settings.units()?;
        let integral = initial_integral(settings, log);
        Ok(Self {
            controller: settings.build()?,
            integral: integral / (units.position_unit() * units.sample_time()),
        })
    }

    fn start(&self) -> ControlState<N, V::State> {
        ControlState::default().with_integral(N::from_f64(self.integral))
    }

    /// Its command in a sample, with what was added to it.
    fn process(
        &self,
        control: &mut ControlState<N, V::State>,
        recording: &Recording<'_>,
        k: usize,
    ) -> Result<N, StepError> {
        let record = &recording.log.records[k];
        let (error, increment) = (recording.error(record), recording.increment(k));
        let sample = self.controller.process(control, error, increment)?;
        Ok(sample.command + N::from_f64(record.injection))
    }

    fn agreement(&self, recording: &Recording<'_>) -> Option<Agreement> {
        let mut comparison = Comparison::default();
        let mut control = self.start();
        for (k, record) in recording.log.records.iter().enumerate() {
            let Ok(command) = self.process(&mut control, recording, k) else {
                break;
            };
            if let Some(recorded) = record.command.filter(|_| !record.bridged) {
                comparison.add(record.line, recorded, command.to_f64());
            }
        }
        comparison.finish()
    }
}

/// What the integral holds at the start, rad s: what the first recorded command needs beyond the
/// proportional part, for a log that begins at rest but not from rest.
fn initial_integral(settings: &Settings, log: &Log) -> f64 {
    let first = &log.records[0];
    match (first.command, first.reference, settings.controller) {
        (Some(command), Some(reference), Some(controller)) if controller.ki > 0.0 => {
            let own = command - first.injection;
            (own - controller.kp * (reference - first.position)) / controller.ki
        }
        _ => 0.0,
    }
}
