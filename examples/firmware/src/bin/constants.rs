//! The same firmware with a loop that its build script has certified and built on the PC. It links only the samples,
//! without certificate and settings.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use firmware::{run, settings};
use identifier_core::constants::Constants;

/// Refused by the compiler if it is not what the build script wrote.
const CONSTANTS: Constants<settings::Loop> =
    match Constants::new(include!(concat!(env!("OUT_DIR"), "/words.rs"))) {
        Ok(constants) => constants,
        Err(error) => panic!("{}", error.remedy()),
    };

#[entry]
fn main() -> ! {
    let found = run(&CONSTANTS.build());
    servo::end(found.is_some_and(servo::is_found))
}
