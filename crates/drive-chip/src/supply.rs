//! The chip's supply: a sag disables the output at once, and stays known until the output is disabled in a sample.

use crate::bus::Bus;
use crate::registers::{exti, flash, pwr, rcc};

/// Has the detector watch the supply at its highest threshold, about 2.9 V: at 168 MHz, and for words written to the
/// flash, the chip needs 2.7 V (RM0090, 3.5.1 and table 7).
pub(crate) fn watch(bus: impl Bus) {
    bus.modify(rcc::APB1ENR, 0, rcc::APB1_PWR);
    // A peripheral answers two ticks after its clock is on (RM0090, 7.2.13): a read takes them.
    let _ = bus.read(rcc::APB1ENR);
    // The detector's output rises when the voltage falls (RM0090, 5.2.3).
    bus.modify(exti::RTSR, 0, exti::PVD);
    bus.modify(pwr::CR, 0, pwr::CR_PLS | pwr::CR_PVDE);
    bus.modify(exti::IMR, 0, exti::PVD);
}

/// Has a sag interrupt no more until it is acknowledged. It stays pending, which the next sample sees.
pub(crate) fn silence(bus: impl Bus) {
    bus.modify(exti::IMR, exti::PVD, 0);
}

/// True if the supply has not sagged since it was acknowledged.
#[inline]
#[must_use]
pub(crate) fn is_healthy(bus: impl Bus) -> bool {
    bus.read(exti::PR) & exti::PVD == 0
}

/// True if the supply is below the threshold now.
pub(crate) fn is_low(bus: impl Bus) -> bool {
    bus.read(pwr::CSR) & pwr::CSR_PVDO != 0
}

/// Acknowledges a sag that is over, so that the next one shows.
#[inline]
pub(crate) fn acknowledge(bus: impl Bus) {
    if is_healthy(bus) || is_low(bus) {
        return;
    }
    // Ones clear.
    bus.write(exti::PR, exti::PVD);
    bus.modify(exti::IMR, 0, exti::PVD);
}

/// True if the option bytes have the chip reset itself below the voltage that it needs (RM0090, 3.6.1 and 5.2.2).
#[must_use]
pub(crate) fn resets_in_time(bus: impl Bus) -> bool {
    bus.read(flash::OPTCR) & flash::OPTCR_BOR_LEV == 0
}
