//! A hardware quadrature counter as a position sensor.

use core::convert::Infallible;

use identifier_core::drive::PositionSensor;
use identifier_core::measurement::counter::Counter;
use stm32f4xx_hal::hal_02;

/// A timer of 16 bits that counts both edges of both lines, made endless.
///
/// It must be read before the servo has moved by half its range: 32 767 counts a sample are beyond
/// any servo.
pub struct Quadrature<Q> {
    counter: Counter<u16>,
    hardware: Q,
}

impl<Q: hal_02::Qei<Count = u16>> Quadrature<Q> {
    /// Starts at count zero, wherever the servo stands.
    #[must_use]
    pub fn new(hardware: Q) -> Self {
        Self {
            counter: Counter::new(hardware.count()),
            hardware,
        }
    }
}

impl<Q: hal_02::Qei<Count = u16>> PositionSensor for Quadrature<Q> {
    type Error = Infallible;

    #[inline]
    fn count(&mut self) -> Result<i64, Infallible> {
        Ok(self.counter.read(self.hardware.count()))
    }
}
