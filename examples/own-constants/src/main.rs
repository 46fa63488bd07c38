//! A firmware whose loop its build script has certified and built on the PC: it links the samples alone, without
//! certificate, settings and double precision.
//!
//! ```sh
//! cargo build --release --target thumbv7em-none-eabihf
//! ```
//!
//! The counter of an encoder and the compare register of a PWM are those of an STM32.
#![no_std]
#![no_main]

#[cfg(feature = "compare")]
mod compare;
#[cfg(any(feature = "compare", not(feature = "empty")))]
mod run;
#[cfg(any(feature = "compare", not(feature = "empty")))]
#[cfg_attr(
    not(any(feature = "built", feature = "compare")),
    allow(dead_code, reason = "the build script calls it")
)]
mod settings;

use cortex_m_rt::entry;

#[entry]
fn main() -> ! {
    #[cfg(feature = "compare")]
    compare::run();
    #[cfg(not(any(feature = "empty", feature = "compare")))]
    run::run();
    loop {
        cortex_m::asm::nop();
    }
}

#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {
        cortex_m::asm::nop();
    }
}
