//! The drivers against a model of an STM32G474.

#[path = "../shared/analogue_input.rs"]
mod analogue_input;
mod clock;
mod facts;
mod flash;
#[path = "../shared/inputs.rs"]
mod inputs;
#[path = "../shared/interrupts.rs"]
mod interrupts;
#[path = "../shared/line_timer.rs"]
mod line_timer;
mod model;
mod option_bytes;
mod over_current;
#[path = "../shared/pins.rs"]
mod pins;
#[path = "../shared/pwm.rs"]
mod pwm;
#[path = "../shared/quadrature.rs"]
mod quadrature;
#[path = "../shared/sample_timer.rs"]
mod sample_timer;
#[path = "../shared/serial.rs"]
mod serial;
#[path = "../shared/step_input.rs"]
mod step_input;
#[path = "../shared/supply.rs"]
mod supply;
#[path = "../shared/watchdog.rs"]
mod watchdog;
#[path = "../shared/wiring.rs"]
mod wiring;

use drive_chip::G4;
use drive_chip::board::{Board, Oscillator};
use drive_chip::flash::Areas;
use drive_chip::g4::OverCurrent;
use drive_chip::pins::{Pin, Port};
use drive_chip::serial::{Bytes, Ring};
use drive_chip::{Wired, wire};
use model::{Chip, Line, Source};
use stm32g4::stm32g474 as pac;

/// The family.
pub(crate) type Family = G4;

/// A board with a crystal of 24 MHz, wired as those of the firmware are.
pub(crate) const BOARD: Board<G4> = Board {
    oscillator: Oscillator::crystal(24_000_000),
    encoder: [Pin::new(Port::C, 6), Pin::new(Port::C, 7)],
    index: Pin::new(Port::C, 8),
    pwm: Pin::new(Port::A, 8),
    direction: Pin::new(Port::B, 14),
    enable: Pin::new(Port::B, 15),
    fault: Pin::new(Port::B, 12),
    low_switch: Pin::new(Port::C, 0),
    high_switch: Pin::new(Port::C, 1),
    home_switch: Pin::new(Port::C, 2),
    step: [Pin::new(Port::B, 6), Pin::new(Port::B, 7)],
    analogue: Pin::new(Port::A, 1),
    serial: [Pin::new(Port::A, 2), Pin::new(Port::A, 3)],
    records: Areas::starting_at(1),
    own: OverCurrent::above(Pin::new(Port::A, 0), 2_500),
};

/// The chip of such a board, everything outside healthy.
pub(crate) fn healthy() -> Chip {
    with(Source::Crystal(24e6))
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

/// Memory of a line, the ring of which the chip's DMA reaches.
pub(crate) fn memory(chip: &Chip) -> (&'static Ring, &'static mut Bytes) {
    let ring: &Ring = Box::leak(Box::new(Ring::new()));
    chip.usart.reach(ring);
    (ring, Box::leak(Box::new(Bytes::new())))
}
