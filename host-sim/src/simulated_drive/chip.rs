//! The simulated servo as the drive's logic finds it: encoder, output stage and lines.

use drive_logic::{Chip, Lines};
use identifier_core::commission::{CommissionInputs, StopReason};
use identifier_core::drive::{Actuator, PositionSensor};

use crate::commission::Axis;

/// An axis behind the pins of a chip.
pub(super) struct SimulatedChip {
    axis: Axis,
    /// The step of the axis, s.
    step: f64,
    reading: Reading,
    output: Held,
    stop: Option<StopReason>,
    late: bool,
}

/// What the encoder showed at the beginning of the sample; nothing if that was no valid reading.
pub(super) struct Reading(Option<i32>);

/// The command that acts; none while the servo is let go.
pub(super) struct Held(Option<f32>);

impl SimulatedChip {
    /// With an axis that moves in steps of so many seconds.
    pub(super) fn new(axis: Axis, step: f64) -> Self {
        Self {
            axis,
            step,
            reading: Reading(None),
            output: Held(None),
            stop: None,
            late: false,
        }
    }

    /// Reads what there is to be read.
    pub(super) fn begin_sample(&mut self) {
        let CommissionInputs { count, late, stop } = self.axis.sense();
        self.reading = Reading(count);
        self.stop = stop;
        self.late = late;
    }

    /// Lets the axis move until the next sample, after a whole number of its steps.
    pub(super) fn pass(&mut self, sample_time: f64) {
        let command = self.output.0.map_or(0.0, f64::from);
        let steps = (sample_time / self.step).round().max(1.0) as u32;
        for step in 0..steps {
            if step > 0 {
                // What goes wrong with the time goes on.
                let _ = self.axis.sense();
            }
            self.axis.advance(command);
        }
    }
}

impl Chip for SimulatedChip {
    type Sensor = Reading;
    type Output = Held;

    fn lines(&self) -> Lines {
        Lines {
            amplifier: self.stop != Some(StopReason::AmplifierFault),
            low_switch: self.stop != Some(StopReason::LimitSwitch),
            high_switch: true,
        }
    }

    fn servo(&mut self) -> (&mut Reading, &mut Held) {
        (&mut self.reading, &mut self.output)
    }

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
