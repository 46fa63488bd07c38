//! Constants of the family for the shared tests and parts of the model.

pub(crate) use stm32g4::stm32g474::{gpioc as port, tim2 as tim5};

use drive_chip::board::Oscillator;
use drive_chip::g4::OverCurrent;
use drive_chip::pins::{Pin, Port};

use crate::Family;
use crate::model::{Chip, Mode, Source};
use crate::pac::Interrupt;
use crate::pac::tim1::smcr;

/// The board's crystal of 24 MHz, and the same at the chip.
pub(crate) const OSCILLATOR: Oscillator<Family> = Oscillator::crystal(24_000_000);
pub(crate) const SOURCE: Source = Source::Crystal(24e6);
pub(crate) const CLOCK: Oscillator<Family> = Oscillator::clock(24_000_000);
/// Oscillators of which the PLL makes the processor's clock, MHz, and others, Hz.
pub(crate) const MEGAHERTZ: [u32; 12] = [4, 8, 12, 16, 20, 24, 28, 32, 36, 40, 44, 48];
pub(crate) const NO_OSCILLATORS: [u32; 3] = [2_000_000, 6_000_000, 52_000_000];
/// That clock, Hz, and its wait states.
pub(crate) const PROCESSOR: f64 = 170e6;
pub(crate) const WAIT_STATES: u8 = 4;
/// The parts that only boards of this family have.
pub(crate) const OWN: OverCurrent = OverCurrent::above(Pin::new(Port::A, 0), 2_500);

/// The function of TIM1's pins (data sheet).
pub(crate) const TIM1_FUNCTION: u8 = 6;
/// Port A; the next ones follow.
pub(crate) const PORTS: u32 = 0x4800_0000;
/// MODER and PUPDR of the ports: the debugger's pins, and all others analogue (RM0440, GPIO).
pub(crate) const PORTS_AFTER_RESET: [(u32, u32); 3] = [
    (0xabff_ffff, 0x6400_0000),
    (0xffff_febf, 0x100),
    (0xffff_ffff, 0),
];
/// A pin that nothing uses.
pub(crate) const UNUSED: Mode = Mode::Analog;

/// Steps of a PWM period.
pub(crate) const STEPS: u16 = 8500;
/// Flags of the breaks in TIM1's status: by the pin or the comparator, and by the chip.
pub(crate) const BREAKS: u16 = 1 << 7 | 1 << 13;
/// The filter of the encoder's lines, s.
pub(crate) const ENCODER_FILTER: f64 = 48.0 / 170e6;
/// The interrupt of the supply's detector.
pub(crate) const PVD: Interrupt = Interrupt::PVD_PVM;
/// Pages of 2 KiB.
pub(crate) const PAGES_OF_AREAS_2_AND_3: &[u8] = &[
    16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31,
];
/// Bytes that the flash writes at once.
pub(crate) const WORD: usize = 8;
/// Bits of the errors in its status: RM0440, FLASH.
pub(crate) const FLASH_ERRORS: &[u32] = &[1, 3, 4, 5, 6, 7, 8, 9, 14, 15];
/// Its status with every flag.
pub(crate) const FLASH_FLAGS: u32 = 0xc3fb;

/// TIM5 among the triggers of TIM1 (TIM1).
pub(crate) const TIM5_TRIGGER: u8 = 4 + 0b100;

/// Has every factor and prescaler as large as its field.
pub(crate) fn use_every_field(chip: &Chip) {
    let rcc = &chip.clocks.rcc;
    rcc.set(rcc.pllcfgr(), 0xffff_fffc);
    rcc.set(rcc.cfgr(), rcc.get(rcc.cfgr()) | 0x3ff0);
}

/// The slave mode of TIM1 and its trigger.
pub(crate) fn synchronisation(register: &smcr::R) -> (u8, u8) {
    let mode = register.sms().bits() | u8::from(register.sms_3().bit()) << 3;
    (mode, register.ts().bits() | register.ts2().bits() << 3)
}
