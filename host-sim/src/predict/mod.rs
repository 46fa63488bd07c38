//! Prediction of a recorded motion by a servo with frozen parameters.
//!
//! [`open_loop`] is driven by the recorded command and nothing corrects it: the hardest test, as an
//! error of the acceleration adds up twice. [`closed_loop`] follows the recorded reference under the
//! declared controller: the view of a user of the loop. Both run in double precision with the core's
//! own exact step ([`FrozenServo`]), and both see the samples as often as they need them, one at a time.

mod closed_loop;
mod frozen_servo;
mod log;
mod open_loop;
mod start;

pub use closed_loop::{ClosedLoop, closed_loop};
pub use frozen_servo::{FrozenServo, State};
pub use log::{Predicted, predict};
pub use open_loop::{OpenLoop, open_loop};

/// A sample that was recorded, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// Reference position, rad, where it is known.
    pub reference: Option<f64>,
    /// Measured position, rad.
    pub position: f64,
    /// The whole command that acted from here to the next sample, where it was recorded.
    pub command: Option<f64>,
    /// The signal added to the declared controller's command behind its limit.
    pub injection: f64,
    /// True where the motion directly before is unknown: a simulation starts anew.
    pub begins: bool,
}

/// Samples that can be played from the first as often as is needed: they are shown to what is given.
pub type Play<'a, E> = &'a dyn Fn(&mut dyn FnMut(&Observation)) -> Result<(), E>;

/// Squares of an error and of its reference quantity.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Squares {
    error: f64,
    whole: f64,
}

impl Squares {
    fn add(&mut self, recorded: f64, simulated: f64) {
        let error = recorded - simulated;
        self.error += error * error;
        self.whole += recorded * recorded;
    }

    /// ‖recorded − simulated‖/‖recorded‖.
    fn relative(&self) -> f64 {
        (self.error / self.whole).sqrt()
    }
}
