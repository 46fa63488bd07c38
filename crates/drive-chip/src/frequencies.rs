//! Frequencies of the clocks, and the oscillator that they come from.

/// Clock frequencies, Hz.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Clocks {
    /// The processor.
    pub processor: u32,
    /// USART2 and its neighbours.
    pub low_bus: u32,
    /// Timers of the slow bus, TIM2 to TIM7.
    pub low_timers: u32,
    /// Timers of the fast bus, TIM1 and TIM8.
    pub high_timers: u32,
}

impl Clocks {
    /// After reset: the internal oscillator of 16 MHz for everything.
    pub const RESET: Self = Self {
        processor: 16_000_000,
        low_bus: 16_000_000,
        low_timers: 16_000_000,
        high_timers: 16_000_000,
    };
}

/// The device at the pins OSC_IN and OSC_OUT.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A crystal between them.
    Crystal,
    /// A clock at the first one.
    Clock,
}
