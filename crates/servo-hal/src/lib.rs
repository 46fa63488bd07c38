//! Adapters over embedded-hal 1.0: actuators and sensors for whatever implements its traits.
//!
//! | adapter | drives or reads | over |
//! |---|---|---|
//! | [`PwmDirection`] | a bridge with a PWM and a direction input | `SetDutyCycle`, `OutputPin` |
//! | [`LockedAntiphase`] | a bridge whose one PWM means standstill at one half | `SetDutyCycle` |
//! | [`HalfBridges`] | two half bridges, one for each direction | two `SetDutyCycle` |
//! | [`Gate`] | any of these with an enable pin, and that of a holding brake | `OutputPin` |
//! | [`As504x`] | AS5047P and AS5048A magnetic encoders, parity checked | `SpiDevice` |
//! | [`Mt6701`] | MT6701 magnetic encoder, CRC checked | `SpiDevice` |
//!
//! A command is held with as many duty steps as the PWM has; what one step is in command units is
//! its resolution. Quadrature counters have no trait of embedded-hal: implement
//! [`PositionSensor`](identifier_core::drive::PositionSensor) over the chip's own and a
//! [`Counter`](identifier_core::measurement::Counter).

#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod as504x;
mod bridge;
mod gate;
mod mt6701;

pub use as504x::{As504x, As504xError};
pub use bridge::{BridgeError, HalfBridges, LockedAntiphase, PwmDirection};
pub use gate::{Gate, GateError};
pub use mt6701::{Mt6701, Mt6701Error};

use identifier_core::measurement::CounterRegister;

/// A revolution in 14 bits, as magnetic encoders give it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Angle14(u16);

impl Angle14 {
    const BITS: u32 = 14;

    fn new(raw: u16) -> Self {
        Self(raw & ((1 << Self::BITS) - 1))
    }
}

impl CounterRegister for Angle14 {
    /// The shorter way round.
    fn moved_since(self, earlier: Self) -> i32 {
        const UNUSED: u32 = u16::BITS - Angle14::BITS;
        let moved = (self.0 << UNUSED).wrapping_sub(earlier.0 << UNUSED);
        i32::from(moved.cast_signed() >> UNUSED)
    }
}

/// The full scale of a command: the command that asks for everything there is.
fn reciprocal(full_scale: f32) -> Result<f32, identifier_core::error::OutOfRange> {
    let full_scale = f64::from(full_scale);
    identifier_core::error::Allowed::Above(0.0).check("full_scale", full_scale)?;
    // A configuration value: divided once.
    Ok((1.0 / full_scale) as f32)
}

/// A command as a fraction of its full scale, within ±1; zero for what is no number.
#[inline]
fn fraction(command: f32, per_unit: f32) -> f32 {
    let fraction = command * per_unit;
    if fraction.abs() < 1.0 {
        fraction
    } else {
        limited(fraction)
    }
}

/// A fraction that is not within ±1.
#[cold]
fn limited(fraction: f32) -> f32 {
    if fraction.is_nan() {
        0.0
    } else {
        fraction.signum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use identifier_core::measurement::Counter;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn fourteen_bits_follow_any_walk(
            start in 0_i64..16_384,
            moves in prop::collection::vec(-8191_i64..8192, 0..500),
        ) {
            let raw = |count: i64| Angle14::new((count & 0x3fff) as u16);
            let mut counter = Counter::new(raw(start));
            let mut count = start;
            for step in moves {
                count += step;
                prop_assert_eq!(i64::from(counter.read(raw(count))), count - start);
            }
        }

        #[test]
        fn a_fraction_is_one(command in any::<f32>()) {
            let fraction = fraction(command, 0.1);
            prop_assert!((-1.0..=1.0).contains(&fraction));
        }
    }
}
