//! The data that differ from board to board.

use crate::flash::Sectors;
use crate::pins::Pin;

/// The source of the chip's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Oscillator {
    pub(crate) frequency: u32,
    pub(crate) kind: Kind,
}

/// The device at the pins OSC_IN and OSC_OUT.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Crystal,
    Clock,
}

impl Oscillator {
    /// The PLL's input, Hz: it takes 1 to 2 MHz, and its jitter is least at 2 (RM0090, 7.3.2).
    pub(crate) const PLL_INPUT: u32 = 2_000_000;

    /// A crystal between OSC_IN and OSC_OUT, Hz: a multiple of 2 MHz from 4 to 26 MHz.
    ///
    /// # Panics
    /// Any other frequency; in a constant it does not compile.
    #[must_use]
    pub const fn crystal(frequency: u32) -> Self {
        Self::new(frequency, Kind::Crystal)
    }

    /// An external clock at OSC_IN, Hz, within the same range.
    ///
    /// # Panics
    /// As [`Oscillator::crystal`].
    #[must_use]
    pub const fn clock(frequency: u32) -> Self {
        Self::new(frequency, Kind::Clock)
    }

    const fn new(frequency: u32, kind: Kind) -> Self {
        assert!(
            frequency.is_multiple_of(Self::PLL_INPUT),
            "the oscillator must be a multiple of 2 MHz"
        );
        assert!(
            4_000_000 <= frequency && frequency <= 26_000_000,
            "the oscillator must be from 4 to 26 MHz"
        );
        Self { frequency, kind }
    }
}

/// A board: its oscillator, the functions of its pins, and the sectors of the flash that keep records.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Board {
    /// The source of the chip's clock.
    pub oscillator: Oscillator,
    /// Encoder A and B: channels 1 and 2 of TIM3, pulled up.
    pub encoder: [Pin; 2],
    /// The encoder's index: channel 3 of TIM3, pulled up; it counts by its rising edge.
    pub index: Pin,
    /// PWM: channel 1 of TIM1.
    pub pwm: Pin,
    /// Direction, high is positive: the complementary output of channel 2 of TIM1.
    pub direction: Pin,
    /// Enable, high is on.
    pub enable: Pin,
    /// The amplifier's fault line: break input of TIM1, pulled up, low is healthy.
    pub fault: Pin,
    /// The limit switch of the lower end, pulled up, low is healthy.
    pub low_switch: Pin,
    /// The limit switch of the upper end, pulled up, low is healthy.
    pub high_switch: Pin,
    /// The home switch, pulled up, low is at home.
    pub home_switch: Pin,
    /// Step and direction: channels 1 and 2 of TIM4, pulled up. A step is a rising edge.
    pub step: [Pin; 2],
    /// The command of ±10 V: channel 1 of ADC1, which is PA1.
    pub analogue: Pin,
    /// Serial line, transmit and receive: USART2.
    pub serial: [Pin; 2],
    /// The sectors that keep records.
    pub records: Sectors,
}
