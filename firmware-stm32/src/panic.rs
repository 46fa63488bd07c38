//! What happens when something cannot go on. In a release nothing may: the handler then calls a
//! function that does not exist, so a panic that survived optimisation is an error of the linker.

#[cfg(all(target_os = "none", not(debug_assertions)))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        fn a_panic_survived_in_this_release() -> !;
    }
    // SAFETY: it is never linked: see above.
    unsafe { a_panic_survived_in_this_release() }
}

#[cfg(all(target_os = "none", debug_assertions))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    crate::host::say(&["panic"]);
    crate::host::exit(false)
}
