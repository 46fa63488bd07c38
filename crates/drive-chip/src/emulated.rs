//! Memory for the registers that an emulated chip lacks, and access to them from outside.
//!
//! QEMU's STM32F405 has no pins, TIM1, watchdog, DMA and flash control. It keeps RCC as plain storage, and its timers
//! of the encoder and of the steps count the clock. Memory replaces those; everything else is the emulator's.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

use crate::bus::Register;
use crate::f4::F4;
use crate::f4::registers::{dma, flash, rcc};
use crate::family::Family;
use crate::pins::Pin;
use crate::registers::flash::{AREA, CR_STRT};
use crate::registers::gpio;
use crate::registers::timer::{self, TIM3, TIM5};

const TIM1: timer::Timer = F4::TIM1;

/// Words of each peripheral.
const WORDS: usize = 40;

/// The peripherals by the addresses of their first registers: RCC, FLASH, DMA1, PWR, DBGMCU, the ports A to C, TIM3,
/// TIM4, IWDG.
const PERIPHERALS: [u32; 11] = [
    0x4002_3800,
    0x4002_3c00,
    0x4002_6000,
    0x4000_7000,
    0xe004_2000,
    0x4002_0000,
    0x4002_0400,
    0x4002_0800,
    0x4000_0400,
    0x4000_0800,
    0x4000_3000,
];

/// The two sectors of records, shortened.
const RECORDS: u32 = 0x0800_4000;
const RECORD_WORDS: usize = 2 * AREA as usize / 4;

static REGISTERS: [AtomicU32; PERIPHERALS.len() * WORDS] =
    [const { AtomicU32::new(0) }; PERIPHERALS.len() * WORDS];
/// TIM1. A meter of the emulator watches its words by this name.
static TIM1_REGISTERS: [AtomicU32; WORDS] = [const { AtomicU32::new(0) }; WORDS];
static SECTORS: [AtomicU32; RECORD_WORDS] = [const { AtomicU32::new(u32::MAX) }; RECORD_WORDS];

/// The memory of a word; of a constant address a constant.
#[inline(always)]
fn kept(register: Register) -> Option<&'static AtomicU32> {
    let mut number = 0;
    while number < PERIPHERALS.len() {
        let word = register.address().wrapping_sub(PERIPHERALS[number]) / 4;
        if (word as usize) < WORDS {
            return REGISTERS.get(number * WORDS + word as usize);
        }
        number += 1;
    }
    let word = register.address().wrapping_sub(TIM1.at(0).address()) / 4;
    if (word as usize) < WORDS {
        return TIM1_REGISTERS.get(word as usize);
    }
    recorded(register)
}

#[inline(always)]
fn recorded(register: Register) -> Option<&'static AtomicU32> {
    SECTORS.get((register.address().wrapping_sub(RECORDS) / 4) as usize)
}

#[inline(always)]
pub(crate) fn read(register: Register) -> Option<u32> {
    let word = kept(register)?.load(Relaxed);
    Some(if register == rcc::CR {
        // Everything is ready at once.
        word | rcc::CR_HSERDY | rcc::CR_PLLRDY
    } else if register == rcc::CFGR {
        word & !rcc::CFGR_SWS | (word & rcc::CFGR_SW) << 2
    } else {
        word
    })
}

/// False for a word of the emulator's own.
#[inline(always)]
pub(crate) fn write(register: Register, word: u32) -> bool {
    if register == TIM5.at(timer::EGR) {
        // QEMU 10 adds the time at which a timer was set to zero to each of its periods (`stm32f2xx_timer.c`): samples
        // came later after a longer boot or run. Writing the period starts the timer anew.
        return true;
    }
    let Some(place) = kept(register) else {
        return false;
    };
    if recorded(register).is_some() {
        place.store(place.load(Relaxed) & word, Relaxed);
    } else if register == flash::SR {
        // Ones clear.
        place.store(place.load(Relaxed) & !word, Relaxed);
    } else if register == dma::HIFCR {
        set(dma::HISR, get(dma::HISR) & !word);
    } else {
        place.store(word, Relaxed);
        if register == flash::CR && word & CR_STRT != 0 {
            erase(word >> flash::CR_SNB & 1);
        }
    }
    true
}

/// Ticks of TIM5 that an emulated sample has at least. A tick is an instruction, and the emulated servo takes some
/// thousand between two samples. A processor needs two cycles for each.
const MIN_SAMPLE_TICKS: u32 = 40_000;

/// A word for a register of the emulator's own. The period of the samples is multiplied by a whole number, so that a
/// sample has time for everything.
#[inline(always)]
pub(crate) fn stretched(register: Register, word: u32) -> u32 {
    if register != TIM5.at(timer::ARR) {
        return word;
    }
    let ticks = word.saturating_add(1);
    let factor = MIN_SAMPLE_TICKS.div_ceil(ticks);
    ticks.saturating_mul(factor) - 1
}

/// Pins of a port, and ports that have pins here: A to C.
const PINS: usize = 16;
const PORTS: usize = 3;

/// The last word that switched each pin. Two pins of a port are switched one after the other, and one word would hold
/// only the second. Nothing switches an input: its word reads as low.
static PIN_WORDS: [AtomicU32; PORTS * PINS] = [const { AtomicU32::new(0) }; PORTS * PINS];

/// The word of a pin, by any register of its port.
fn pin(register: Register, number: u32) -> Option<&'static AtomicU32> {
    let port = register.address().wrapping_sub(F4::PORTS) / gpio::STRIDE;
    PIN_WORDS.get(port as usize * PINS + number as usize)
}

/// The register that represents a pin's IDR or BSRR.
pub(crate) fn pin_word(register: Register, number: u32) -> Register {
    pin(register, number).map_or(register, |word| Register::at(word.as_ptr() as u32))
}

#[inline(never)]
fn erase(sector: u32) {
    let (first, second) = SECTORS.split_at(RECORD_WORDS / 2);
    for word in if sector == 0 { first } else { second } {
        word.store(u32::MAX, Relaxed);
    }
}

/// Sets the encoder's counter.
pub fn set_count(count: u16) {
    set(TIM3.at(timer::CNT), count.into());
}

/// The drive's output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outputs {
    /// Steps of a PWM period with a high output; none if it is off.
    pub duty: Option<u16>,
    /// True if its direction is positive.
    pub is_positive: bool,
    /// Steps of a PWM period.
    pub steps: u16,
}

/// The drive's output now.
#[must_use]
pub fn outputs() -> Outputs {
    let on = get(TIM1.at(timer::BDTR)) & timer::BDTR_MOE != 0;
    Outputs {
        duty: on.then(|| get(TIM1.at(timer::CCR1)) as u16),
        is_positive: get(TIM1.at(timer::CCR2)) != 0,
        steps: get(TIM1.at(timer::ARR)).wrapping_add(1) as u16,
    }
}

/// True while an output is high.
#[must_use]
pub fn is_high(pin: Pin) -> bool {
    let register = pin.register::<F4>(gpio::BSRR);
    let word = self::pin(register, pin.number()).map_or(0, |word| word.load(Relaxed));
    word & pin.mask() != 0
}

pub(crate) fn get(register: Register) -> u32 {
    kept(register).map_or(0, |word| word.load(Relaxed))
}

pub(crate) fn set(register: Register, word: u32) {
    if let Some(place) = kept(register) {
        place.store(word, Relaxed);
    }
}
