//! What happens when something cannot go on. In a release nothing may: the handler then calls a
//! function that does not exist, so a panic that survived optimisation is an error of the linker. A
//! release that is built in the project's root is one for a PC, and may have some. A build with defmt,
//! whose logger can panic, is for the bench and shows it over the probe.

#[cfg(all(target_os = "none", not(debug_assertions), not(feature = "defmt")))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        fn a_panic_survived_in_this_release() -> !;
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
    crate::host::say(&["panic"]);
    crate::host::exit(false)
}
