//! The reason without gains has the core's text and figures.

use drive_link::NoGains;
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::tuning::{Cap, TuningError};

#[test]
fn its_text_and_figures_are_those_of_the_core() {
    for error in [
        TuningError::TooFast {
            bandwidth: 500.0,
            most: 312.5,
            cap: Cap::EncoderNoise,
        },
        TuningError::NotKnown,
        TuningError::DoesNotArrive,
    ] {
        assert_eq!(NoGains::from(&error).to_string(), error.to_string());
    }
    let error = TuningError::OutOfRange(OutOfRange {
        parameter: "command",
        value: -0.5,
        allowed: Allowed::Above(0.0),
    });
    let says = NoGains::from(&error).to_string();
    assert_eq!(
        says,
        "command = -0.5 is not allowed: it must be from 0 to inf"
    );
}
