use identifier_core::units::Units;
use virtual_servo::faults::{Condition, Faults};
use virtual_servo::{SensorErrors, Servo};

use crate::scenario::{Fault, Scenario, in_effect};

/// The servo of a scenario, the errors of its sensor, and its injected faults.
#[derive(Debug, Clone)]
pub(crate) struct VirtualAxis {
    pub(crate) servo: Servo,
    errors: SensorErrors,
    faults: Faults,
}

impl VirtualAxis {
    /// At rest.
    pub(crate) fn new(scenario: &Scenario, units: &Units) -> Result<Self, Fault> {
        let (time, seed) = (units.sample_time(), scenario.noise_seed());
        Ok(Self {
            servo: Servo::at_rest(&scenario.servo()?, &scenario.effects, time, seed)
                .map_err(|error| in_effect(&error))?,
            errors: SensorErrors::new(&scenario.sensor, time, seed)
                .map_err(|error| Fault::new(format!("encoder.{}", error.parameter), error))?,
            faults: Faults::new(&scenario.faults, time, units.position_unit())
                .map_err(|error| Fault::new(format!("fault.{}", error.parameter), error))?,
        })
    }

    /// Begins a sample with the position that a sensor `beyond` (rad) the servo's start is shown, if there is a reading;
    /// inlined as is [`Summariser::add`](crate::analysis::Summariser::add).
    #[inline(always)]
    pub(crate) fn sense(&mut self, beyond: f64) -> (Option<f64>, Condition) {
        let condition = self.faults.begin_sample(&mut self.servo);
        let (position, velocity) = (self.servo.position(), self.servo.velocity());
        let seen = self.errors.seen(position, velocity) + beyond;
        (self.faults.seen(seen), condition)
    }

    /// The command that acts on the servo where this one is given.
    pub(crate) fn acting(&mut self, command: f64) -> f64 {
        self.faults.acting(command)
    }

    /// Ends the sample: the servo moves under this command until the next.
    pub(crate) fn advance(&mut self, command: f64) {
        let acting = self.acting(command);
        self.servo.advance(acting);
    }
}
