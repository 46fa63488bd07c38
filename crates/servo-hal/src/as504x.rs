use embedded_hal::spi::SpiDevice;

use crate::Angle14;
use identifier_core::drive::PositionSensor;
use identifier_core::measurement::Counter;

/// An AS5047P or AS5048A magnetic encoder over SPI (their data sheets, "SPI interface"): 14 bits per revolution,
/// 16-bit frames with even parity. An answer comes one frame after its request.
#[derive(Debug)]
pub struct As504x<B> {
    bus: B,
    counter: Counter<Angle14>,
}

/// Failures of a reading; the count is as before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum As504xError<E> {
    /// The bus failed.
    Bus(E),
    /// The frame's parity is odd: a disturbed or a cut line.
    Parity,
    /// The encoder reports that the frame before was wrong.
    Refused,
}

/// Read register 0x3fff, the angle, with the parity bit that makes the ones even.
const READ_ANGLE: [u8; 2] = [0xff, 0xff];

/// The bit by which the encoder reports an error.
const ERROR: u16 = 1 << 14;

impl<B: SpiDevice> As504x<B> {
    /// Counts from the present position.
    ///
    /// # Errors
    /// The first reading must not fail.
    pub fn new(mut bus: B) -> Result<Self, As504xError<B::Error>> {
        // The first answer belongs to no request.
        let mut frame = READ_ANGLE;
        bus.transfer_in_place(&mut frame)
            .map_err(As504xError::Bus)?;
        let angle = read(&mut bus)?;
        Ok(Self {
            bus,
            counter: Counter::new(angle),
        })
    }
}

impl<B: SpiDevice> PositionSensor for As504x<B> {
    type Error = As504xError<B::Error>;

    #[inline]
    fn count(&mut self) -> Result<i32, Self::Error> {
        let angle = read(&mut self.bus)?;
        Ok(self.counter.read(angle))
    }
}

#[inline]
fn read<B: SpiDevice>(bus: &mut B) -> Result<Angle14, As504xError<B::Error>> {
    let mut frame = READ_ANGLE;
    bus.transfer_in_place(&mut frame)
        .map_err(As504xError::Bus)?;
    let answer = u16::from_be_bytes(frame);
    if answer.count_ones() & 1 == 1 {
        Err(As504xError::Parity)
    } else if answer & ERROR != 0 {
        Err(As504xError::Refused)
    } else {
        Ok(Angle14::new(answer))
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use embedded_hal_mock::eh1::spi::{Mock, Transaction};

    use std::vec::Vec;

    fn answers(answers: &[u16]) -> Mock<u8> {
        let expected: Vec<Transaction<u8>> = answers
            .iter()
            .flat_map(|answer| {
                [
                    Transaction::transaction_start(),
                    Transaction::transfer_in_place(
                        READ_ANGLE.to_vec(),
                        answer.to_be_bytes().to_vec(),
                    ),
                    Transaction::transaction_end(),
                ]
            })
            .collect();
        Mock::new(&expected)
    }

    fn with_parity(raw: u16) -> u16 {
        raw | ((raw.count_ones() as u16 & 1) << 15)
    }

    #[test]
    fn it_counts_through_the_end_of_a_revolution() {
        let mut bus = answers(&[0, with_parity(16_380), with_parity(16_383), with_parity(5)]);
        let mut encoder = As504x::new(bus.clone()).expect("it answers");
        assert_eq!(encoder.count(), Ok(3));
        assert_eq!(encoder.count(), Ok(9));
        bus.done();
    }

    #[test]
    fn a_disturbed_frame_and_an_error_flag_are_reported_and_do_not_move_the_count() {
        let mut bus = answers(&[
            0,
            with_parity(100),
            with_parity(101) ^ 1,
            with_parity(ERROR | 7),
            with_parity(103),
        ]);
        let mut encoder = As504x::new(bus.clone()).expect("it answers");
        assert_eq!(encoder.count(), Err(As504xError::Parity));
        assert_eq!(encoder.count(), Err(As504xError::Refused));
        assert_eq!(encoder.count(), Ok(3));
        bus.done();
    }
}
