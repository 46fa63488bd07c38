//! Breaks of the PWM without the processor besides the fault line. COMP3 compares a voltage of the current with a
//! threshold by DAC3. The others are the supply's detector and a lock-up of the processor (RM0440, SYSCFG, DAC, COMP
//! and TIM1).

use super::G4;
use super::registers::{comp, dac, syscfg, tim1};
use crate::family::{Bus, Family};
use crate::pins::Pin;

/// The reference of the DAC, mV.
const REFERENCE: u32 = 3_300;

/// Reads until DAC and comparator are settled, 20 µs at 170 MHz (data sheet).
const SETTLED_READS: u32 = 4_000;

/// The limit of the current that disables the output in hardware.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OverCurrent {
    sense: Pin,
    code: u32,
}

impl OverCurrent {
    /// A pin whose voltage rises with the magnitude of the current. Above the threshold, mV of 3300, the output is
    /// disabled. The pin is the positive input of COMP3 (PA0).
    ///
    /// # Panics
    /// Zero, or 3300 and more; in a constant it does not compile.
    #[must_use]
    pub const fn above(sense: Pin, millivolts: u32) -> Self {
        assert!(
            0 < millivolts && millivolts < REFERENCE,
            "the threshold must be within 0 and 3300 mV"
        );
        Self {
            sense,
            code: millivolts * 4096 / REFERENCE,
        }
    }

    /// Has hardware watch the current, the supply and the processor.
    pub(super) fn watch(self, bus: impl Bus<Family = G4>) {
        self.sense.power(bus);
        self.sense.analogue(bus);
        // The mode is written while it is disabled (RM0440, DAC).
        bus.write(dac::CR, 0);
        bus.write(dac::MCR, dac::MCR_MODE1_INTERNAL | dac::MCR_HFSEL_160);
        bus.write(dac::DHR12R1, self.code);
        bus.write(dac::CR, dac::CR_EN1);
        bus.write(comp::C3CSR, comp::INMSEL_DAC3_CH1 | comp::EN);
        for _ in 0..SETTLED_READS {
            let _ = bus.read(comp::C3CSR);
        }
        // High breaks, as on the fault line, and asynchronously: there is no filter.
        bus.modify(G4::TIM1.at(tim1::AF1), 0, tim1::AF1_BKCMP3E);
        let breaks = syscfg::CFGR2_CLL | syscfg::CFGR2_PVDL;
        bus.modify(syscfg::CFGR2, 0, breaks);
    }
}
