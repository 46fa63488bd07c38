//! Olimex STM32-H405, with an STM32F405RG.
//!
//! | pin | what | towards |
//! |---|---|---|
//! | PC6, PC7 | encoder A and B (TIM3), pulled up | encoder |
//! | PC8 | encoder index (TIM3 channel 3), pulled up: a rising edge counts | encoder |
//! | PA8 | PWM, 20 kHz (TIM1 channel 1) | amplifier |
//! | PB14 | direction, high is positive (TIM1 channel 2, complementary) | amplifier |
//! | PB15 | enable, high is on; pull it down outside | amplifier |
//! | PB13 | brake, high opens it; pull it down outside | holding brake, by a transistor |
//! | PB12 | fault (TIM1 break), pulled up: low is healthy | amplifier |
//! | PC0, PC1 | limit switches, lower and upper end, pulled up: closed to ground is healthy | switches |
//! | PC2 | home switch, pulled up: closed to ground is at home | switch |
//! | PB6, PB7 | step and direction (TIM4), pulled up, 3.3 V or open collector | controller |
//! | PA2, PA3 | serial line, out and in (USART2), 1 Mbaud, 3.3 V | host |

use drive_chip::F4;
use drive_chip::board::{Board, Oscillator};

/// Its name, that of its feature.
pub const NAME: &str = "olimex-stm32-h405";

/// The board. Its flash keeps the records in the sectors 1 and 2.
pub const BOARD: Board<F4> = Board::of_64_pins(Oscillator::crystal(8_000_000), ());
