//! The data that differ from board to board.

use core::marker::PhantomData;

use crate::family::Family;
use crate::flash::Areas;
use crate::frequencies::Kind;
use crate::pins::{Pin, Port};

/// The source of the chip's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Oscillator<F> {
    pub(crate) frequency: u32,
    pub(crate) kind: Kind,
    family: PhantomData<F>,
}

impl<F: Family> Oscillator<F> {
    /// A crystal between OSC_IN and OSC_OUT, Hz. An STM32F4 takes a multiple of 2 MHz from 4 to 26 MHz, an STM32F401 one of
    /// 1 MHz, and an STM32G4 one of 4 MHz from 4 to 48 MHz.
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
            frequency.is_multiple_of(F::PLL_INPUT),
            "the oscillator must be a multiple of 2 MHz (STM32F4), 1 MHz (STM32F401) or 4 MHz (STM32G4)"
        );
        let [lowest, highest] = F::OSCILLATOR;
        assert!(
            lowest <= frequency && frequency <= highest,
            "the oscillator must be from 4 to 26 MHz (STM32F4) or to 48 MHz (STM32G4)"
        );
        Self {
            frequency,
            kind,
            family: PhantomData,
        }
    }
}

/// A board: its oscillator, the functions of its pins, and the areas of the flash that keep records.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Board<F: Family> {
    /// The source of the chip's clock.
    pub oscillator: Oscillator<F>,
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
    /// The holding brake, high opens it.
    pub brake: Pin,
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
    /// Serial line, transmit and receive: USART2.
    pub serial: [Pin; 2],
    /// The areas that keep records.
    pub records: Areas,
    /// The parts that only boards of its family have.
    pub own: F::Own,
}

impl<F: Family> Board<F> {
    /// With the pins of a chip with 64 pins, which both families have alike, and records in the areas 1 and 2.
    #[must_use]
    pub const fn of_64_pins(oscillator: Oscillator<F>, own: F::Own) -> Self {
        Self {
            oscillator,
            encoder: [Pin::new(Port::C, 6), Pin::new(Port::C, 7)],
            index: Pin::new(Port::C, 8),
            pwm: Pin::new(Port::A, 8),
            direction: Pin::new(Port::B, 14),
            enable: Pin::new(Port::B, 15),
            brake: Pin::new(Port::B, 13),
            fault: Pin::new(Port::B, 12),
            low_switch: Pin::new(Port::C, 0),
            high_switch: Pin::new(Port::C, 1),
            home_switch: Pin::new(Port::C, 2),
            step: [Pin::new(Port::B, 6), Pin::new(Port::B, 7)],
            serial: [Pin::new(Port::A, 2), Pin::new(Port::A, 3)],
            records: Areas::starting_at(1),
            own,
        }
    }
}
