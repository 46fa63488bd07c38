//! The control step of a drive over traits for sensor and actuator. The same body runs with a chip's peripherals, a
//! virtual servo on the chip and a plant on a PC.

mod control_step;

pub use control_step::ControlStepError;

/// A position counter. embedded-hal has no trait for it: quadrature counters differ too much.
pub trait PositionSensor {
    /// Why a reading failed.
    type Error: core::fmt::Debug;

    /// The count now, wrapping at 32 bits (see [`Counter`](crate::measurement::counter::Counter)).
    ///
    /// # Errors
    /// The sensor's own error; the step is then not taken.
    fn count(&mut self) -> Result<i32, Self::Error>;
}

/// The output stage that the command drives.
pub trait Actuator<N> {
    /// Why a command could not be given.
    type Error: core::fmt::Debug;

    /// Holds a command, command units, until the next one.
    ///
    /// # Errors
    /// The actuator's own error.
    fn hold(&mut self, command: N) -> Result<(), Self::Error>;

    /// Disables the output stage: no force, the servo coasts.
    ///
    /// # Errors
    /// The actuator's own error.
    fn release(&mut self) -> Result<(), Self::Error>;
}
