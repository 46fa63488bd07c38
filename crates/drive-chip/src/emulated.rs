//! Memory in place of the registers that an emulated chip lacks, and what moves them from outside.
//!
//! QEMU's STM32F405 has no pins, TIM1, watchdog and flash control, keeps RCC as plain storage, and
//! lets its encoder's timer count the clock. Those words are here; everything else is the
//! emulator's.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

use crate::bus::Register;
use crate::flash::SECTOR;
use crate::pins::Pin;
use crate::registers::timer::{self, TIM1, TIM3};
use crate::registers::{flash, gpio, rcc};

/// Words kept of each peripheral.
const WORDS: usize = 36;

/// The peripherals, by the addresses of their first registers: RCC, FLASH, the ports A to C, TIM1,
/// TIM3 and IWDG.
const PERIPHERALS: [u32; 8] = [
    0x4002_3800,
    0x4002_3c00,
    0x4002_0000,
    0x4002_0400,
    0x4002_0800,
    0x4001_0000,
    0x4000_0400,
    0x4000_3000,
];

/// Where the records are, in two shorter sectors.
const RECORDS: u32 = 0x0800_4000;
const RECORD_WORDS: usize = 2 * SECTOR as usize / 4;

static REGISTERS: [AtomicU32; PERIPHERALS.len() * WORDS] =
    [const { AtomicU32::new(0) }; PERIPHERALS.len() * WORDS];
static SECTORS: [AtomicU32; RECORD_WORDS] = [const { AtomicU32::new(u32::MAX) }; RECORD_WORDS];

/// Where a word is kept; with a constant address a constant.
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

/// False if it is none of those words.
#[inline(always)]
pub(crate) fn write(register: Register, word: u32) -> bool {
    let Some(place) = kept(register) else {
        return false;
    };
    if recorded(register).is_some() {
        place.store(place.load(Relaxed) & word, Relaxed);
    } else if register == flash::SR {
        // Ones clear.
        place.store(place.load(Relaxed) & !word, Relaxed);
    } else {
        place.store(word, Relaxed);
        if register == flash::CR && word & flash::CR_STRT != 0 {
            erase(word >> flash::CR_SNB & 1);
        }
    }
    true
}

/// Pins of a port.
const PINS: usize = 16;

/// Ports that have pins here: A to C.
const PORTS: usize = 3;

/// The levels of each port, and the last word that switched each pin: two pins of a port are switched
/// one after the other, and one word would hold only the second.
static LEVELS: [AtomicU32; PORTS] = [const { AtomicU32::new(0) }; PORTS];
static SWITCHES: [AtomicU32; PORTS * PINS] = [const { AtomicU32::new(0) }; PORTS * PINS];

/// The number of the port that a register belongs to.
fn port_of(register: Register) -> usize {
    (register.address().wrapping_sub(gpio::BASE) / gpio::STRIDE) as usize
}

/// Where the levels of a port are kept.
pub(crate) fn levels(idr: Register) -> Register {
    LEVELS.get(port_of(idr)).map_or(idr, place)
}

/// Where a pin is switched.
pub(crate) fn switch(bsrr: Register, pin: u32) -> Register {
    let number = port_of(bsrr) * PINS + pin as usize;
    SWITCHES.get(number).map_or(bsrr, place)
}

fn place(word: &'static AtomicU32) -> Register {
    Register::at(word.as_ptr() as u32)
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
    set(TIM3.cnt(), count.into());
}

/// What the drive puts out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outputs {
    /// Steps of a PWM period that the output is high for; none while it is switched off.
    pub duty: Option<u16>,
    /// Steps of a PWM period.
    pub steps: u16,
}

/// What the drive puts out now.
#[must_use]
pub fn outputs() -> Outputs {
    let on = get(TIM1.bdtr()) & timer::BDTR_MOE != 0;
    Outputs {
        duty: on.then(|| get(TIM1.ccr1()) as u16),
        steps: get(TIM1.arr()).wrapping_add(1) as u16,
    }
}

/// Whether an output was last switched high.
#[must_use]
pub fn is_high(pin: Pin) -> bool {
    let bsrr = pin.register(gpio::BSRR);
    let number = port_of(bsrr) * PINS + pin.mask().trailing_zeros() as usize;
    let switched = SWITCHES.get(number).map_or(0, |word| word.load(Relaxed));
    switched & pin.mask() != 0
}

fn get(register: Register) -> u32 {
    kept(register).map_or(0, |word| word.load(Relaxed))
}

fn set(register: Register, word: u32) {
    if let Some(place) = kept(register) {
        place.store(word, Relaxed);
    }
}
