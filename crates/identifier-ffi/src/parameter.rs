//! The names of the fields of `servo_id_settings`, for refusals.

use core::ffi::{CStr, c_char};
use core::ptr;

use crate::settings::Settings;

/// The fields of the structures in the settings, by the structures' names.
macro_rules! parts {
    ($($group:literal: $($part:literal)*;)*) => {
        /// Their names.
        pub const PARTS: &[&CStr] = &[$($(name(concat!($group, ".", $part, "\0")),)*)*];
    };
}

parts! {
    "feed_forward": "bandwidth" "acceleration" "velocity" "coulomb" "coulomb_speed";
    "initial": "a" "b" "coulomb" "load";
    "bounds": "a" "b" "coulomb" "load";
    "uncertainty": "a" "b" "coulomb" "load";
    "gamma": "a" "b" "coulomb" "load";
    "correction": "kp" "kd" "ki";
    "servo_range": "a" "b";
    "ranges": "error" "velocity" "command";
}

/// A name for C, of a text that ends with a zero.
pub(crate) const fn name(text: &'static str) -> &'static CStr {
    match CStr::from_bytes_with_nul(text.as_bytes()) {
        Ok(name) => name,
        Err(_) => panic!("no zero at its end"),
    }
}

/// The field of a parameter of the core; null for none.
pub(crate) fn field(name: &str) -> *const c_char {
    let name = match name {
        "controller" => "kp",
        "limit_low" | "limit_high" => "limit",
        name => name,
    };
    let mut names = Settings::NAMES.iter().chain(PARTS);
    let found = names.find(|own| own.to_bytes() == name.as_bytes());
    found.map_or(ptr::null(), |own| own.as_ptr())
}
