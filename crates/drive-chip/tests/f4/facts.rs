//! Constants of the family for the shared tests and parts of the model.

pub(crate) use stm32f4::stm32f405::{gpioi as port, tim5};

use drive_chip::board::Oscillator;

use crate::Family;
use crate::model::{Chip, Mode, Source};
use crate::pac::Interrupt;
use crate::pac::tim1::smcr;

/// The board's crystal of 8 MHz, and the same at the chip.
pub(crate) const OSCILLATOR: Oscillator<Family> = Oscillator::crystal(8_000_000);
pub(crate) const SOURCE: Source = Source::Crystal(8e6);
pub(crate) const CLOCK: Oscillator<Family> = Oscillator::clock(8_000_000);
/// Oscillators of which the PLL makes the processor's clock, MHz, and others, Hz.
pub(crate) const MEGAHERTZ: [u32; 12] = [4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26];
pub(crate) const NO_OSCILLATORS: [u32; 3] = [2_000_000, 5_000_000, 28_000_000];
/// That clock, Hz, and its wait states.
pub(crate) const PROCESSOR: f64 = 168e6;
pub(crate) const WAIT_STATES: u8 = 5;
/// The parts that only boards of this family have.
pub(crate) const OWN: () = ();

/// The function of TIM1's pins (data sheet, table 9).
pub(crate) const TIM1_FUNCTION: u8 = 1;
/// Port A; the next ones follow.
pub(crate) const PORTS: u32 = 0x4002_0000;
/// MODER and PUPDR of the ports: the debugger's pins (8.4.1 and 8.4.4).
pub(crate) const PORTS_AFTER_RESET: [(u32, u32); 3] =
    [(0xa800_0000, 0x6400_0000), (0x280, 0x100), (0, 0)];
/// A pin that nothing uses.
pub(crate) const UNUSED: Mode = Mode::Input;

/// Steps of a PWM period.
pub(crate) const STEPS: u16 = 8400;
/// Flags of the breaks in TIM1's status.
pub(crate) const BREAKS: u16 = 1 << 7;
/// The filter of the encoder's lines, s.
pub(crate) const ENCODER_FILTER: f64 = 24.0 / 84e6;
/// The interrupt of the supply's detector.
pub(crate) const PVD: Interrupt = Interrupt::PVD;
/// Sectors.
pub(crate) const PAGES_OF_AREAS_2_AND_3: &[u8] = &[2, 3];
/// Bytes that the flash writes at once.
pub(crate) const WORD: usize = 4;
/// Bits of the errors in its status: protected, misaligned, wrong width, wrong order, and any other.
pub(crate) const FLASH_ERRORS: &[u32] = &[1, 4, 5, 6, 7, 8];
/// Its status with every flag.
pub(crate) const FLASH_FLAGS: u32 = 0xf2;

/// TIM5 among the triggers of TIM1 (table 94).
pub(crate) const TIM5_TRIGGER: u8 = 0;

/// Has every factor, prescaler and wait state as large as its field.
pub(crate) fn use_every_field(chip: &Chip) {
    let (rcc, flash) = (&chip.clocks.rcc, &chip.memory.flash);
    rcc.set(rcc.pllcfgr(), rcc.get(rcc.pllcfgr()) | 0x0f43_7fff);
    rcc.set(rcc.cfgr(), rcc.get(rcc.cfgr()) | 0xfcf0);
    flash.set(flash.acr(), 0b111);
}

/// The slave mode of TIM1 and its trigger.
pub(crate) fn synchronisation(register: &smcr::R) -> (u8, u8) {
    (register.sms().bits(), register.ts().bits())
}
