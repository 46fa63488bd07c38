//! The chip's clocks, from the board's oscillator.

use drive_link::Fault;

use crate::board::Oscillator;
use crate::family::{Bus, ClockTree};
pub use crate::frequencies::Clocks;

/// Sets the clocks. If the oscillator or the PLL does not become ready, the clocks stay those after reset, and the
/// result is the fault.
pub fn start<B: Bus>(bus: B, oscillator: Oscillator<B::Family>) -> (Clocks, Result<(), Fault>) {
    // A debugger restarts a program with the clocks of the previous run.
    B::Family::reset_clock(bus);
    if B::Family::start_clock(bus, oscillator.frequency, oscillator.kind).is_some() {
        (B::Family::CLOCKS, Ok(()))
    } else {
        B::Family::reset_clock(bus);
        (Clocks::RESET, Err(Fault::ClockNotStable))
    }
}
