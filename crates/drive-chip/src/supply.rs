//! The chip's supply. A sag disables the output at once and is remembered until the output is disabled in a sample.

use crate::family::{Bus, Family, Supply};
use crate::registers::exti;

/// Has a sag interrupt no more until it is acknowledged. It stays pending, which the next sample sees.
pub(crate) fn silence<B: Bus>(bus: B) {
    bus.modify(B::Family::EVENT_MASKS, exti::PVD, 0);
}

/// True if the supply has not sagged since it was acknowledged.
#[inline]
pub(crate) fn is_healthy<B: Bus>(bus: B) -> bool {
    bus.read(B::Family::EVENTS) & exti::PVD == 0
}

/// True while the supply is too low for the flash, or has been since it was acknowledged.
pub(crate) fn has_sagged<B: Bus>(bus: B) -> bool {
    !is_healthy(bus) || B::Family::supply_is_low(bus)
}

/// Acknowledges a sag that is over, so that the next one shows.
#[inline]
pub(crate) fn acknowledge<B: Bus>(bus: B) {
    if is_healthy(bus) || B::Family::supply_is_low(bus) {
        return;
    }
    // Ones clear.
    bus.write(B::Family::EVENTS, exti::PVD);
    bus.modify(B::Family::EVENT_MASKS, 0, exti::PVD);
}
