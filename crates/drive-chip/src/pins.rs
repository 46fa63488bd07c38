//! General-purpose pins (RM0090, 8.3).

use core::convert::Infallible;

use embedded_hal::digital::{ErrorType, OutputPin};

use crate::bus::Register;
use crate::family::{Bus, Family};
use crate::registers::gpio;

/// A port of sixteen pins: those that packages of 64 pins bring out whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "its letter is its name")]
pub enum Port {
    A,
    B,
    C,
}

/// A pin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pin {
    port: Port,
    number: u32,
}

impl Pin {
    /// A pin of a port, by its number, 0 to 15.
    ///
    /// # Panics
    /// Any other number; in a constant it does not compile.
    #[must_use]
    pub const fn new(port: Port, number: u32) -> Self {
        assert!(number < 16, "a port has the pins 0 to 15");
        Self { port, number }
    }

    pub(crate) const fn register<F: Family>(self, offset: u32) -> Register {
        Register::at(F::PORTS + gpio::STRIDE * self.port as u32 + offset)
    }

    pub(crate) const fn mask(self) -> u32 {
        1 << self.number
    }

    /// Writes a field of two bits per pin.
    fn set_pair<B: Bus>(self, bus: B, offset: u32, bits: u32) {
        let shift = 2 * self.number;
        bus.modify(
            self.register::<B::Family>(offset),
            0b11 << shift,
            bits << shift,
        );
    }

    fn set_mode(self, bus: impl Bus, mode: Mode) {
        self.set_pair(bus, gpio::MODER, mode as u32);
    }

    fn set_pull(self, bus: impl Bus, pull: Pull) {
        self.set_pair(bus, gpio::PUPDR, pull as u32);
    }

    /// Switches the port's clock on.
    pub(crate) fn power<B: Bus>(self, bus: B) {
        bus.modify(B::Family::PORT_CLOCKS, 0, 1 << self.port as u32);
        // A peripheral answers two ticks after its clock is on (RM0090, 7.2.13): a read takes them.
        let _ = bus.read(B::Family::PORT_CLOCKS);
    }

    /// A push-pull output, low from the start.
    pub(crate) fn output<B: Bus>(self, bus: B) {
        self.set_low(bus);
        bus.modify(self.register::<B::Family>(gpio::OTYPER), self.mask(), 0);
        self.set_mode(bus, Mode::Output);
    }

    /// An input that is pulled up.
    pub(crate) fn input(self, bus: impl Bus) {
        self.set_pull(bus, Pull::Up);
        self.set_mode(bus, Mode::Input);
    }

    /// A pin of a converter.
    pub(crate) fn analogue(self, bus: impl Bus) {
        self.set_pull(bus, Pull::None);
        self.set_mode(bus, Mode::Analogue);
    }

    /// A pin of a peripheral, by the number of the function (RM0090, figure 26).
    pub(crate) fn alternate<B: Bus>(self, bus: B, function: u32, pull: Pull) {
        let shift = 4 * (self.number & 0b111);
        let register = self.register::<B::Family>(gpio::AFRL + 4 * (self.number >> 3));
        bus.modify(register, 0xf << shift, function << shift);
        self.set_pull(bus, pull);
        bus.modify(self.register::<B::Family>(gpio::OTYPER), self.mask(), 0);
        self.set_mode(bus, Mode::Alternate);
    }

    #[cfg(all(feature = "emulator", target_os = "none"))]
    pub(crate) const fn number(self) -> u32 {
        self.number
    }

    pub(crate) fn set_low(self, bus: impl Bus) {
        let Ok(()) = Output::new(bus, self).set_low();
    }
}

#[derive(Clone, Copy)]
enum Mode {
    Input = 0b00,
    Output = 0b01,
    Alternate = 0b10,
    Analogue = 0b11,
}

/// The level of a pin that is not driven.
#[derive(Clone, Copy)]
pub(crate) enum Pull {
    None = 0b00,
    Up = 0b01,
}

/// A pin that is an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Input<B> {
    bus: B,
    word: Register,
    mask: u32,
}

impl<B: Bus> Input<B> {
    /// A pin that was made an input, or one of a peripheral.
    pub(crate) fn new(bus: B, pin: Pin) -> Self {
        Self {
            bus,
            word: bus.pin_word(pin.register::<B::Family>(gpio::IDR), pin.number),
            mask: pin.mask(),
        }
    }

    #[inline]
    pub(crate) fn is_low(&self) -> bool {
        self.bus.read_pin(self.word) & self.mask == 0
    }
}

/// A pin that is an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Output<B> {
    bus: B,
    word: Register,
    mask: u32,
}

impl<B: Bus> Output<B> {
    /// A pin that was made an output.
    pub(crate) fn new(bus: B, pin: Pin) -> Self {
        Self {
            bus,
            // BSRR sets a level in one write, which no interrupt can split.
            word: bus.pin_word(pin.register::<B::Family>(gpio::BSRR), pin.number),
            mask: pin.mask(),
        }
    }
}

impl<B> ErrorType for Output<B> {
    type Error = Infallible;
}

impl<B: Bus> OutputPin for Output<B> {
    #[inline]
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.bus.write_pin(self.word, self.mask << 16);
        Ok(())
    }

    #[inline]
    fn set_high(&mut self) -> Result<(), Infallible> {
        self.bus.write_pin(self.word, self.mask);
        Ok(())
    }
}
