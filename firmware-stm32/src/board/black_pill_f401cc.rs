//! WeAct Black Pill with an STM32F401CC: a small board. Its drive runs, identifies friction and load, and watches, but does
//! not commission. The PC computes its gains.
//!
//! | pin | what | towards |
//! |---|---|---|
//! | PA6, PA7 | encoder A and B (TIM3), pulled up | encoder |
//! | PB0 | encoder index (TIM3 channel 3), pulled up: a rising edge counts | encoder |
//! | PA8 | PWM, 20 kHz (TIM1 channel 1) | amplifier |
//! | PB14 | direction, high is positive (TIM1 channel 2, complementary) | amplifier |
//! | PB15 | enable, high is on; pull it down outside | amplifier |
//! | PB13 | brake, high opens it; pull it down outside | holding brake, by a transistor |
//! | PB12 | fault (TIM1 break), pulled up: low is healthy | amplifier |
//! | PA5, PA1 | limit switches, lower and upper end, pulled up: closed to ground is healthy | switches |
//! | PA4 | home switch, pulled up: closed to ground is at home | switch |
//! | PB6, PB7 | step and direction (TIM4), pulled up, 3.3 V or open collector | controller |
//! | PA2, PA3 | serial line, out and in (USART2), 1 Mbaud, 3.3 V | host |

use drive_chip::F401;
use drive_chip::board::{Board, Oscillator};
use drive_chip::flash::Areas;
use drive_chip::pins::{Pin, Port};

/// Its name, that of its feature.
pub const NAME: &str = "black-pill-f401cc";

/// The board. Its flash keeps the records in the sectors 1 and 2.
pub const BOARD: Board<F401> = Board {
    oscillator: Oscillator::crystal(25_000_000),
    encoder: [Pin::new(Port::A, 6), Pin::new(Port::A, 7)],
    index: Pin::new(Port::B, 0),
    pwm: Pin::new(Port::A, 8),
    direction: Pin::new(Port::B, 14),
    enable: Pin::new(Port::B, 15),
    brake: Pin::new(Port::B, 13),
    fault: Pin::new(Port::B, 12),
    low_switch: Pin::new(Port::A, 5),
    high_switch: Pin::new(Port::A, 1),
    home_switch: Pin::new(Port::A, 4),
    step: [Pin::new(Port::B, 6), Pin::new(Port::B, 7)],
    serial: [Pin::new(Port::A, 2), Pin::new(Port::A, 3)],
    records: Areas::starting_at(1),
    own: (),
};
