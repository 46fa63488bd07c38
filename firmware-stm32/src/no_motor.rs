//! Encoder and output stage of a bare board: a servo on the chip is between them, and the pins stay disabled.

use core::convert::Infallible;

use identifier_core::drive::{Actuator, PositionSensor};

use crate::board;
use crate::servo_on_chip::ServoOnChip;

/// The encoder of the servo on the chip.
#[derive(Default)]
pub struct Encoder {
    servo: ServoOnChip,
    count: i32,
}

/// The output stage before it: the command that it holds.
#[derive(Default)]
pub struct Output(Option<f32>);

/// Takes the place of the board's own, which are of no use any more.
#[must_use]
pub fn in_place_of(_: board::Encoder, mut output: board::Output) -> (Encoder, Output) {
    if Actuator::<f32>::release(&mut output).is_err() {
        board::disable_outputs();
    }
    Default::default()
}

impl Encoder {
    /// Moves the servo by a sample.
    #[inline(never)]
    pub fn advance(&mut self, output: &Output) {
        // The count wraps, as that of an encoder.
        self.count = self.servo.advance(output.0.unwrap_or(0.0).into()) as i32;
    }

    /// It has no index.
    pub fn index(&mut self) -> Option<i32> {
        None
    }
}

impl Output {
    /// There is no brake.
    pub fn set_brake(&mut self, _: bool) -> Result<(), Infallible> {
        Ok(())
    }
}

impl PositionSensor for Encoder {
    type Error = Infallible;

    fn count(&mut self) -> Result<i32, Infallible> {
        Ok(self.count)
    }
}

impl Actuator<f32> for Output {
    type Error = Infallible;

    fn hold(&mut self, command: f32) -> Result<(), Infallible> {
        self.0 = Some(command);
        Ok(())
    }

    fn release(&mut self) -> Result<(), Infallible> {
        self.0 = None;
        Ok(())
    }
}
