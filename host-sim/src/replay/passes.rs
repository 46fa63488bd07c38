//! Passes of controller and identifier over a log.

use std::fmt;

use identifier_core::control::{ControlSample, ControlState, Controller};
use identifier_core::error::{OutOfRange, StepError};
use identifier_core::identifier::{IdentifierError, Recorded};
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::number::Number;
use identifier_core::units::Units;

use super::agreement::Comparison;
use super::recorded::RecordedReference;
use super::{Agreement, Log};
use crate::experiment::{Abort, Given, Outcome, Sample, learner};
use crate::scenario::{Arithmetic, Scenario, WithVelocity};

/// What a replay found.
#[derive(Debug, Clone, PartialEq)]
pub struct Replayed {
    /// What is known of the run.
    pub outcome: Outcome,
    /// How well the declared controller reproduces the recorded command, where there is one.
    pub agreement: Option<Agreement>,
}

/// Why a log cannot be replayed with a scenario.
#[derive(Debug, Clone, PartialEq)]
pub enum ReplayError {
    /// A value of the scenario is out of its range for this log.
    Range(OutOfRange),
    /// No identifier can be built for this log.
    Identifier(IdentifierError),
    /// The declared controller is not the one that ran.
    Controller(Agreement),
}

impl fmt::Display for ReplayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(error) => error.fmt(f),
            Self::Identifier(error) => error.fmt(f),
            Self::Controller(agreement) => write!(
                f,
                "{agreement}: more than {} % means that another controller ran; check gains, \
                 velocity filter, sample time, limit and the columns, or leave log.command out to \
                 replay all the same",
                100.0 * Agreement::TOLERANCE
            ),
        }
    }
}

impl std::error::Error for ReplayError {}

/// Samples in which the declared velocity estimate settles before the identifier joins: a log may
/// begin in motion.
const SETTLING: usize = 10;

/// Runs `passes` passes over a log and shows every sample to `observe`; time goes on from pass to
/// pass.
///
/// # Errors
/// See [`ReplayError`]; nothing has been observed then.
pub fn replay(
    scenario: &Scenario,
    log: &Log,
    passes: u32,
    observe: &mut dyn FnMut(&Sample),
) -> Result<Replayed, ReplayError> {
    let units = &scenario.controller.units;
    let work = Passes {
        scenario,
        log,
        passes,
        observe,
    };
    let velocity = &scenario.controller.velocity;
    match scenario.identifier.arithmetic {
        Arithmetic::F32 => velocity.with::<f32, _>(units, work),
        Arithmetic::F64 | Arithmetic::Fixed => velocity.with::<f64, _>(units, work),
    }
    .map_err(ReplayError::Range)?
}

struct Passes<'a> {
    scenario: &'a Scenario,
    log: &'a Log,
    passes: u32,
    observe: &'a mut dyn FnMut(&Sample),
}

impl<N: Number> WithVelocity<N> for Passes<'_> {
    type Output = Result<Replayed, ReplayError>;

    fn with<V: VelocityEstimate<N> + 'static>(self, velocity: V) -> Self::Output {
        let Self {
            scenario,
            log,
            passes,
            observe,
        } = self;
        let units = &scenario.controller.units;
        let recording = Recording {
            log,
            units,
            controller: scenario.controller::<N, V>(velocity),
            integral: initial_integral(scenario, log),
        };
        let agreement = recording.agreement();
        if let Some(agreement) = agreement.filter(|agreement| !agreement.holds()) {
            return Err(ReplayError::Controller(agreement));
        }
        let played = RecordedReference {
            log,
            per_unit: units.position(),
        };
        let (mut learner, mut outcome) =
            learner::<N, V>(scenario, velocity, &played).map_err(ReplayError::Identifier)?;

        let position_unit = units.position_unit();
        let first = &log.records[0];
        let length = log.records.len() as f64 * units.sample_time();
        'passes: for pass in 0..passes {
            let mut control = recording.start();
            let settling = SETTLING.min(log.records.len() - 1);
            for record in &log.records[..settling] {
                // Already done once for the agreement: it cannot be refused.
                let _ = recording.sample(&mut control, record);
            }
            learner.join(&control);
            for record in &log.records[settling..] {
                let time = f64::from(pass) * length + record.time - first.time;
                let given = Given {
                    before: control,
                    sample: recording.given(record),
                };
                let mut real = match recording.sample(&mut control, record) {
                    Ok(real) => real,
                    Err(error) => {
                        outcome.abort = Some(Abort { time, error });
                        break 'passes;
                    }
                };
                real.injection = given.sample.injection;
                let seen = learner.process(&given, &real);
                outcome.count(&seen);
                observe(&Sample {
                    time,
                    reference: record.reference,
                    position: record.position,
                    command: real.command.to_f64(),
                    output_error: seen
                        .output_error
                        .map(|error| error.to_f64() * position_unit),
                    estimates: learner.estimates(),
                    standard_errors: learner.standard_errors(),
                });
            }
        }
        Ok(Replayed { outcome, agreement })
    }
}

/// What the integral holds at the start, rad s: what the first recorded command needs beyond the
/// proportional part, for a log that begins at rest but not from rest.
fn initial_integral(scenario: &Scenario, log: &Log) -> f64 {
    let gains = &scenario.controller.gains;
    let first = &log.records[0];
    match first.command {
        Some(command) if gains.ki() > 0.0 => {
            (command - gains.kp() * (first.reference - first.position)) / gains.ki()
        }
        _ => 0.0,
    }
}

/// A log with the controller that is declared to have run.
struct Recording<'a, N, V> {
    log: &'a Log,
    units: &'a Units,
    controller: Controller<N, V>,
    integral: f64,
}

impl<N: Number, V: VelocityEstimate<N>> Recording<'_, N, V> {
    fn start(&self) -> ControlState<N, V::State> {
        let integral = self.integral / (self.units.position_unit() * self.units.sample_time());
        ControlState::at_rest(N::ZERO).with_integral(N::from_f64(integral))
    }

    fn sample(
        &self,
        control: &mut ControlState<N, V::State>,
        record: &super::log::Record,
    ) -> Result<ControlSample<N>, StepError> {
        let Recorded {
            reference,
            position,
            ..
        } = self.given(record);
        self.controller.process(control, reference, position)
    }

    /// A record in machine units, positions from the first.
    fn given(&self, record: &super::log::Record) -> Recorded<N> {
        let origin = self.log.records[0].position;
        let machine = |value: f64| N::from_f64((value - origin) * self.units.position());
        Recorded {
            reference: machine(record.reference),
            position: machine(record.position),
            injection: N::from_f64(record.injection),
        }
    }

    fn agreement(&self) -> Option<Agreement> {
        let mut comparison = Comparison::default();
        let mut control = self.start();
        for record in &self.log.records {
            let Ok(sample) = self.sample(&mut control, record) else {
                break;
            };
            if let Some(recorded) = record.command {
                comparison.add(record.line, recorded, sample.command.to_f64());
            }
        }
        comparison.finish()
    }
}
