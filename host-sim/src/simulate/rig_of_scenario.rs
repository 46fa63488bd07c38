//! From a scenario to its test rig.

use identifier_core::excitation::Excitation;
use identifier_core::number::Number;
use virtual_servo::faults::Faults;
use virtual_servo::{SensorEffects, SensorErrors, Servo};

use super::SimulatedAxis;
use super::sensor::Sensor;
use crate::scenario::{Fault, Scenario, in_effect};

impl SimulatedAxis<'_> {
    /// The rig of a scenario, its signals in the number format of the loop.
    pub(crate) fn build<N: Number>(scenario: &Scenario) -> Result<Self, Fault> {
        let reference = scenario.reference::<N>()?;
        let units = scenario.checked_units()?;
        let (time, seed) = (units.sample_time(), scenario.noise_seed());
        let servo = Servo::at_rest(&scenario.servo()?, &scenario.effects, time, seed);
        let errors = SensorErrors::new(&scenario.sensor, time, seed)
            .map_err(|error| Fault::new(format!("encoder.{}", error.parameter), error))?;
        let faults = Faults::new(&scenario.faults, time, units.position_unit())
            .map_err(|error| Fault::new(format!("fault.{}", error.parameter), error))?;
        let mut progress = reference.start();
        Ok(Self {
            sample_time: units.sample_time(),
            position_unit: units.position_unit(),
            samples: scenario.samples(),
            reference: Box::new(move || reference.process(&mut progress).to_f64()),
            sensor: match scenario.counts_per_rev {
                Some(counts) => Sensor::encoder(counts, 0),
                None => Sensor::ideal::<N>(units.position()),
            },
            sensor_errors: (scenario.sensor != SensorEffects::default()).then_some(errors),
            servo: servo.map_err(|error| in_effect(&error))?,
            faults: (!scenario.faults.is_empty()).then_some(faults),
        })
    }

    /// The same with a counter that shows `start` where the servo starts; an ideal sensor counts
    /// position units.
    #[cfg(feature = "experiments")]
    pub(crate) fn counting_from(mut self, start: i32) -> Self {
        self.sensor = match self.sensor {
            Sensor::Encoder { encoder, .. } => Sensor::Encoder { encoder, start },
            Sensor::Ideal { .. } => {
                Sensor::encoder(std::f64::consts::TAU / self.position_unit, start)
            }
        };
        self
    }
}
