//! Prediction of a recorded motion by a servo with frozen parameters.
//!
//! `open_loop` is driven by the recorded command without any correction. It is the hardest test, because an error of
//! the acceleration is integrated twice. It has every effect that was found. The other, `closed_loop`, follows the recorded
//! reference under the declared controller, the view of a user of the loop. It has those that are terms of the core's
//! model ([`FrozenServo`]).

mod closed_loop;
mod frozen_servo;
mod open_loop;
mod squares;

pub use closed_loop::ClosedLoop;
use closed_loop::closed_loop;
pub use frozen_servo::{FrozenServo, State};
pub use open_loop::OpenLoop;
use open_loop::open_loop;

use crate::found_servo::FoundServo;
use crate::log::Log;
use crate::scenario::{Fault, Options};
use crate::with_velocity;

/// Deviations of the prediction by frozen estimates from a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Predicted {
    /// Driven by the recorded command; none where there is none, or the simulation leaves every bound.
    pub open_loop: Option<OpenLoop>,
    /// Under the declared controller. None if none is declared, the log has no reference, or the loop leaves every
    /// bound.
    pub closed_loop: Option<ClosedLoop>,
}

/// Simulates the servo that was found over a log, with a scenario that is [fitted](Options::fitted) to the logs that
/// it was found in.
///
/// # Errors
/// The key that does not suit the log.
pub fn predict(scenario: &Options, found: &FoundServo, log: &Log) -> Result<Predicted, Fault> {
    let rows = log.rows();
    let closed_loop = match scenario.stated.controller {
        Some(_) => {
            let servo = FrozenServo::of(found, scenario);
            let servo = servo.map_err(|error| scenario.fault(&error.into()))?;
            with_velocity!(scenario, f64 => closed_loop(scenario, &servo, rows))?
        }
        None => None,
    };
    Ok(Predicted {
        open_loop: open_loop(scenario, found, rows),
        closed_loop,
    })
}
