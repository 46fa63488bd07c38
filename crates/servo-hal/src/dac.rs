use embedded_hal::spi::SpiDevice;

use crate::{fraction, reciprocal};
use identifier_core::drive::Actuator;
use identifier_core::error::OutOfRange;

/// An AD5761 or AD5761R, a 16-bit DAC with a bipolar output (its data sheet, "Input shift register"),
/// set to ±10 V: the input of an analogue amplifier in current mode.
#[derive(Debug)]
pub struct Ad5761<B> {
    bus: B,
    per_unit: f32,
}

/// Register addresses, bits 19 to 16 of a frame.
const WRITE_AND_UPDATE: u8 = 0b0011;
const WRITE_CONTROL: u8 = 0b0100;

/// Control register: output ±10 V (RA = 000), straight binary, middle scale when it wakes and when it
/// is cleared (PV = 01, CV = 01), and on the R the internal reference.
const CONTROL: u16 = 0b0000_0010_0010_1000;

/// Half the code's range: zero volts.
const MIDDLE: f32 = 32_768.0;

impl<B: SpiDevice> Ad5761<B> {
    /// Sets the range and puts out zero. `full_scale` is the command that asks for 10 V, command
    /// units.
    ///
    /// # Errors
    /// `full_scale` must be above zero.
    pub fn new(bus: B, full_scale: f32) -> Result<Self, OutOfRange> {
        Ok(Self {
            bus,
            per_unit: reciprocal(full_scale)?,
        })
    }

    /// Sets range and middle scale; before the first command.
    ///
    /// # Errors
    /// Whatever the bus answers.
    pub fn start(&mut self) -> Result<(), B::Error> {
        self.write(WRITE_CONTROL, CONTROL)?;
        self.write(WRITE_AND_UPDATE, MIDDLE as u16)
    }

    #[inline]
    fn write(&mut self, register: u8, data: u16) -> Result<(), B::Error> {
        let [high, low] = data.to_be_bytes();
        self.bus.write(&[register, high, low])
    }
}

impl<B: SpiDevice> Actuator<f32> for Ad5761<B> {
    type Error = B::Error;

    #[inline]
    fn hold(&mut self, command: f32) -> Result<(), B::Error> {
        // A cast saturates: the positive end is one code short of 10 V.
        let code = (MIDDLE + fraction(command, self.per_unit) * MIDDLE + 0.5) as u16;
        self.write(WRITE_AND_UPDATE, code)
    }

    fn release(&mut self) -> Result<(), B::Error> {
        self.write(WRITE_AND_UPDATE, MIDDLE as u16)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use embedded_hal_mock::eh1::spi::{Mock, Transaction};

    use std::vec::Vec;

    fn frames(frames: &[[u8; 3]]) -> Mock<u8> {
        let expected: Vec<Transaction<u8>> = frames
            .iter()
            .flat_map(|frame| {
                [
                    Transaction::transaction_start(),
                    Transaction::write_vec(frame.to_vec()),
                    Transaction::transaction_end(),
                ]
            })
            .collect();
        Mock::new(&expected)
    }

    #[test]
    fn it_wakes_at_zero_and_follows_the_command() {
        let mut bus = frames(&[
            [0x4, 0x02, 0x28],
            [0x3, 0x80, 0x00],
            [0x3, 0xc0, 0x00],
            [0x3, 0x00, 0x00],
            [0x3, 0xff, 0xff],
            [0x3, 0x80, 0x00],
        ]);
        let mut dac = Ad5761::new(bus.clone(), 10.0).expect("valid");
        dac.start().expect("no fault");
        for command in [5.0, -10.0, 99.0] {
            dac.hold(command).expect("no fault");
        }
        dac.release().expect("no fault");
        bus.done();
    }
}
