//! What the estimates predict of a log.

use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::settings::SettingsError;

use super::{Log, LogError, ReplayError, Replayed};
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

/// Simulates the servo that a replay found over a log, with the scenario of that replay, which is
/// [`fitted`](super::fitted).
///
/// # Errors
/// See [`ReplayError`].
pub fn predict(scenario: &Scenario, found: &Replayed, log: &Log) -> Result<Predicted, ReplayError> {
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
    let terms = found.outcome.terms.iter();
    let servo = FrozenServo::new(&found.estimates, scenario.sample_time())
        .map_err(|error| ReplayError::of(scenario.fault(&error.into())))?
        .with_terms(
            &scenario.stated.identifier.terms,
            terms.map(|term| (term.unknown, term.value)),
        );
    let open_loop = open_loop(&servo, &play).map_err(ReplayError::Log)?;
    let closed_loop = match scenario.stated.controller {
        Some(_) => with_velocity!(scenario, f64 => closed(scenario, &servo, &play))
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
    servo: &FrozenServo,
    play: Played<'_>,
) -> Result<Result<Option<ClosedLoop>, LogError>, SettingsError> {
    closed_loop::<V, _>(servo, &scenario.stated, play)
}
