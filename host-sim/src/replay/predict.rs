//! What the estimates predict of a log.

use identifier_core::identifier::IdentifierError;
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::model::ServoParameters;

use super::{Log, LogError, ReplayError};
use crate::prediction::{ClosedLoop, FrozenServo, Observation, OpenLoop, closed_loop, open_loop};
use crate::scenario::Scenario;
use crate::scenario::dispatch::with_velocity;

/// What frozen estimates predict of a log, held against it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// Driven by the recorded command; none where there is none, or the simulation leaves every bound.
    pub open_loop: Option<OpenLoop>,
    /// Under the declared controller; none where none is declared, the log has no reference, or the
    /// loop leaves every bound.
    pub closed_loop: Option<ClosedLoop>,
}

/// Simulates a servo with these parameters over a log, with a scenario that is
/// [`fitted`](super::fitted).
///
/// # Errors
/// See [`ReplayError`].
pub fn predict(
    scenario: &Scenario,
    servo: &ServoParameters,
    log: &Log,
) -> Result<Predicted, ReplayError> {
    let play = |see: &mut dyn FnMut(&Observation)| -> Result<(), LogError> {
        for record in log.records()? {
            let record = record?;
            see(&Observation {
                reference: record.reference,
                position: record.position,
                command: record.command,
                injection: record.injection,
                begins: record.begins,
            });
        }
        Ok(())
    };
    let frozen = FrozenServo::new(servo, scenario.sample_time());
    let open_loop = open_loop(&frozen, &play).map_err(ReplayError::Log)?;
    let closed_loop = match scenario.stated.controller {
        Some(_) => with_velocity!(scenario, f64 => closed(scenario, servo, &play))
            .map_err(|error| ReplayError::of(scenario.fault(&error)))?
            .map_err(ReplayError::Log)?,
        None => None,
    };
    Ok(Predicted {
        open_loop,
        closed_loop,
    })
}

type Played<'a> = &'a dyn Fn(&mut dyn FnMut(&Observation)) -> Result<(), LogError>;

fn closed<V: VelocityEstimate<f64>>(
    scenario: &Scenario,
    servo: &ServoParameters,
    play: Played<'_>,
) -> Result<Result<Option<ClosedLoop>, LogError>, IdentifierError> {
    closed_loop::<V, _>(servo, &scenario.stated, play)
}
