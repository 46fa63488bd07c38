//! The chip itself certifies and builds the loop.
//!
//! ```sh
//! cargo build --release -p firmware --target thumbv7em-none-eabihf
//! ```
//!
//! (or `thumbv6m-none-eabi`, or `thumbv8m.main-none-eabihf`). Here the servo is simulated by a few lines, so the
//! example also runs in an emulator. It succeeds if the gain is found within 2 %.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use firmware::{run, settings};

#[entry]
fn main() -> ! {
    let found = settings::build().ok().and_then(|built| run(&built));
    servo::end(found.is_some_and(servo::is_found))
}
