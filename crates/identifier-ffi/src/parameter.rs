//! The names of the fields of `servo_id_settings`, for refusals.

use core::ffi::{CStr, c_char};
use core::ptr;

/// The fields by the names of the core. A name of a group is that of all of its fields.
pub const NAMES: &[&CStr] = &[
    c"sample_time",
    c"counts_per_revolution",
    c"resolution",
    c"cutoff",
    c"kp",
    c"kd",
    c"ki",
    c"limit",
    c"reference_filter",
    c"notch",
    c"feed_forward.bandwidth",
    c"feed_forward.acceleration",
    c"feed_forward.velocity",
    c"feed_forward.coulomb",
    c"feed_forward.coulomb_speed",
    c"initial",
    c"initial.a",
    c"initial.b",
    c"initial.coulomb",
    c"initial.load",
    c"bounds",
    c"bounds.a",
    c"bounds.b",
    c"bounds.coulomb",
    c"bounds.load",
    c"uncertainty",
    c"uncertainty.a",
    c"uncertainty.b",
    c"uncertainty.coulomb",
    c"uncertainty.load",
    c"gamma",
    c"gamma.a",
    c"gamma.b",
    c"gamma.coulomb",
    c"gamma.load",
    c"correction",
    c"correction.kp",
    c"correction.kd",
    c"correction.ki",
    c"servo_range",
    c"servo_range.a",
    c"servo_range.b",
    c"mu",
    c"bandwidth",
    c"start_time",
    c"memory",
    c"noise",
    c"max_speed",
    c"ranges",
    c"ranges.error",
    c"ranges.velocity",
    c"ranges.command",
    c"command",
    c"command_delay",
    c"response_time",
    c"loop_bandwidth",
    c"max_sensitivity",
    c"max_noise",
    c"step",
    c"resonance",
    c"travel",
    c"speed",
    c"duration",
    c"max_gain",
    c"trial_step",
];

/// The field of a parameter of the core; null for none.
pub(crate) fn field(name: &str) -> *const c_char {
    let name = match name {
        "controller" => "kp",
        "limit_low" | "limit_high" => "limit",
        name => name,
    };
    let found = NAMES.iter().find(|own| own.to_bytes() == name.as_bytes());
    found.map_or(ptr::null(), |own| own.as_ptr())
}
