//! Prediction of a recorded motion by a servo with frozen parameters.
//!
//! `open_loop` is driven by the recorded command without any correction. It is the hardest test, because an error of
//! the acceleration is integrated twice. The other, `closed_loop`, follows the recorded reference under the declared
//! controller, the view of a user of the loop. Both run in double precision with the core's own exact step
//! ([`FrozenServo`]). Both read the samples as often as they need, one at a time.

mod closed_loop;
mod frozen_servo;
mod open_loop;
mod squares;
mod start;

pub use closed_loop::ClosedLoop;
use closed_loop::closed_loop;
pub use frozen_servo::{FrozenServo, State};
pub use open_loop::OpenLoop;
use open_loop::open_loop;

use crate::log::Log;
use crate::replay::Replayed;
use crate::scenario::dispatch::with_velocity;
use crate::scenario::{Fault, Scenario};

/// Deviations of the prediction by frozen estimates from a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// Driven by the recorded command; none where there is none, or the simulation leaves every bound.
    pub open_loop: Option<OpenLoop>,
    /// Under the declared controller. None if none is declared, the log has no reference, or the loop leaves every
    /// bound.
    pub closed_loop: Option<ClosedLoop>,
}

/// Simulates the servo that a replay found over a log, with the scenario of that replay, which is
/// [`fitted`](crate::replay::fitted).
///
/// # Errors
/// The key that does not suit the log.
pub fn predict(scenario: &Scenario, found: &Replayed, log: &Log) -> Result<Predicted, Fault> {
    let rows = log.rows();
    let terms = found.outcome.terms.iter();
    let servo = FrozenServo::new(&found.estimates, scenario.sample_time())
        .map_err(|error| scenario.fault(&error.into()))?
        .with_terms(
            &found.term_settings,
            terms.map(|term| (term.unknown, term.value)),
        );
    let open_loop = open_loop(&servo, rows);
    let closed_loop = match scenario.stated.controller {
        Some(_) => with_velocity!(scenario, f64 => closed_loop(scenario, &servo, rows))?,
        None => None,
    };
    Ok(Predicted {
        open_loop,
        closed_loop,
    })
}
