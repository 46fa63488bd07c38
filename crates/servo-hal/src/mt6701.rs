use embedded_hal::spi::SpiDevice;

use crate::Angle14;
use identifier_core::drive::PositionSensor;
use identifier_core::measurement::Counter;

/// An MT6701 magnetic encoder over its synchronous serial interface (its data sheet, "SSI"): 24 bits. 14 are the
/// angle, 4 the state of the magnetic field, 6 a CRC over these.
#[derive(Debug)]
pub struct Mt6701<B> {
    bus: B,
    counter: Counter<Angle14>,
}

/// Failures of a reading; the count is as before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Mt6701Error<E> {
    /// The bus failed.
    Bus(E),
    /// The CRC does not match: a disturbed or a cut line.
    Crc,
    /// The magnet is too near, too far or gone.
    Field,
    /// The magnet turns faster than the encoder follows.
    TrackLost,
}

impl<B: SpiDevice> Mt6701<B> {
    /// Counts from the present position.
    ///
    /// # Errors
    /// The first reading must not fail.
    pub fn new(mut bus: B) -> Result<Self, Mt6701Error<B::Error>> {
        let angle = read(&mut bus)?;
        Ok(Self {
            bus,
            counter: Counter::new(angle),
        })
    }
}

impl<B: SpiDevice> PositionSensor for Mt6701<B> {
    type Error = Mt6701Error<B::Error>;

    #[inline]
    fn count(&mut self) -> Result<i32, Self::Error> {
        let angle = read(&mut self.bus)?;
        Ok(self.counter.read(angle))
    }
}

fn read<B: SpiDevice>(bus: &mut B) -> Result<Angle14, Mt6701Error<B::Error>> {
    /// Bits of the state: the field is neither too strong nor too weak, the track is kept.
    const FIELD: u32 = 0b0011;
    const TRACK_LOST: u32 = 0b1000;
    let mut frame = [0; 3];
    bus.read(&mut frame).map_err(Mt6701Error::Bus)?;
    let [high, middle, low] = frame.map(u32::from);
    let bits = (high << 16) | (middle << 8) | low;
    let (message, crc) = (bits >> 6, bits & 0x3f);
    if remainder(message) != crc {
        return Err(Mt6701Error::Crc);
    }
    let state = message & 0xf;
    if state & TRACK_LOST != 0 {
        Err(Mt6701Error::TrackLost)
    } else if state & FIELD != 0 {
        Err(Mt6701Error::Field)
    } else {
        Ok(Angle14::new((message >> 4) as u16))
    }
}

/// The remainder of 18 bits for x⁶ + x + 1.
fn remainder(message: u32) -> u32 {
    const POLYNOMIAL: u32 = 0b100_0011;
    let mut rest = message << 6;
    for bit in (6..24).rev() {
        if rest & (1 << bit) != 0 {
            rest ^= POLYNOMIAL << (bit - 6);
        }
    }
    rest & 0x3f
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use embedded_hal_mock::eh1::spi::{Mock, Transaction};
    use proptest::prelude::*;

    use std::vec::Vec;

    fn frame(angle: u32, state: u32) -> [u8; 3] {
        let message = (angle << 4) | state;
        let [_, high, middle, low] = ((message << 6) | remainder(message)).to_be_bytes();
        [high, middle, low]
    }

    fn answers(frames: &[[u8; 3]]) -> Mock<u8> {
        let expected: Vec<Transaction<u8>> = frames
            .iter()
            .flat_map(|frame| {
                [
                    Transaction::transaction_start(),
                    Transaction::read_vec(frame.to_vec()),
                    Transaction::transaction_end(),
                ]
            })
            .collect();
        Mock::new(&expected)
    }

    #[test]
    fn it_counts_backwards_through_zero() {
        let mut bus = answers(&[frame(2, 0), frame(16_383, 0)]);
        let mut encoder = Mt6701::new(bus.clone()).expect("it answers");
        assert_eq!(encoder.count(), Ok(-3));
        bus.done();
    }

    #[test]
    fn errors_of_the_encoder_are_reported() {
        let mut cut = frame(7, 0);
        cut[0] ^= 0x10;
        let mut bus = answers(&[
            frame(7, 0),
            cut,
            frame(7, 0b0010),
            frame(7, 0b1000),
            [0xff; 3],
        ]);
        let mut encoder = Mt6701::new(bus.clone()).expect("it answers");
        assert_eq!(encoder.count(), Err(Mt6701Error::Crc));
        assert_eq!(encoder.count(), Err(Mt6701Error::Field));
        assert_eq!(encoder.count(), Err(Mt6701Error::TrackLost));
        assert_eq!(encoder.count(), Err(Mt6701Error::Crc));
        bus.done();
    }

    proptest! {
        #[test]
        fn every_single_and_double_bit_error_is_seen(
            message in 0_u32..1 << 18,
            first in 0_u32..24,
            second in 0_u32..24,
        ) {
            let sound = (message << 6) | remainder(message);
            let disturbed = sound ^ (1 << first) ^ if first == second { 0 } else { 1 << second };
            prop_assert_ne!(remainder(disturbed >> 6), disturbed & 0x3f);
        }
    }
}
