//! ST NUCLEO-F446RE, with an STM32F446RE. The debug probe on it gives the clock and is the host's end of the serial
//! line (UM1724, 6.7.1 and 6.8).
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
//! | PC0, PC1 | CN7 38, CN7 36 (A5, A4) | limit switches, lower and upper end, pulled up: closed to ground is healthy | switches |
//! | PC2 | CN7 35 | home switch, pulled up: closed to ground is at home | switch |
//! | PB6, PB7 | CN10 17, CN7 21 | step and direction (TIM4), pulled up, 3.3 V or open collector | controller |
//! | PA2, PA3 | on the board | serial line, out and in (USART2), 1 Mbaud, over the probe's USB | host |
//!
//! PA5 is the green LED too, which then flickers.

use drive_chip::F4;
use drive_chip::board::{Board, Oscillator};

/// Its name, that of its feature.
pub const NAME: &str = "nucleo-f446re";

/// The board. Its flash keeps the records in the sectors 1 and 2.
pub const BOARD: Board<F4> = Board::of_64_pins(Oscillator::clock(8_000_000), ());
