//! Prediction of a log by the estimates of a replay.

use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::settings::SettingsError;

use super::{ClosedLoop, FrozenServo, Observation, OpenLoop, closed_loop, open_loop};
use crate::log::{Log, LogError};
use crate::replay::{ReplayError, Replayed};
use crate::scenario::Scenario;
use crate::scenario::dispatch::with_velocity;

/// Deviations of the prediction by frozen estimates from a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// Driven by the recorded command; none where there is none, or the simulation leaves every bound.
    pub open_loop: Option<OpenLoop>,
    /// Under the declared controller; none where none is declared, the log has no reference, or the
    /// loop leaves every bound.
    pub closed_loop: Option<ClosedLoop>,
}

/// Simulates the servo that a replay found over a log, with the scenario of that replay, which is
/// [`fitted`](crate::replay::fitted).
///
/// # Errors
/// See [`ReplayError`].
pub fn predict(scenario: &Scenario, found: &Replayed, log: &Log) -> Result<Predicted, ReplayError> {
    let play = |see: &mut dyn FnMut(&Observation)| -> Result<(), LogError> {
        for row in log.rows()? {
            let row = row?;
            see(&Observation {
                reference: row.reference,
                position: row.position,
                command: row.command,
                injection: row.injection,
                begins: row.begins,
            });
        }
        Ok(())
    };
    let terms = found.outcome.terms.iter();
    let servo = FrozenServo::new(&found.estimates, scenario.sample_time())
        .map_err(|error| ReplayError::in_scenario(scenario.fault(&error.into())))?
        .with_terms(
            &scenario.stated.identifier.terms,
            terms.map(|term| (term.unknown, term.value)),
        );
    let open_loop = open_loop(&servo, &play).map_err(ReplayError::Log)?;
    let closed_loop = match scenario.stated.controller {
        Some(_) => with_velocity!(scenario, f64 => closed(scenario, &servo, &play))
            .map_err(|error| ReplayError::in_scenario(scenario.fault(&error)))?
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
