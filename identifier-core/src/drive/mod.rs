//! The control step of a drive, whatever measures and whatever acts: the same body runs against a
//! chip's peripherals, a virtual servo on the chip and a plant on a PC.

#[cfg(feature = "hal")]
pub mod hal;
mod tick;

pub use tick::{Tick, TickError, TickState, Ticked};

/// What counts the position. embedded-hal has no trait for it: quadrature counters differ too much.
pub trait PositionSensor {
    /// Why a reading failed.
    type Error: core::fmt::Debug;

    /// The count now, endless (see [`Counter`](crate::measurement::counter::Counter)).
    ///
    /// # Errors
    /// Whatever the sensor answers; the step is then not taken.
    fn count(&mut self) -> Result<i64, Self::Error>;
}

/// What the command moves.
pub trait Actuator<N> {
    /// Why a command could not be given.
    type Error: core::fmt::Debug;

    /// Holds a command, command units, until the next one.
    ///
    /// # Errors
    /// Whatever the actuator answers.
    fn hold(&mut self, command: N) -> Result<(), Self::Error>;

    /// Lets the servo go: no force.
    ///
    /// # Errors
    /// Whatever the actuator answers.
    fn release(&mut self) -> Result<(), Self::Error>;
}
