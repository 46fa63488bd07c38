//! A hardware quadrature counter as a position sensor.

use core::convert::Infallible;

use identifier_core::drive::PositionSensor;
use identifier_core::measurement::counter::{Counter, CounterRegister};
use stm32f4xx_hal::hal_02;

/// A timer that counts both edges of both lines, of 16 bits or of 32.
///
/// One of 16 bits must be read before the servo has moved by half its range: 32 767 counts a sample
/// are beyond any servo.
pub struct Quadrature<Q: hal_02::Qei> {
    counter: Counter<Q::Count>,
    hardware: Q,
}

impl<Q: hal_02::Qei<Count: CounterRegister>> Quadrature<Q> {
    /// Starts at count zero, wherever the servo stands.
    #[must_use]
    pub fn new(hardware: Q) -> Self {
        Self {
            counter: Counter::new(hardware.count()),
            hardware,
        }
    }
}

impl<Q: hal_02::Qei<Count: CounterRegister>> PositionSensor for Quadrature<Q> {
    type Error = Infallible;

    #[inline]
    fn count(&mut self) -> Result<i32, Infallible> {
        Ok(self.counter.read(self.hardware.count()))
    }
}
