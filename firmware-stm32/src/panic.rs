//! The handler of panics. A release must have none: its handler calls a function that does not exist, so a
//! panic that survived optimisation is an error of the linker. That takes the settings of the firmware's
//! folder, which optimise a program as one whole; a release that is built elsewhere stops at the panic, and
//! the watchdog resets the chip. A build with defmt, whose logger can panic, is for the bench and shows the
//! panic over the probe.

/// True if the program is optimised as one whole, by `.cargo/config.toml` of the firmware's folder.
#[cfg(all(target_os = "none", not(debug_assertions), not(feature = "defmt")))]
const IS_ONE_WHOLE: bool = option_env!("FIRMWARE_IS_ONE_WHOLE").is_some();

#[cfg(all(target_os = "none", not(debug_assertions), not(feature = "defmt")))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        fn a_panic_survived_in_this_release() -> !;
    }
    if !IS_ONE_WHOLE {
        cortex_m::interrupt::disable();
        loop {
            cortex_m::asm::nop();
        }
    }
    // SAFETY: it is never linked: see above.
    unsafe { a_panic_survived_in_this_release() }
}

#[cfg(feature = "defmt")]
use panic_probe as _;

#[cfg(all(feature = "defmt", not(feature = "emulator")))]
use defmt_rtt as _;
#[cfg(all(feature = "defmt", feature = "emulator"))]
use defmt_semihosting as _;

#[cfg(all(target_os = "none", debug_assertions, not(feature = "defmt")))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    crate::host::print(&["panic"]);
    crate::host::exit(false)
}
