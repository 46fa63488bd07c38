//! The simulated servo behind encoder, output stage and lines of a chip.

use std::f64::consts::TAU;

use commissioning::CommissionInputs;
use drive_logic::{Chip, Lines};
use host_sim::commission::CommissionedAxis;
use identifier_core::drive::{Actuator, PositionSensor};
use identifier_core::reason::Reason;

/// An axis behind the pins of a chip.
pub(super) struct SimulatedChip {
    axis: CommissionedAxis,
    /// The step of the axis, s.
    step: f64,
    reading: Reading,
    output: Held,
    stop: Option<Reason>,
    late: bool,
    /// The count at the last index pulse, to a sample, and the revolution that it began.
    index: Option<i32>,
    revolution: f64,
    /// The holding brake, if there is one, has power.
    opens_brake: bool,
}

/// The home switch is closed below this position, rad from the start.
const HOME_SWITCH: f64 = -2.0;

/// An index pulse, rad from the start; one more in every revolution.
const INDEX: f64 = -1.0;

/// The count at the beginning of the sample; `None` for an invalid reading.
pub(super) struct Reading(Option<i32>);

/// The command that acts; `None` while the stage is disabled.
#[derive(Debug)]
pub struct Held(pub Option<f32>);

impl SimulatedChip {
    /// With an axis that moves in steps of `step` seconds.
    pub(super) fn new(axis: CommissionedAxis, step: f64) -> Self {
        Self {
            axis,
            step,
            reading: Reading(None),
            output: Held(None),
            stop: None,
            late: false,
            index: None,
            revolution: 0.0,
            opens_brake: false,
        }
    }
}

impl SimulatedPins for SimulatedChip {
    fn begin_sample(&mut self) {
        let CommissionInputs { count, late, stop } = self.axis.sense();
        self.reading = Reading(count);
        self.stop = stop;
        self.late = late;
        let revolution = ((self.axis.position() - INDEX) / TAU).floor();
        let before = std::mem::replace(&mut self.revolution, revolution);
        if before.to_bits() != revolution.to_bits() {
            self.index = count;
        }
    }

    /// After a whole number of the axis's steps.
    fn pass(&mut self, sample_time: f64) {
        let command = self.output.0.map_or(0.0, f64::from);
        let has_power = self.opens_brake && self.output.0.is_some();
        let steps = (sample_time / self.step).round().max(1.0) as u32;
        for step in 0..steps {
            if step > 0 {
                // Faults develop with every step.
                let _ = self.axis.sense();
            }
            self.axis.advance_beside_brake(command, has_power);
        }
    }
}

impl Chip for SimulatedChip {
    type Sensor = Reading;
    type Output = Held;

    fn lines(&self) -> Lines {
        Lines {
            amplifier: self.stop != Some(Reason::AmplifierFault),
            low_switch: self.stop != Some(Reason::LimitSwitch),
            ..Lines::HEALTHY
        }
    }

    fn servo(&mut self) -> (&mut Reading, &mut Held) {
        (&mut self.reading, &mut self.output)
    }

    fn home_switch_is_closed(&self) -> bool {
        self.axis.position() < HOME_SWITCH
    }

    fn index(&mut self) -> Option<i32> {
        self.index.take()
    }

    /// Nothing is connected to it.
    fn steps(&mut self) -> Option<i16> {
        Some(0)
    }

    fn set_brake(&mut self, open: bool) {
        self.opens_brake = open;
    }

    /// Nothing is connected to it.
    fn next_is_due(&self) -> bool {
        self.late
    }

    fn feed_watchdog(&mut self) {}
}

impl PositionSensor for Reading {
    type Error = ();

    fn count(&mut self) -> Result<i32, ()> {
        self.0.ok_or(())
    }
}

impl Actuator<f32> for Held {
    type Error = ();

    fn hold(&mut self, command: f32) -> Result<(), ()> {
        self.0 = Some(command);
        Ok(())
    }

    fn release(&mut self) -> Result<(), ()> {
        self.0 = None;
        Ok(())
    }
}

/// The pins of a chip, led to a simulated servo.
pub trait SimulatedPins: Chip {
    /// Latches encoder and lines at the beginning of a sample.
    fn begin_sample(&mut self) {}

    /// Moves the servo until the next sample.
    fn pass(&mut self, sample_time: f64);

    /// The drive has power.
    fn is_powered(&self) -> bool {
        true
    }
}
