//! The numbers of the parameters, and their names.

use core::ffi::CStr;

/// The kind of value that a parameter takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A number.
    Value,
    /// Lowest and highest.
    Range,
}

/// A parameter.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// Its constant in the header, without the prefix.
    pub constant: &'static str,
    /// Its number.
    pub number: i32,
    /// Its name as the core has it.
    pub name: &'static CStr,
    /// The kind of its value.
    pub kind: Kind,
}

macro_rules! parameters {
    ($($number:literal $constant:ident $name:literal $kind:ident)*) => {
        $(
            #[doc = concat!("Number of `", stringify!($name), "`.")]
            pub const $constant: i32 = $number;
        )*

        /// All of them.
        pub const ROWS: &[Row] = &[$(Row {
            constant: stringify!($constant),
            number: $number,
            name: $name,
            kind: Kind::$kind,
        }),*];
    };
}

parameters! {
    1 SAMPLE_TIME c"sample_time" Value
    2 RESOLUTION c"resolution" Value
    3 CUTOFF c"cutoff" Value
    4 KP c"kp" Value
    5 KD c"kd" Value
    6 KI c"ki" Value
    7 LIMIT c"limit" Range
    8 INITIAL_A c"initial.a" Value
    9 INITIAL_B c"initial.b" Value
    10 INITIAL_COULOMB c"initial.coulomb" Value
    11 INITIAL_LOAD c"initial.load" Value
    12 KNOWN_A c"known.a" Value
    13 KNOWN_B c"known.b" Value
    14 KNOWN_COULOMB c"known.coulomb" Value
    15 KNOWN_LOAD c"known.load" Value
    16 BOUNDS_A c"bounds.a" Range
    17 BOUNDS_B c"bounds.b" Range
    18 BOUNDS_COULOMB c"bounds.coulomb" Range
    19 BOUNDS_LOAD c"bounds.load" Range
    20 UNCERTAINTY_A c"uncertainty.a" Value
    21 UNCERTAINTY_B c"uncertainty.b" Value
    22 UNCERTAINTY_COULOMB c"uncertainty.coulomb" Value
    23 UNCERTAINTY_LOAD c"uncertainty.load" Value
    24 GAMMA_A c"gamma.a" Value
    25 GAMMA_B c"gamma.b" Value
    26 GAMMA_COULOMB c"gamma.coulomb" Value
    27 GAMMA_LOAD c"gamma.load" Value
    28 CORRECTION_KP c"correction.kp" Value
    29 CORRECTION_KD c"correction.kd" Value
    30 CORRECTION_KI c"correction.ki" Value
    31 PLANT_BOX_A c"plant_box.a" Range
    32 PLANT_BOX_B c"plant_box.b" Range
    33 MU c"mu" Value
    34 BANDWIDTH c"bandwidth" Value
    35 START_TIME c"start_time" Value
    36 MEMORY c"memory" Value
    37 NOISE c"noise" Value
    38 MAX_SPEED c"max_speed" Value
    39 RANGES_ERROR c"ranges.error" Value
    40 RANGES_VELOCITY c"ranges.velocity" Value
    41 RANGES_COMMAND c"ranges.command" Value
    42 COMMAND c"command" Value
    43 COMMAND_DELAY c"command_delay" Value
    44 RESPONSE_TIME c"response_time" Value
    45 LOOP_BANDWIDTH c"loop_bandwidth" Value
    46 MAX_SENSITIVITY c"max_sensitivity" Value
    47 MAX_NOISE c"max_noise" Value
    48 STEP c"step" Value
    49 RESONANCE c"resonance" Value
    50 TRAVEL c"travel" Range
    51 SPEED c"speed" Value
    52 DURATION c"duration" Value
    54 MAX_GAIN c"max_gain" Value
    55 TRIAL_STEP c"trial_step" Value
    56 REFERENCE_FILTER c"reference_filter" Value
    57 FEED_FORWARD_BANDWIDTH c"feed_forward_bandwidth" Value
    58 FEED_FORWARD_ACCELERATION c"feed_forward_acceleration" Value
    59 FEED_FORWARD_VELOCITY c"feed_forward_velocity" Value
    60 FEED_FORWARD_COULOMB c"feed_forward_coulomb" Value
    61 FEED_FORWARD_COULOMB_SPEED c"feed_forward_coulomb_speed" Value
    62 FEED_FORWARD c"feed_forward" Value
    63 NOTCH c"notch" Value
}

/// The places of all parameters, with room.
pub(crate) const PLACES: usize = 64;

/// The parameter of a number.
pub(crate) fn row(number: i32) -> Option<&'static Row> {
    ROWS.iter().find(|row| row.number == number)
}

/// The numbers of the parameters that the core calls by a name: that one, or all of the group of that name.
pub(crate) fn numbers(name: &str) -> impl Iterator<Item = i32> {
    // The core names the ends of a range.
    let name = match name {
        "limit_low" | "limit_high" => "limit",
        other => other,
    };
    let called = name.as_bytes();
    ROWS.iter()
        .filter(move |row| {
            let own = row.name.to_bytes();
            own == called
                || own
                    .strip_prefix(called)
                    .is_some_and(|rest| rest.first() == Some(&b'.'))
        })
        .map(|row| row.number)
}
