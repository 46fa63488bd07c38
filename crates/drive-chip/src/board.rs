//! What differs from board to board.

use crate::flash::Sectors;
use crate::pins::Pin;

/// Where the chip's frequency comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Oscillator {
    pub(crate) frequency: u32,
    pub(crate) kind: Kind,
}

/// What is at the pins OSC_IN and OSC_OUT.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Crystal,
    Clock,
}

impl Oscillator {
    /// The PLL's input, Hz: of the 1 to 2 MHz that it takes the one at which its jitter is least
    /// (RM0090, 7.3.2).
    pub(crate) const PLL_INPUT: u32 = 2_000_000;

    /// A crystal between OSC_IN and OSC_OUT, Hz.
    ///
    /// # Panics
    /// A multiple of 2 MHz from 4 to 26 MHz; made as a constant, anything else does not compile.
    #[must_use]
    pub const fn crystal(frequency: u32) -> Self {
        Self::new(frequency, Kind::Crystal)
    }

    /// Somebody else's clock at OSC_IN, Hz.
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

/// A board: its oscillator, which pin is what, and which sectors of the flash keep its records.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Board {
    /// Where the chip's frequency comes from.
    pub oscillator: Oscillator,
    /// Encoder A and B: channels 1 and 2 of TIM3, pulled up.
    pub encoder: [Pin; 2],
    /// PWM: channel 1 of TIM1.
    pub pwm: Pin,
    /// Direction, high is positive.
    pub direction: Pin,
    /// Enable, high is on.
    pub enable: Pin,
    /// The amplifier's fault line: break input of TIM1, pulled up, low is healthy.
    pub fault: Pin,
    /// The limit switch of the lower end, pulled up, low is healthy.
    pub low_switch: Pin,
    /// The limit switch of the upper end, pulled up, low is healthy.
    pub high_switch: Pin,
    /// Serial line, out and in: USART2.
    pub serial: [Pin; 2],
    /// Where records are kept.
    pub records: Sectors,
}
