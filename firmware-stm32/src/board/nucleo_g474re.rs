//! ST NUCLEO-G474RE, with an STM32G474RE and a crystal of 24 MHz. Its debug probe is the host's end of the serial line
//! (UM2505). It has the pins of the NUCLEO-F446RE, and a limit of the current in hardware besides.
//!
//! | pin | at | what | towards |
//! |---|---|---|---|
//! | PC6, PC7 | CN10 4, CN10 19 | encoder A and B (TIM3), pulled up | encoder |
//! | PC8 | CN10 2 | encoder index (TIM3 channel 3), pulled up: a rising edge counts | encoder |
//! | PA8 | CN10 23, D7 | PWM, 20 kHz (TIM1 channel 1) | amplifier |
//! | PB14 | CN10 28 | direction, high is positive (TIM1 channel 2, complementary) | amplifier |
//! | PB15 | CN10 26 | enable, high is on; pull it down outside | amplifier |
//! | PB13 | CN10 30 | brake, high opens it; pull it down outside | holding brake, by a transistor |
//! | PB12 | CN10 16 | fault (TIM1 break), pulled up: low is healthy | amplifier |
//! | PA0 | CN7 28 (A0) | voltage of the current's magnitude (COMP3, TIM1 break), below 2.5 V is healthy | amplifier |
//! | PC0, PC1 | CN7 38, CN7 36 (A5, A4) | limit switches, lower and upper end, pulled up: closed to ground is healthy | switches |
//! | PC2 | CN7 35 | home switch, pulled up: closed to ground is at home | switch |
//! | PB6, PB7 | CN10 17, CN7 21 | step and direction (TIM4), pulled up, 3.3 V or open collector | controller |
//! | PA2, PA3 | on the board | serial line, out and in (USART2), 1 Mbaud, over the probe's USB | host |
//!
//! PA0 has no pull. With a resistor of 1 MΩ to 3.3 V outside, a broken wire disables the output too. One that is not
//! used is bridged to ground.

use drive_chip::G4;
use drive_chip::board::{Board, Oscillator};
use drive_chip::g4::OverCurrent;
use drive_chip::pins::{Pin, Port};

/// Its name, that of its feature.
pub const NAME: &str = "nucleo-g474re";

/// The board. Its flash keeps the records in the areas 1 and 2.
pub const BOARD: Board<G4> = Board::of_64_pins(
    Oscillator::crystal(24_000_000),
    OverCurrent::above(Pin::new(Port::A, 0), 2_500),
);
