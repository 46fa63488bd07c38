//! The handler of panics. A release must have none: its handler calls a function that does not exist, so a
//! panic that survived optimisation is an error of the linker. That takes the settings of the firmware's
//! folder, which optimise a program as one whole. A release that is built elsewhere, and a build for the bench, disable
//! the stage first; the first stops then, and the watchdog resets the chip; the others show the panic.

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
        crate::ending::give_up();
    }
    // SAFETY: it is never linked: see above.
    unsafe { a_panic_survived_in_this_release() }
}

#[cfg(all(feature = "defmt", not(feature = "emulator")))]
use defmt_rtt as _;
#[cfg(all(feature = "defmt", feature = "emulator"))]
use defmt_semihosting as _;

#[cfg(all(target_os = "none", feature = "defmt"))]
#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    crate::board::disable_outputs();
    defmt::error!("{}", defmt::Display2Format(info));
    crate::ending::give_up()
}

#[cfg(all(target_os = "none", debug_assertions, not(feature = "defmt")))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    crate::board::disable_outputs();
    crate::host::print(&["panic"]);
    crate::host::exit(false)
}
