//! The handler of panics. A release must have none. Its handler calls a function that does not exist, so a panic that
//! survived optimisation is an error of the linker. A build for the bench disables the stage first and shows the panic.

#[cfg(all(not(debug_assertions), not(feature = "defmt")))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        fn a_panic_survived_in_this_release() -> !;
    }
    // SAFETY: it is never linked: see above.
    unsafe { a_panic_survived_in_this_release() }
}

#[cfg(all(feature = "defmt", not(feature = "emulator")))]
use defmt_rtt as _;
#[cfg(all(feature = "defmt", feature = "emulator"))]
use defmt_semihosting as _;

#[cfg(feature = "defmt")]
#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    crate::board::disable_outputs();
    defmt::error!("{}", defmt::Display2Format(info));
    crate::ending::give_up()
}

#[cfg(all(debug_assertions, not(feature = "defmt")))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    crate::board::disable_outputs();
    crate::host::print(&["panic"]);
    crate::host::exit(false)
}
