//! The detector of the supply's voltage, and the reset below the voltage that is needed (RM0440, PWR and FLASH).

use super::G4;
use super::registers::{exti, flash, pwr, rcc};
use crate::family::{Bus, Supply};
use crate::registers::exti::PVD;

/// Switches the clock of the power control on.
pub(super) fn power(bus: impl Bus<Family = G4>) {
    bus.modify(rcc::APB1ENR1, 0, rcc::APB1_PWR);
    // A peripheral answers two ticks after its clock is on (RM0440, RCC): a read takes them.
    let _ = bus.read(rcc::APB1ENR1);
}

impl Supply for G4 {
    /// The chip itself needs 1.71 V; amplifier, encoder and
    /// the threshold of the current are those of 3.3 V.
    fn watch_supply(bus: impl Bus<Family = Self>) {
        power(bus);
        // The detector's output rises when the voltage falls (RM0440, PWR).
        bus.modify(exti::RTSR1, 0, PVD);
        bus.modify(pwr::CR2, pwr::CR2_PLS, pwr::CR2_PLS_6 | pwr::CR2_PVDE);
        bus.modify(exti::IMR1, 0, PVD);
    }

    fn supply_is_low(bus: impl Bus<Family = Self>) -> bool {
        bus.read(pwr::SR2) & pwr::SR2_PVDO != 0
    }

    /// True if the option bytes make the chip reset itself below its minimum supply, 1.71 V. Level 0 does so below 1.6
    /// to 1.7 V only, level 1 below 2.0 V (STM32G474 data sheet). There are five levels (RM0440, FLASH).
    fn resets_in_time(bus: impl Bus<Family = Self>) -> bool {
        let level = bus.read(flash::OPTR) >> flash::OPTR_BOR_LEV & 0b111;
        (1..=4).contains(&level)
    }
}
