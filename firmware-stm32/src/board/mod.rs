//! Which pin is what: one file a board, chosen by a feature of its name.
//!
//! A board file has the crystal's frequency as `CRYSTAL` (Hz), the command of the whole output as
//! `FULL_SCALE`, the types `Encoder`, `Output` and `Inputs`, a function `wire` that makes a `Wired` of
//! the chip's peripherals, and `let_go` for emergencies. To add an F4 board, copy the one that is
//! there, change its pins, and name it here and in Cargo.toml.

#[cfg(feature = "olimex-stm32-h405")]
mod olimex_stm32_h405;
#[cfg(feature = "olimex-stm32-h405")]
pub use olimex_stm32_h405::{CRYSTAL, Encoder, Inputs, Output, STAGE, let_go, wire};

use stm32f4xx_hal::watchdog::IndependentWatchdog;

use crate::internal_flash::InternalFlash;
use crate::serial::{Line, Port};
use crate::timer::SampleTimer;
use drive_link::Fault;

/// Everything of a board that a drive uses.
pub struct Wired {
    /// Where the position is counted.
    pub encoder: Encoder,
    /// What the command moves.
    pub output: Output,
    /// The amplifier's fault line and the limit switches.
    pub inputs: Inputs,
    /// Beats at every sample.
    pub timer: SampleTimer,
    /// The background's end of the serial line.
    pub line: Line<'static>,
    /// The interrupt's end of the serial line.
    pub port: Port<'static>,
    /// Where records are kept.
    pub flash: InternalFlash,
    /// Resets the chip unless it is fed.
    pub watchdog: IndependentWatchdog,
    /// What was found wrong on the way: the clock, or that the watchdog was what reset the chip.
    pub found: Result<(), Fault>,
}
