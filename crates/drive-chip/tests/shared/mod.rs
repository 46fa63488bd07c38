//! The tests that every family passes, on a board that is wired alike.

mod clock;
pub(crate) mod flash;
mod inputs;
mod interrupts;
mod line_timer;
pub(crate) mod model;
mod pins;
mod pwm;
mod quadrature;
mod sample_timer;
mod serial;
mod step_input;
mod supply;
mod watchdog;
mod wiring;

use drive_chip::board::Board;
use drive_chip::serial::{Bytes, Ring};
use drive_chip::{Wired, wire};
use embedded_hal::pwm::SetDutyCycle;

use crate::Family;
use crate::facts::{OSCILLATOR, OWN, SOURCE, STEPS};
use crate::model::{Chip, Line, Output, Source};

/// A board that is wired as those of the firmware are.
pub(crate) const BOARD: Board<Family> = Board::of_64_pins(OSCILLATOR, OWN);

/// The chip of such a board, everything outside healthy.
pub(crate) fn healthy() -> Chip {
    with(SOURCE)
}

/// The chip of a board whose crystal does not work: it runs at 16 MHz.
pub(crate) fn slow() -> Chip {
    with(Source::Nothing)
}

fn with(source: Source) -> Chip {
    let chip = Chip::new(source);
    for (port, number) in [(1, 12), (2, 0), (2, 1)] {
        chip.drive(port, number, Line::Ground);
    }
    chip
}

/// Wires a board.
pub(crate) fn wired(chip: &Chip) -> Wired<'static, &Chip> {
    let (ring, queue) = memory(chip);
    wire(chip, &BOARD, ring, queue)
}

/// The same with the output at its full duty.
pub(crate) fn driving(chip: &Chip) -> Wired<'static, &Chip> {
    let mut wired = wired(chip);
    wired.timer.start(1e-3);
    drive_again(chip, &mut wired);
    wired
}

/// Switches the output off, which clears the flags of a break, and to its full duty.
pub(crate) fn drive_again(chip: &Chip, wired: &mut Wired<'static, &Chip>) {
    let Ok(()) = wired.pwm.set_duty_cycle_fully_off();
    let Ok(()) = wired.pwm.set_duty_cycle(STEPS);
    chip.elapse(50e-6);
    assert_eq!(chip.output(), Output::High);
}

/// Memory of a line, the ring of which the chip's DMA reaches.
pub(crate) fn memory(chip: &Chip) -> (&'static Ring, &'static mut Bytes) {
    let ring: &Ring = Box::leak(Box::new(Ring::new()));
    chip.usart.reach(ring);
    (ring, Box::leak(Box::new(Bytes::new())))
}
