//! Statuses: zero and above for success, where the number is the event of a sample; below zero for refusals.

use core::ffi::{CStr, c_char};
use core::ptr;

use identifier_core::error::{Allowed, OutOfRange, StepError};
use identifier_core::settings::{GainError, SettingsError};
use identifier_core::tuning::TuningError;

use crate::settings::field;

/// A status: its constant in the header, its number, and a sentence.
#[derive(Debug, Clone, Copy)]
pub struct StatusRow {
    /// Its constant in the header, without the prefix.
    pub constant: &'static str,
    /// Its number.
    pub number: i32,
    /// A sentence for people.
    pub text: &'static CStr,
}

macro_rules! statuses {
    ($($number:literal $constant:ident $text:literal)*) => {
        $(
            #[doc = concat!("Status ", $number, ".")]
            pub const $constant: i32 = $number;
        )*

        /// All of them.
        pub const ROWS: &[StatusRow] = &[$(StatusRow {
            constant: stringify!($constant),
            number: $number,
            text: $text,
        }),*];
    };
}

statuses! {
    0 OK c"done"
    1 SLOWED c"the guard shortened the step of the estimator"
    2 STANDING c"no adaptation: the servo is at standstill"
    3 RESTARTED c"the model had left the range of the number format and was restarted; the estimates are kept"
    4 STARTED c"a first fit succeeded, and the recursion starts from it"
    5 LOAD_STEP c"a load step was found, and the load is estimated anew"
    6 TERM_ENTERED c"an optional term is now part of the model"
    7 FRICTION_LOWERED c"the servo moves where the friction of the model would hold it: the friction estimate was \
                         lowered"
    8 AT_BOUND c"a fit was stopped by a bound: the last result stays"
    9 NOT_FOLLOWING c"the servo does not follow its command: amplifier off, or a limit that the command does not contain"
    10 FIRST_FIT_OVERDUE c"no first fit has succeeded after a second of motion"
    20 PENDING c"work is left: call the function again"
    21 DECIDED c"the background has a decision for the interrupt: take it"
    -1 NULL_POINTER c"an address is null"
    -2 MISALIGNED c"an address is not a multiple of the alignment of its type"
    -3 TOO_SMALL c"the storage is smaller than the header says: are header and library of one version?"
    -4 NOT_INITIALISED c"the object is not initialised, or its initialisation failed"
    -5 NO_SUCH_NUMBER c"no status or reason has this number"
    -10 OUT_OF_RANGE c"the value of a parameter is not allowed"
    -11 NOT_GIVEN c"a parameter without a default was not given"
    -12 GAMMA c"gamma is not positive definite"
    -13 NO_MOTION c"the reference does not move the servo, so no gamma follows from it"
    -14 CERTIFICATE c"the gains are not certified for the whole parameter range"
    -15 LOOP_UNSTABLE c"the sampled loop is unstable for a servo of the parameter range"
    -16 ESTIMATE_UNSTABLE c"the correction is unstable for an estimate that the bounds allow"
    -17 NOT_SUPPORTED c"the identifier does not have the requested feature"
    -20 ERROR_NOT_FINITE c"the position error is not a finite number: check the setpoint"
    -21 TOO_FAR_APART c"the setpoint is further from the position than the number format counts exactly"
    -22 COUNT_JUMPED c"the position has jumped further than the servo can move in a sample: check the encoder"
    -23 COMMAND_NOT_FINITE c"the command that acted is not a finite number"
    -24 SAMPLE_REFUSED c"the sample was refused"
    -25 NO_SAMPLE c"no new sample: call control first, once before each call"
    -30 NO_FIT c"nothing is fitted yet: the motion has too little information so far"
    -31 NO_STANDARD_ERRORS c"the estimator has no standard errors"
    -40 TOO_FAST c"no gains reach the goal within the margins"
    -41 NOT_KNOWN c"the estimates are too uncertain: no gains keep the margins"
    -42 DOES_NOT_ARRIVE c"the step does not arrive: friction holds the servo, or gravity is faster"
    -50 CONSTANTS_VERSION c"the constants were exported for another version of the library: export them again"
    -51 CONSTANTS_TYPE c"the constants are those of another object"
    -52 CONSTANTS_CHANGED c"the constants were changed, or are not complete: export them again"
}

/// A refusal: `servo_id_error` in the header.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct Error {
    /// The status.
    pub status: i32,
    /// The kind of the range that is allowed: [`ALLOWED`].
    pub allowed: i32,
    /// The value that was refused.
    pub value: f64,
    /// The range that is allowed, as its kind says.
    pub low: f64,
    /// The other end.
    pub high: f64,
    /// The field of the settings, null for none.
    pub parameter: *const c_char,
}

/// Kinds of ranges by number.
pub const ALLOWED: &[(&str, i32)] = &[
    ("ALLOWED_UNKNOWN", 0),
    ("ALLOWED_FINITE", 1),
    ("ALLOWED_ABOVE", 2),
    ("ALLOWED_AT_LEAST", 3),
    ("ALLOWED_BELOW", 4),
    ("ALLOWED_AT_MOST", 5),
    ("ALLOWED_BETWEEN", 6),
    ("ALLOWED_WITHIN", 7),
    ("ALLOWED_POSITIVE_UP_TO", 8),
    ("ALLOWED_MULTIPLE_OF", 9),
];

impl Error {
    /// A status alone.
    pub(crate) const fn of(status: i32) -> Self {
        Self {
            status,
            allowed: 0,
            value: 0.0,
            low: 0.0,
            high: 0.0,
            parameter: ptr::null(),
        }
    }

    /// A parameter that has no default.
    pub(crate) fn not_given(name: &str) -> Self {
        Self {
            parameter: field(name),
            ..Self::of(NOT_GIVEN)
        }
    }

    /// A value out of the range that it has here.
    pub(crate) fn about(status: i32, error: &OutOfRange) -> Self {
        let inf = f64::INFINITY;
        let (allowed, low, high) = match error.allowed {
            Allowed::Finite => (1, -inf, inf),
            Allowed::Above(low) => (2, low, inf),
            Allowed::AtLeast(low) => (3, low, inf),
            Allowed::Below(high) => (4, -inf, high),
            Allowed::AtMost(high) => (5, -inf, high),
            Allowed::Between(low, high) => (6, low, high),
            Allowed::Within(low, high) => (7, low, high),
            Allowed::PositiveUpTo(high) => (8, 0.0, high),
            Allowed::MultipleOf(step) => (9, step, inf),
        };
        Self {
            status,
            allowed,
            value: error.value,
            low,
            high,
            parameter: field(error.parameter),
        }
    }

    /// Gains that cannot be found.
    pub(crate) fn tuning(error: &TuningError) -> Self {
        match *error {
            TuningError::OutOfRange(error) => Self::about(OUT_OF_RANGE, &error.renamed(of_loop)),
            TuningError::TooFast {
                bandwidth, most, ..
            } => Self::too_fast(bandwidth, most),
            TuningError::NotKnown => Self::of(NOT_KNOWN),
            TuningError::DoesNotArrive => Self::of(DOES_NOT_ARRIVE),
        }
    }

    /// A goal that no gains reach.
    pub(crate) fn too_fast(bandwidth: f64, most: f64) -> Self {
        let most = Allowed::AtMost(most);
        Self::about(
            TOO_FAST,
            &OutOfRange::new("loop_bandwidth", bandwidth, most),
        )
    }
}

/// The field of a setting of a tuning or a commissioning: `bandwidth` is that of the identifier.
pub(crate) fn of_loop(name: &'static str) -> &'static str {
    if name == "bandwidth" {
        "loop_bandwidth"
    } else {
        name
    }
}

impl From<SettingsError> for Error {
    /// Settings that cannot be built.
    fn from(error: SettingsError) -> Self {
        match error {
            SettingsError::Range(ref error) if error.parameter.starts_with("gamma.") => {
                Self::about(GAMMA, error)
            }
            SettingsError::Range(ref error) => Self::about(OUT_OF_RANGE, error),
            SettingsError::NotGiven { setting } => Self::not_given(setting),
            SettingsError::NoGamma(GainError::AtRest) => Self::of(NO_MOTION),
            SettingsError::NoGamma(_) => Self::of(LOOP_UNSTABLE),
            SettingsError::Certificate(error) => Self::about(CERTIFICATE, &error.out_of_range()),
            SettingsError::SampledLoop(sampled) => Self {
                parameter: field("servo_range.b"),
                value: sampled.b,
                ..Self::of(LOOP_UNSTABLE)
            },
            SettingsError::Estimate(error) => Self::about(ESTIMATE_UNSTABLE, &error.out_of_range()),
            SettingsError::NoSuchTerm { .. }
            | SettingsError::NoAmplifier { .. }
            | SettingsError::NotShaped { .. } => Self::of(NOT_SUPPORTED),
        }
    }
}

impl From<i32> for Error {
    fn from(status: i32) -> Self {
        Self::of(status)
    }
}

/// The status of a refused sample.
#[inline]
pub(crate) fn of_step(error: StepError) -> i32 {
    match error {
        StepError::ErrorNotFinite => ERROR_NOT_FINITE,
        StepError::TooFarApart => TOO_FAR_APART,
        StepError::CountJumped => COUNT_JUMPED,
        StepError::CommandNotFinite => COMMAND_NOT_FINITE,
        _ => SAMPLE_REFUSED,
    }
}
