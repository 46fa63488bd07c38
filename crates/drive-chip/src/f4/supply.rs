//! The detector of the supply's voltage, and the reset below the voltage that is needed (RM0090, 5 and 3.6.1).

use super::Stm32F4;
use super::registers::{exti, flash, pwr, rcc};
use crate::family::{Bus, Supply};
use crate::registers::exti::PVD;

impl<const MEGAHERTZ: u32> Supply for Stm32F4<MEGAHERTZ> {
    /// At 168 MHz, and for words written to the flash, the
    /// chip needs 2.7 V (RM0090, 3.5.1 and table 7).
    fn watch_supply(bus: impl Bus<Family = Self>) {
        bus.modify(rcc::APB1ENR, 0, rcc::APB1_PWR);
        // A peripheral answers two ticks after its clock is on (RM0090, 7.2.13): a read takes them.
        let _ = bus.read(rcc::APB1ENR);
        // The detector's output rises when the voltage falls (RM0090, 5.2.3).
        bus.modify(exti::RTSR, 0, PVD);
        bus.modify(pwr::CR, 0, pwr::CR_PLS | pwr::CR_PVDE);
        bus.modify(exti::IMR, 0, PVD);
    }

    fn supply_is_low(bus: impl Bus<Family = Self>) -> bool {
        bus.read(pwr::CSR) & pwr::CSR_PVDO != 0
    }

    /// True if the option bytes have the chip reset itself below the voltage that it needs (RM0090, 3.6.1 and 5.2.2).
    fn resets_in_time(bus: impl Bus<Family = Self>) -> bool {
        bus.read(flash::OPTCR) & flash::OPTCR_BOR_LEV == 0
    }
}
