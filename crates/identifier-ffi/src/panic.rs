//! The end of a panic: a symbol that nothing defines, so that a library with a panic in it cannot be linked.

use core::panic::PanicInfo;

unsafe extern "C" {
    fn servo_id_a_panic_survived() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: it is never linked.
    unsafe { servo_id_a_panic_survived() }
}
