//! The bus to a chip, and the boundary between the drivers and its family.
//!
//! The drivers are written once, for peripherals that the families share. A [`Family`] has the differences: an address
//! for a register that lies elsewhere, a field with another meaning, a function for another procedure. Each is a
//! folder: `f4`, `g4`.

use core::fmt::Debug;

use crate::bus::{Damage, Register, Step};
use crate::frequencies::{Clocks, Kind};
use crate::registers::timer::Timer;

/// Carries words to registers and back, in the order in which they are given.
pub trait Bus: Copy {
    /// The family of its chip.
    type Family: Family;

    /// Reads a word.
    fn read(self, register: Register) -> u32;

    /// Writes a word.
    fn write(self, register: Register, word: u32);

    /// Clears some bits of a word and then sets some.
    #[inline(always)]
    fn modify(self, register: Register, clear: u32, set: u32) {
        self.write(register, self.read(register) & !clear | set);
    }

    /// The word in which [`Bus::read_pin`] and [`Bus::write_pin`] find a pin, from the IDR or BSRR of its port. It is
    /// looked up once and costs a sample nothing.
    #[inline(always)]
    fn pin_word(self, register: Register, _pin: u32) -> Register {
        register
    }

    /// Reads a pin's word.
    #[inline(always)]
    fn read_pin(self, word: Register) -> u32 {
        self.read(word)
    }

    /// Writes a pin's word.
    #[inline(always)]
    fn write_pin(self, word: Register, levels: u32) {
        self.write(word, levels);
    }

    /// Has every interrupt that is pending be served before what follows.
    fn take_interrupts(self);

    /// Does something without any interrupt.
    fn without_interrupts<R>(self, work: impl FnOnce() -> R) -> R;

    /// The damage found by the interrupt that nothing masks.
    #[inline]
    fn damage(self) -> &'static Damage {
        static NONE: Damage = Damage::new();
        &NONE
    }

    /// Does a [`Step`], by code that is not fetched from the flash, and returns the status at its end.
    #[inline(always)]
    fn do_step(self, step: Step) -> u32 {
        do_step(self, step)
    }
}

/// Does a step and returns the status at its end.
#[inline(always)]
pub(crate) fn do_step(bus: impl Bus, step: Step) -> u32 {
    let write = |(register, word)| bus.write(register, word);
    write(step.start);
    let mut reads_left = Step::MAX_READS;
    loop {
        write(step.meanwhile);
        let status = bus.read(step.status);
        if status & step.busy == 0 || reads_left == 0 {
            return status;
        }
        reads_left -= 1;
    }
}

/// Reads until a crystal, a PLL or a switch must be ready, some 30 ms at 16 MHz.
const MAX_READS: u32 = 100_000;

/// Waits until some bits of a register are as wanted.
pub(crate) fn becomes(bus: impl Bus, register: Register, bits: u32, wanted: u32) -> Option<()> {
    (0..MAX_READS)
        .any(|_| bus.read(register) & bits == wanted)
        .then_some(())
}

/// A family of chips.
pub trait Family:
    ClockTree + Peripherals + Supply + Receiver + Storage + Copy + Debug + Eq + 'static
{
    /// The parts that only boards of this family have.
    type Own: Copy + Debug + Eq;

    /// Port A; the next ports follow.
    const PORTS: u32;
    /// The register that switches the clocks of the ports, A by its lowest bit.
    const PORT_CLOCKS: Register;
    /// Functions of the peripherals' pins.
    const FUNCTIONS: Functions;

    /// The timer of the PWM.
    const TIM1: Timer;
    /// Has TIM1 triggered by TIM5, in its register SMCR.
    const TIM1_BY_TIM5: u32;
    /// Flags of the breaks in TIM1's status.
    const BREAKS: u32;
    /// Filter of the encoder's lines.
    const ENCODER_FILTER: InputFilter;
    /// Filter of the lines for step and direction.
    const STEP_FILTER: InputFilter;

    /// Masks of the external interrupts.
    const EVENT_MASKS: Register;
    /// Requests of the external interrupts.
    const EVENTS: Register;

    /// Sets up the parts that only boards of this family have.
    fn wire(bus: impl Bus<Family = Self>, own: &Self::Own);
}

/// The clocks of a family.
pub trait ClockTree {
    /// Frequencies from the board's oscillator.
    const CLOCKS: Clocks;
    /// Frequency that the PLL divides the oscillator's to, Hz; the oscillator's is a multiple of it.
    const PLL_INPUT: u32;
    /// The oscillator's lowest and highest frequency, Hz.
    const OSCILLATOR: [u32; 2];

    /// Everything from the internal oscillator, which is on after reset and stays so.
    fn reset_clock(bus: impl Bus<Family = Self>);

    /// The frequencies of [`ClockTree::CLOCKS`] from an oscillator of a frequency, Hz; none if a step does not become
    /// ready.
    fn start_clock(bus: impl Bus<Family = Self>, frequency: u32, kind: Kind) -> Option<()>;
}

/// Resets and power of a family's peripherals.
pub trait Peripherals {
    /// True if the watchdog reset the chip; only once.
    fn was_reset_by_watchdog(bus: impl Bus<Family = Self>) -> bool;

    /// Switches the peripherals' clocks on and puts them in the state after reset. They are not in it if a debugger
    /// restarted the program.
    fn power_peripherals(bus: impl Bus<Family = Self>);

    /// Keeps the watchdog and the PWM running while a debugger halts the processor, for any earlier setting of the
    /// debugger. A stopped PWM may stop at high. A running watchdog resets the chip, which disables the output.
    fn run_while_halted(bus: impl Bus<Family = Self>);
}

/// The supply of a family.
pub trait Supply {
    /// Has the detector watch the supply at its highest threshold, about 2.9 V, and interrupt.
    fn watch_supply(bus: impl Bus<Family = Self>);

    /// True if the supply is below the threshold now.
    fn supply_is_low(bus: impl Bus<Family = Self>) -> bool;

    /// True if the option bytes have the chip reset itself below the voltage that it needs.
    fn resets_in_time(bus: impl Bus<Family = Self>) -> bool;
}

/// USART2 and its reception by DMA.
pub trait Receiver {
    /// USART2.
    const USART: Usart;
    /// The DMA of its reception.
    const RECEPTION: Reception;

    /// Writes every byte that USART2 receives to memory, from a place on, bytewise in a ring, before any other
    /// transfer.
    fn receive_into(bus: impl Bus<Family = Self>, place: u32, length: u32);

    /// Clears the errors of the reception, once the status was read.
    fn clear_reception_errors(bus: impl Bus<Family = Self>);
}

/// The flash of a family.
pub trait Storage {
    /// The flash's interface.
    const FLASH: Flash;
    /// Bytes that the flash writes at once.
    const WRITE_SIZE: usize;
    /// The flash recognises words that a loss of power has damaged, by an interrupt that nothing masks.
    const RECOGNISES_DAMAGE: bool;

    /// Erases an area of the flash, which is unlocked, by steps of a word at a register.
    ///
    /// # Errors
    /// Those of a step.
    fn erase<E>(
        bus: impl Bus<Family = Self>,
        area: u32,
        step: impl FnMut(Register, u32) -> Result<(), E>,
    ) -> Result<(), E>;

    /// Writes whole units to the unlocked flash from a place on. Each step is a word at a place, and another word may
    /// precede it.
    ///
    /// # Errors
    /// Those of a step.
    fn program<E>(
        bus: impl Bus<Family = Self>,
        place: Register,
        bytes: &[u8],
        step: impl FnMut(Option<(Register, u32)>, (Register, u32)) -> Result<(), E>,
    ) -> Result<(), E>;

    /// Serves the interrupt that nothing masks: true if the program may continue.
    fn outlives_nmi(bus: impl Bus<Family = Self>) -> bool;
}

/// Functions of the peripherals' pins, by their numbers.
#[derive(Debug, Clone, Copy)]
pub struct Functions {
    pub(crate) tim1: u32,
    pub(crate) tim3: u32,
    pub(crate) tim4: u32,
    pub(crate) usart2: u32,
}

/// A digital filter of a timer's input: a level counts once it has stood for some ticks of the timer.
#[derive(Debug, Clone, Copy)]
pub struct InputFilter {
    pub(crate) bits: u32,
    pub(crate) ticks: u32,
}

impl InputFilter {
    /// Six samples at half of the timer's clock (RM0090, 18.4.7; RM0440, TIM2 to TIM5).
    pub(crate) const TICKS_12: Self = Self::new(0b0100, 12);
    /// Six samples at a quarter.
    pub(crate) const TICKS_24: Self = Self::new(0b0110, 24);
    /// Six samples at an eighth.
    pub(crate) const TICKS_48: Self = Self::new(0b1000, 48);

    const fn new(bits: u32, ticks: u32) -> Self {
        Self { bits, ticks }
    }
}

/// Registers of a USART.
#[derive(Debug, Clone, Copy)]
pub struct Usart {
    pub(crate) status: Register,
    pub(crate) transmit: Register,
    pub(crate) divider: Register,
    pub(crate) control_1: Register,
    pub(crate) control_3: Register,
    /// Enables it, in its first control register.
    pub(crate) enable: u32,
}

/// Registers and flags of the DMA that serves the reception.
#[derive(Debug, Clone, Copy)]
pub struct Reception {
    pub(crate) flags: Register,
    /// Ones clear.
    pub(crate) clear: Register,
    /// Bytes that are left until the place is the first one again.
    pub(crate) left: Register,
    /// Half of the memory was passed, and its end.
    pub(crate) round: u32,
    /// An error has disabled it.
    pub(crate) failed: u32,
    /// All of its flags.
    pub(crate) all: u32,
}

/// Registers of the flash's interface.
#[derive(Debug, Clone, Copy)]
pub struct Flash {
    pub(crate) access: Register,
    pub(crate) keys: Register,
    pub(crate) status: Register,
    pub(crate) control: Register,
    /// Errors in the status.
    pub(crate) errors: u32,
    /// The same, and the end of an operation; ones clear.
    pub(crate) ended: u32,
}
